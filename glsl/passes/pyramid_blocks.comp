#version 460
#extension GL_GOOGLE_include_directive : require
// The list of blocks of the picture that can hold something: a pixel of a block is made from texels of
// level 3 that are the block's own or touch it. Also the arguments of the passes over that list.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
layout(local_size_x = STP_GROUP) in;

void main()
{
    uvec2 size = uvec2(frame.grid_width, frame.grid_height) / STP_BLOCK;
    uint block = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex;
    ivec2 p = ivec2(block % size.x, block / size.x);
    bool touched = false;
    int reach = frame.block_reach, side = 2 * reach + 1;
    for (int i = 0; i < side * side && !touched; i++)
        touched = texel_valid(texel_load(STP_BLOCK_LEVEL, p + ivec2(i % side, i / side) - reach));
    if (!touched || block >= size.x * size.y)
        return;
    uint slot = atomicAdd(frame.work.v[STP_WORK_BLOCKS + 3], 1);
    frame.work.v[list_place(TOUCHED, slot)] = block;
    count_groups(STP_WORK_BLOCKS, slot + 1);
    if (discs_far()) {
        count_groups(STP_WORK_FIND, slot + 1);
        frame.work.v[STP_WORK_FIND + 2] = 1;
    }
    count_groups(STP_WORK_LEVEL_1, slot / 4 + 1);
    count_groups(STP_WORK_LEVEL_2, slot / 16 + 1);
}
