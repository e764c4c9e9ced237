// A merged pixel of the axis method into the picture, over the background.
#include "lib/environment.glsl"

// Premultiplied colour; depth weighted as alpha is. p relative to the tile.
void axis_output(uvec2 p, vec4 color, float depth)
{
    uint at = p.y * frame.tile_width + p.x;
    if (ELLIPSOIDS || (DISCS && OPACITY == 0)) { // what covers half of a ray or more is all of it
        float scale = color.w > 0 ? min(1, 2 * color.w) / color.w : 0;
        color *= scale;
        depth *= scale;
    }
    color.w = min(color.w, 1); // a mean of ones may round to more
    frame.out_depth.v[at] = color.w > 0 ? depth / color.w : 1.0 / 0.0;
    frame.out_normal.v[at] = vec3(0);
    if (BACKGROUND && !DISCS) // of those it follows, after the eye dome
        color += (1 - color.w) * background_at(pixel_position(p));
    frame.out_color.v[at] = color;
}

// Where a pixel's sums of one walk lie, where a walk takes several passes.
uint axis_sum(uvec2 p, uint walk)
{
    uint pixels = frame.blocks_x * frame.blocks_y * (STP_BLOCK * STP_BLOCK);
    return 2 * (walk * pixels + pixel_index(p));
}
