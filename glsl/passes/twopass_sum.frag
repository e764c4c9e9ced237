#version 460
#extension GL_GOOGLE_include_directive : require
// Point blending: weighted sums of what lies within epsilon of the nearest, in primitive order.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/peel.glsl"
#define FRAGMENT
#include "lib/varying.glsl"
#include "lib/light.glsl"

layout(set = 0, binding = 1, rg32ui) uniform readonly uimage2DArray nearest_image;

layout(location = 0) out vec4 sum;
layout(location = 1) out vec2 depth_sum; // above the nearest over epsilon, and a count
layout(location = 2) out vec4 color_sum;

void main()
{
    Fragment f = fragment_here();
    uvec2 first = imageLoad(nearest_image, ivec3(gl_FragCoord.xy, 0)).xy;
    float nearest = uintBitsToFloat(first.x), epsilon = object_epsilon(first.y);
    uvec2 p = uvec2(gl_FragCoord.xy);
    if (f.depth > nearest + epsilon ||
        peel_other(p.y * frame.tile_width + p.x, vary_id, f.depth, first.y))
        discard;
    float w = kernel_weight(f.rho2);
    vec3 n = normal_here(f);
    sum = vec4(w * n, w);
    depth_sum = vec2(w * (f.depth - nearest) / epsilon, 1);
    vec2 at = gl_FragCoord.xy + vec2(frame.tile_x, frame.tile_y);
    if (SHADE == 1)
        color_sum = vec4(w * shade_fragment(vary_id, n, at, f.depth), w);
    else
        color_sum = HAS_COLOR ? vec4(w * frame.colors.v[vary_id], w) : vec4(0);
    if (PEEL)
        color_sum.w = w * splat_opacity(vary_id);
}
