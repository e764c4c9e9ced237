#version 460
#extension GL_GOOGLE_include_directive : require
// The list of touched blocks, for the passes that resolve.
#include "lib/common.glsl"
layout(local_size_x = STP_GROUP) in;

void main()
{
    uint block = gl_GlobalInvocationID.x, count = frame.blocks_x * frame.blocks_y;
    if (block >= count || frame.work.v[STP_WORK_FLAGS + block] == 0)
        return;
    uint slot = atomicAdd(frame.work.v[STP_WORK_BLOCKS], 1);
    frame.work.v[STP_WORK_FLAGS + count + slot] = block;
}
