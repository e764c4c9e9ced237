#version 460
#extension GL_GOOGLE_include_directive : require
// The list of touched blocks, for the passes that resolve. OVERFLOWED: of those that are repaired, which
// are few; a turn of mending would else go over the whole picture.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/lists.glsl"
layout(local_size_x = STP_GROUP) in;

#ifdef OVERFLOWED
const uint ARGUMENTS = STP_WORK_REPAIR_BLOCKS;
#else
const uint ARGUMENTS = STP_WORK_BLOCKS;
#endif

bool listed(uint block)
{
    uint flag = frame.work.v[STP_WORK_FLAGS + block];
#ifdef OVERFLOWED
    return flag == STP_BLOCK_OVERFLOWED;
#else
    return flag != 0;
#endif
}

#ifdef OVERFLOWED
// The fragments of its deep pixels, which exact_place finds room for; no more of a pixel than are too
// many, so that the sum fits.
void count_deep(uint block)
{
    uint sum = 0;
    for (uint i = 0; i < STP_GROUP; i++) {
        uint pixel = block * STP_GROUP + i;
        sum += deep(pixel) ? min(frame.counts.v[pixel], list_room()) : 0;
    }
    frame.work.v[list_block(block)] = sum;
}
#endif

void main()
{
    uint block = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex, count = frame.blocks_x * frame.blocks_y;
    if (block >= count || !listed(block))
        return;
    uint slot = atomicAdd(frame.work.v[STP_WORK_BLOCKS + 3], 1);
    atomicMax(frame.work.v[ARGUMENTS], min(slot + 1, STP_ROW));
    atomicMax(frame.work.v[ARGUMENTS + 1], slot / STP_ROW + 1);
    frame.work.v[STP_WORK_FLAGS + count + slot] = block;
#ifdef OVERFLOWED
    if (OPACITY != 0)
        count_deep(block);
#endif
}
