#version 460
#extension GL_GOOGLE_include_directive : require
// The open pixels: what the nearest disc from afar shows, where one reached them and, if they have a
// point of their own, hides that.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
#define SURFACE_OBJECT(s) surface_object
uint surface_object;
#include "lib/shade.glsl"
#include "lib/own.glsl"
#include "lib/push.glsl"
#include "lib/rim_surface.glsl"
layout(local_size_x_id = 22) in;

// False: the pixel stays as it is; of one that a disc had to cover, and none did, nothing stays. reached: that a disc shows, or its own point; else nothing does.
bool settle(uvec2 p, uvec2 pixel, uvec2 key, out bool reached, out ivec2 point, out float depth)
{
    reached = key.x < STP_RIM_NONE;
    uint from = reached ? key.x - STP_RIM : 0;
    point = reached ? ivec2(from % frame.grid_width, from / frame.grid_width) : ivec2(p);
    depth = depth_ordered(key.y);
    Texel own = texel_load(0, ivec2(p));
    float mean = rim_mean(pixel), reach = depth + texel_load(0, point).radius;
    if (!texel_valid(own))
        return reached ? !(mean <= reach) : mean < NOTHING && key.y == STP_RIM_DEPTH;
    float depth_own = own_depth(own, rim_position(p));
    bool hidden = reached && depth_own > reach;
    reached = true;
    point = hidden ? point : ivec2(p);
    depth = hidden ? depth : depth_own;
    return hidden || SAMPLE_GRID > 1; // else the push has written it
}

// A thread's pixels up to the next that changes.
void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_OPEN + 3])
        return;
    uint block = listed_block(OPEN, index);
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    uvec2 tile = uvec2(ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y));
    uvec2 open = uvec2(frame.work.v[open_word(block, 0)], frame.work.v[open_word(block, 1)]);
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP;) {
        bool changes = false, reached = false;
        uvec2 p = corner;
        ivec2 point = ivec2(0);
        float depth = 0;
        for (; i < STP_GROUP && !changes; i += gl_WorkGroupSize.x) {
            if (any(notEqual(open & open_bit(i), uvec2(0)))) {
                p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
                uvec2 key = unpackUint2x32(frame.keys.v[block * STP_GROUP + i]);
                changes = settle(p, p - tile, key, reached, point, depth);
            }
        }
        if (changes)
            rim_write(ivec2(p), p - tile, rim_position(p), reached, point, depth);
    }
}
