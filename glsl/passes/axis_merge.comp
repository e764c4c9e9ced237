#version 460
#extension GL_GOOGLE_include_directive : require
// HM Eq. 1: C = sum C_n w_n^2 / sum w_n^2 over the walks, w from the pixel's own ray. The dominant
// axis has w = 1, so that the divisor is at least 1.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/environment.glsl"
layout(local_size_x = STP_GROUP) in;

#if !defined(EMPTY) && !defined(FROM_SUMS)
layout(set = 0, binding = STP_BINDING_AXIS_COLOR, rgba32f) uniform readonly image2DArray walk_color;
layout(set = 0, binding = STP_BINDING_AXIS_DEPTH, rg32f) uniform readonly image2DArray walk_depth;
#endif

#ifndef EMPTY
vec3 world_ray(vec2 pixel)
{
    const float r[9] = frame.rotation;
    vec2 d = (pixel - vec2(frame.center[0], frame.center[1])) *
             vec2(frame.inv_focal[0], frame.inv_focal[1]);
    vec3 v = ORTHOGRAPHIC ? vec3(0, 0, 1) : vec3(d, 1);
    return vec3(r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
                r[2] * v.x + r[5] * v.y + r[8] * v.z);
}

float weight(uint walk, vec3 v)
{
    vec3 size = abs(v);
    float most = max(size.x, max(size.y, size.z));
    uint axis = walk & 3, dominant = size.x == most ? 0 : size.y == most ? 1 : 2;
    float own = (walk & 4) != 0 ? -v[axis] : v[axis];
    if (frame.axis.merge == STP_AXIS_MERGE_CLIP)
        return axis == dominant && own > 0 ? 1 : 0;
    if (frame.axis.merge != STP_AXIS_MERGE_BLEND)
        return 1;
    return max(own / most - frame.axis.h, 0) / (1 - frame.axis.h);
}
#endif

void main()
{
    uvec2 p;
    uint block = workgroup_index();
    if (block >= frame.blocks_x * frame.blocks_y ||
        !block_pixel(block, gl_LocalInvocationIndex, p))
        return;
    uint at = p.y * frame.tile_width + p.x;
    vec4 color = vec4(0);
    float depth = 0;
#ifndef EMPTY
    vec3 v = world_ray(vec2(p) + 0.5 + vec2(frame.tile_x, frame.tile_y));
    float sum = 0;
    for (uint n = 0; n < AXIS_WALKS; n++) {
        float w = weight(frame.axis.walk[n], v);
        w *= w;
        sum += w;
#ifdef FROM_SUMS
        uint from = 2 * ((n * frame.blocks_x * frame.blocks_y + block) * STP_GROUP +
                         gl_LocalInvocationIndex);
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
    if (ELLIPSOIDS) { // a surface: what covers half of a ray or more is all there is of it
        float scale = color.w > 0 ? min(1, 2 * color.w) / color.w : 0;
        color *= scale;
        depth *= scale;
    }
#endif
    frame.out_depth.v[at] = color.w > 0 ? depth / color.w : 1.0 / 0.0;
    frame.out_normal.v[at] = vec3(0);
    if (BACKGROUND)
        color += (1 - color.w) * background_at(pixel_position(p));
    frame.out_color.v[at] = color;
}
