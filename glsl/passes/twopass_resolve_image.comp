#version 460
#extension GL_GOOGLE_include_directive : require
// Normalisation and deferred shading of the rasteriser's sums. Of a transparent scene, of
// one more layer.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define IN_ROWS
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#define RESOLVES
#include "lib/peel.glsl"

layout(set = 0, binding = 1, rg32ui) uniform readonly uimage2DArray nearest_image;
layout(set = 0, binding = 3, rgba32f) uniform readonly image2DArray sum_image;
layout(set = 0, binding = 4, rg32f) uniform readonly image2DArray depth_image;
#ifdef WITH_COLOR
layout(set = 0, binding = 5, rgba32f) uniform readonly image2DArray color_image;
#endif

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    ivec3 at = ivec3(p, 0);
    uvec2 first = imageLoad(nearest_image, at).xy;
    vec4 sum = imageLoad(sum_image, at);
    vec2 above = imageLoad(depth_image, at).xy;
    bool hit = first.y != STP_NO_ID;
    Surface s;
    s.id = first.y;
    s.near_depth = uintBitsToFloat(first.x);
    s.weight = sum.w;
    s.normal = sum.xyz;
    s.depth = s.near_depth + above.x / sum.w * (hit ? object_epsilon(s.id) : 0);
    s.fragments = uint(above.y);
    s.albedo = vec3(0);
#ifdef WITH_COLOR
    s.albedo = imageLoad(color_image, at).xyz;
#endif
    s.near_normal = normal_again(hit ? s.id : 0, p);
    if (!PEEL) {
        surface_write(p, hit, s);
        return;
    }
    float alpha = splat_opacity(s.id);
#ifdef WITH_COLOR
    if (OPACITY == 2 && s.weight > 0)
        alpha = imageLoad(color_image, at).w / s.weight;
#endif
    peel_write(p, p.y * frame.tile_width + p.x, hit, s, alpha);
}
