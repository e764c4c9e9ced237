#version 460
#extension GL_GOOGLE_include_directive : require
// The background where nothing is; behind what does not cover the whole pixel, or lets light through.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define ALL_BLOCKS
#define IN_ROWS
#include "lib/resolve.glsl"
#include "lib/environment.glsl"

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    uint at = p.y * frame.tile_width + p.x;
    vec4 background = background_at(vec2(p + uvec2(frame.tile_x, frame.tile_y)) + 0.5);
    if (SAMPLE_GRID > 1 || OPACITY != 0 || DISCS)
        frame.out_color.v[at] += (1 - frame.out_color.v[at].w) * background;
    else if (isinf(frame.out_depth.v[at]))
        frame.out_color.v[at] = background;
}
