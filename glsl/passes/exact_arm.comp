#version 460
#extension GL_GOOGLE_include_directive : require
// When a pixel overflowed its slots: the arguments of the repair passes.
#include "lib/common.glsl"
layout(local_size_x = 1) in;

void main()
{
    if (frame.work.v[STP_WORK_OVERFLOW] == 0)
        return;
    uint groups = (frame.splat_count + STP_GROUP - 1) / STP_GROUP;
    frame.work.v[STP_WORK_COLLECT] = min(groups, STP_ROW);
    frame.work.v[STP_WORK_COLLECT + 1] = (groups + STP_ROW - 1) / STP_ROW;
    for (uint i = 0; i < 2; i++)
        frame.work.v[STP_WORK_REPAIR_L + i] = frame.work.v[STP_WORK_LARGE + i];
    groups = (frame.blocks_x * frame.blocks_y + STP_GROUP - 1) / STP_GROUP;
    frame.work.v[STP_WORK_SEEK] = min(groups, STP_ROW);
    frame.work.v[STP_WORK_SEEK + 1] = (groups + STP_ROW - 1) / STP_ROW;
    frame.work.v[STP_WORK_BLOCKS + 3] = 0; // the list is made anew
}
