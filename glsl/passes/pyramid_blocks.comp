#version 460
#extension GL_GOOGLE_include_directive : require
// The list of blocks of the picture that can hold something: a pixel of a block is made from texels of
// level 3 that are the block's own or touch it. Also the arguments of the passes over that list.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#include "lib/pyramid.glsl"
layout(local_size_x = STP_GROUP) in;

bool block_in_tile(ivec2 p)
{
    ivec2 first = ivec2(frame.grid_x, frame.grid_y) + p * STP_BLOCK - ivec2(frame.tile_x, frame.tile_y);
    return all(greaterThan(first + STP_BLOCK, ivec2(0))) &&
           all(lessThan(first, ivec2(frame.tile_width, frame.tile_height)));
}

void main()
{
    uvec2 size = uvec2(frame.grid_width, frame.grid_height) / STP_BLOCK;
    uint block = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex;
    ivec2 p = ivec2(block % size.x, block / size.x);
    bool touched = false;
    int reach = frame.block_reach, side = 2 * reach + 1;
    for (int i = 0; i < side * side && !touched; i++)
        touched = texel_valid(texel_load(STP_BLOCK_LEVEL, p + ivec2(i % side, i / side) - reach));
    if (block >= size.x * size.y)
        return;
    if (RIM_FAR && !touched && block_in_tile(p))
        frame.work.v[STP_WORK_FLAGS + block] = STP_BLOCK_BARE;
    if (!touched)
        return;
    uint slot = atomicAdd(frame.work.v[STP_WORK_BLOCKS + 3], 1);
    frame.work.v[list_place(TOUCHED, slot)] = block;
    count_groups(STP_WORK_BLOCKS, slot + 1);
    count_groups(STP_WORK_LEVEL_1, slot / 4 + 1);
    count_groups(STP_WORK_LEVEL_2, slot / 16 + 1);
}
