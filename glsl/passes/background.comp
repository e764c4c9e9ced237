#version 460
#extension GL_GOOGLE_include_directive : require
// The background where nothing is.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define ALL_BLOCKS
#include "lib/resolve.glsl"

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    uint at = p.y * frame.tile_width + p.x;
    if (isinf(frame.out_depth.v[at]))
        frame.out_color.v[at] = vec4(frame.background[0], frame.background[1], frame.background[2],
                                     frame.background[3]);
}
