#version 460
#extension GL_GOOGLE_include_directive : require
// Room for the lists of deep pixels, block after block in the order of the picture, so that which of
// them have lists does not depend on the order of anything. A block with too many has none, and takes
// no room from the others. STP_WORK_REMAINING: some have none.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/lists.glsl"
layout(local_size_x = STP_GROUP) in;

shared uint taken[STP_GROUP];

// What a block asks for; 0: it has no deep pixel, or too many.
uint asked(uint block, out bool is_deep)
{
    is_deep = frame.work.v[STP_WORK_FLAGS + block] == STP_BLOCK_OVERFLOWED;
    uint sum = is_deep ? frame.work.v[list_block(block)] : 0;
    return sum <= list_room() / STP_LIST_SHARE ? sum : 0;
}

void main()
{
    if (frame.work.v[STP_WORK_OVERFLOW] == 0)
        return;
    uint thread = gl_LocalInvocationIndex, count = frame.blocks_x * frame.blocks_y;
    uint each = (count + STP_GROUP - 1) / STP_GROUP, first = min(thread * each, count);
    uint last = min(first + each, count), room = list_room(), sum = 0;
    bool is_deep;
    for (uint block = first; block < last; block++)
        sum = min(sum + asked(block, is_deep), room);
    taken[thread] = sum;
    barrier();
    uint at = 0;
    for (uint i = 0; i < thread; i++)
        at = min(at + taken[i], room);
    for (uint block = first; block < last; block++) {
        uint wants = asked(block, is_deep);
        if (!is_deep)
            continue;
        bool fits = wants > 0 && wants <= room - at;
        frame.work.v[list_block(block)] = fits ? at : STP_LIST_NONE;
        if (!fits)
            frame.work.v[STP_WORK_REMAINING] = 1;
        at = min(at + wants, room);
    }
}
