#version 460
#extension GL_GOOGLE_include_directive : require
// Sums to zero, nearest to none.
#include "lib/common.glsl"
layout(local_size_x = STP_GROUP) in;

void main()
{
    uint at = (gl_WorkGroupID.x * STP_GROUP + gl_LocalInvocationIndex) * STP_SUM_WORDS;
    for (uint i = 0; i < STP_SUM_WORDS; i++)
        frame.sums.v[at + i] = i == 0 ? ~0ul : 0ul;
}
