#version 460
#extension GL_GOOGLE_include_directive : require
// The list of touched blocks, for the passes that resolve.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
layout(local_size_x = STP_GROUP) in;

void main()
{
    uint block = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex, count = frame.blocks_x * frame.blocks_y;
    if (block >= count || frame.work.v[STP_WORK_FLAGS + block] == 0)
        return;
    uint slot = atomicAdd(frame.work.v[STP_WORK_BLOCKS + 3], 1);
    atomicMax(frame.work.v[STP_WORK_BLOCKS], min(slot + 1, STP_ROW));
    atomicMax(frame.work.v[STP_WORK_BLOCKS + 1], slot / STP_ROW + 1);
    frame.work.v[STP_WORK_FLAGS + count + slot] = block;
}
