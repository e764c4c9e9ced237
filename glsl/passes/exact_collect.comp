#version 460
#extension GL_GOOGLE_include_directive : require
// The small splats that touch a block with an overflowed pixel: only they are drawn again.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
layout(local_size_x = STP_GROUP) in;

bool touches_overflow(ivec4 box)
{
    ivec4 b = (box - ivec2(frame.tile_x, frame.tile_y).xyxy) / STP_BLOCK;
    bool touches = false;
    int width = b.z - b.x + 1, count = box.z < box.x ? 0 : width * (b.w - b.y + 1);
    for (int i = 0; i < count && !touches; i++) {
        uint block = uint(b.y + i / width) * frame.blocks_x + uint(b.x + i % width);
        touches = frame.work.v[STP_WORK_FLAGS + block] == STP_BLOCK_OVERFLOWED;
    }
    return touches;
}

void main()
{
    uint id = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex;
    if (id >= frame.splat_count)
        return;
    Splat s;
    bool floored;
    ivec4 box;
    if (!splat_load(id, s) || !splat_small(s, floored, box) || !touches_overflow(box))
        return;
    uint slot = atomicAdd(frame.work.v[STP_WORK_REPAIR + 3], 1), group = slot / STP_GROUP;
    frame.large.v[frame.splat_count + slot] = id;
    atomicMax(frame.work.v[STP_WORK_REPAIR], min(group + 1, STP_ROW));
    atomicMax(frame.work.v[STP_WORK_REPAIR + 1], group / STP_ROW + 1);
}
