#version 460
#extension GL_GOOGLE_include_directive : require
// Before layers are peeled by the rasteriser: where the nearest opaque fragment ends each pixel's ray.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define ALL_BLOCKS
#define IN_ROWS
#include "lib/resolve.glsl"
layout(set = 0, binding = 1, rg32ui) uniform readonly uimage2DArray nearest_image;

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    uvec2 first = imageLoad(nearest_image, ivec3(p, 0)).xy;
    frame.limits.v[p.y * frame.tile_width + p.x] =
        first.y == STP_NO_ID ? 0x7f800000u : depth_order(uintBitsToFloat(first.x));
}
