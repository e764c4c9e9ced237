#version 460
#extension GL_GOOGLE_include_directive : require
// The pixels that points round about reached.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
#define SURFACE_OBJECT(s) surface_object
uint surface_object;
#include "lib/shade.glsl"
#include "lib/push.glsl"
#include "lib/rim_surface.glsl"
layout(local_size_x_id = 22) in;

void shade_pixel(uvec2 p, uvec2 pixel, uint state, float depth)
{
    uint from = state - STP_RIM;
    ivec2 point = ivec2(from % frame.grid_width, from / frame.grid_width);
    surface_write(pixel, true, rim_surface(ivec2(p), rim_position(p), point, depth));
}

void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_BLOCKS + 3])
        return;
    uint block = touched_block(index);
    bool empties = frame.work.v[STP_WORK_FLAGS + block] != 0;
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    uvec2 tile = uvec2(ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y));
    for (uint i = gl_LocalInvocationIndex; i < (empties ? STP_GROUP : 0); i += gl_WorkGroupSize.x) {
        uvec2 key = unpackUint2x32(frame.keys.v[block * STP_GROUP + i]);
        uvec2 p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
        // Only pixels of the tile were ever marked.
        if (key.x >= STP_RIM && key.x < STP_RIM_NONE)
            shade_pixel(p, p - tile, key.x, depth_ordered(key.y));
    }
}
