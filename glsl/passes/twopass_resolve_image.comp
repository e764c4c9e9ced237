#version 460
#extension GL_GOOGLE_include_directive : require
// Normalisation and deferred shading of the rasteriser's sums. PEEL: of one layer of several.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define ALL_BLOCKS
#include "lib/resolve.glsl"
#include "lib/shade.glsl"

layout(set = 0, binding = 1, rg32ui) uniform readonly uimage2DArray nearest_image;
layout(set = 0, binding = 3, rgba32f) uniform readonly image2DArray sum_image;
layout(set = 0, binding = 4, rg32f) uniform readonly image2DArray depth_image;
#ifdef WITH_COLOR
layout(set = 0, binding = 5, rgba32f) uniform readonly image2DArray color_image;
#endif

#ifdef PEEL
// Puts one more layer behind those that the picture holds, and peels it off. Depth and the rest stay
// the first one's.
void peel_write(uvec2 p, bool hit, Surface s, float alpha)
{
    if (!hit)
        return;
    uint i = p.y * frame.tile_width + p.x;
    vec4 before = frame.out_color.v[i];
    bool first = isinf(frame.out_depth.v[i]);
    Look look = surface_look(p, hit, s);
    if (first)
        picture_write(p, hit, vec4(0), look, s, 0);
    frame.out_color.v[i] = before + (1 - before.w) * alpha * vec4(look.color, 1);
    if ((AOVS & 4) != 0 && before.w < 1)
        frame.out_id.v[ID_WORDS * i + ID_WORDS - 1]++;
    frame.nearest.v[i] = floatBitsToUint(s.near_depth + object_epsilon(s.id));
}
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
    Splat splat;
    splat_load(hit ? s.id : 0, splat);
    s.near_normal = splat.normal;
#ifdef PEEL
    float alpha = hit ? splat_opacity(s.id) : 0;
#ifdef WITH_COLOR
    alpha = s.weight > 0 ? imageLoad(color_image, at).w / s.weight : alpha;
#endif
    peel_write(p, hit, s, alpha);
#else
    surface_write(p, hit, s);
#endif
}
