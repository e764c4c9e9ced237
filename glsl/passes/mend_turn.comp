#version 460
#extension GL_GOOGLE_include_directive : require
// Before a turn of mending: when the last one left no ray unfinished, this one does nothing.
#include "lib/common.glsl"
layout(local_size_x = 1) in;

void main()
{
    if (frame.work.v[STP_WORK_REMAINING] == 0) {
        frame.work.v[STP_WORK_REPAIR] = 0;
        frame.work.v[STP_WORK_REPAIR_L] = 0;
        frame.work.v[STP_WORK_REPAIR_BLOCKS] = 0;
    }
    frame.work.v[STP_WORK_REMAINING] = 0;
}
