#version 460
#extension GL_GOOGLE_include_directive : require
// Eye-dome shading (docs/numerics.md): depth alone makes the shape read where normals are unknown.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define ALL_BLOCKS
#define IN_ROWS
#include "lib/resolve.glsl"

float depth_at(ivec2 p, float none)
{
    bool inside = all(greaterThanEqual(p, ivec2(0))) &&
                  all(lessThan(p, ivec2(frame.tile_width, frame.tile_height)));
    float z = frame.out_depth.v[inside ? p.y * frame.tile_width + p.x : 0];
    return inside && !isinf(z) ? z : none;
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    uint at = p.y * frame.tile_width + p.x;
    float z = frame.out_depth.v[at];
    if (isinf(z))
        return;
    int reach = max(1, int(frame.height) / 512);
    float sum = 0;
    for (int i = 0; i < 9; i++) {
        ivec2 d = ivec2(i % 3 - 1, i / 3 - 1) * reach;
        float n = depth_at(ivec2(p) + d, z);
        sum += max(0, ORTHOGRAPHIC ? (z - n) * frame.eye_dome_scale : log2(z / n));
    }
    frame.out_color.v[at].xyz *= exp(-8 * (sum / 8));
}
