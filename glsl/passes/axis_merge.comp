#version 460
#extension GL_GOOGLE_include_directive : require
// HM Eq. 1: C = sum C_n w_n^2 / sum w_n^2 over the walks, w from the pixel's own ray. The dominant
// axis has w = 1, so that the divisor is at least 1.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/axis.glsl"
#include "lib/axis_output.glsl"
layout(local_size_x = STP_GROUP) in;

#if !defined(EMPTY) && !defined(FROM_SUMS)
layout(set = 0, binding = STP_BINDING_AXIS_COLOR, rgba32f) uniform readonly image2DArray walk_color;
layout(set = 0, binding = STP_BINDING_AXIS_DEPTH, rg32f) uniform readonly image2DArray walk_depth;
#endif

void main()
{
    uvec2 p;
    uint block = workgroup_index();
    if (block >= frame.blocks_x * frame.blocks_y ||
        !block_pixel(block, gl_LocalInvocationIndex, p))
        return;
    vec4 color = vec4(0);
    float depth = 0;
#ifndef EMPTY
    vec3 v = axis_world_ray(vec2(p) + 0.5 + vec2(frame.tile_x, frame.tile_y));
    float sum = 0;
    for (uint n = 0; n < AXIS_WALKS; n++) {
        float w = axis_weight(frame.axis.walk[n], v);
        w *= w;
        sum += w;
#ifdef FROM_SUMS
        uint from = axis_sum(p, n);
        vec4 one = frame.axis_sums.v[from];
        color += w * vec4(one.xyz, 1 - one.w);
        depth += w * frame.axis_sums.v[from + 1].x;
#else
        color += w * imageLoad(walk_color, ivec3(p, n));
        depth += w * imageLoad(walk_depth, ivec3(p, n)).x;
#endif
    }
    if (sum > 0) {
        color /= sum;
        depth /= sum;
    }
#endif
    axis_output(p, color, depth);
}
