#version 460
#extension GL_GOOGLE_include_directive : require
// Sums to zero, nearest to none.
#include "lib/common.glsl"
#include "lib/sums.glsl"
layout(local_size_x = STP_GROUP) in;

void main()
{
    uint block = workgroup_index();
    if (block >= frame.blocks_x * frame.blocks_y)
        return;
    uint at = (block * STP_GROUP + gl_LocalInvocationIndex) * sum_words();
    for (uint i = 0; i < sum_words(); i++)
        frame.sums.v[at + i] = i == 0 ? STP_SUMS_NONE : 0ul;
}
