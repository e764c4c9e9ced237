#version 460
#extension GL_GOOGLE_include_directive : require
// The slots of an overflowed pixel become its sums.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/resolve.glsl"

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel) || frame.counts.v[pixel] <= STP_SLOTS)
        return;
    for (uint i = 0; i < STP_SUM_WORDS; i++)
        frame.keys.v[slot_index(pixel, i)] = i == 0 ? STP_SUMS_NONE : 0ul;
}
