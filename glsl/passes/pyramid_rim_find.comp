#version 460
#extension GL_GOOGLE_include_directive : require
// The points that won their pixels and whose discs may reach, from beyond its neighbours, a pixel that
// is still empty.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
layout(local_size_x_id = 22) in;

bool reaches_empty(ivec4 box)
{
    ivec4 b = box / STP_BLOCK;
    bool reaches = false;
    int columns = int(frame.grid_width) / STP_BLOCK;
    for (int y = b.y; y <= b.w && !reaches; y++)
        for (int x = b.x; x <= b.z && !reaches; x++)
            reaches = frame.work.v[STP_WORK_FLAGS + y * columns + x] != 0;
    return reaches;
}

void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_BLOCKS + 3])
        return;
    uint block = touched_block(index), last = frame.grid_width * frame.grid_height - 1;
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x) {
        uvec2 p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
        Texel t = texel_load(0, ivec2(p));
        vec2 reach = disc_reach(t);
        if (!texel_valid(t) || max(reach.x, reach.y) <= NEAR_REACH || !reaches_empty(disc_box(t, reach)))
            continue;
        uint slot = atomicAdd(frame.work.v[STP_WORK_RIM + 3], 1);
        frame.rim.v[last - slot] = p.y * frame.grid_width + p.x;
        count_groups(STP_WORK_RIM, slot + 1);
    }
}
