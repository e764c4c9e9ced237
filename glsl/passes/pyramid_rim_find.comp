#version 460
#extension GL_GOOGLE_include_directive : require
// The points that won their pixels and whose discs may reach, from beyond its neighbours, a pixel that
// is still open: small discs on one list, large ones on another.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
layout(local_size_x_id = 22) in;

// Some block of these has open pixels.
bool blocks_open(ivec4 b)
{
    uint flags = 0;
    int columns = int(frame.grid_width) / STP_BLOCK;
    for (int y = b.y; y <= b.w; y++)
        for (int x = b.x; x <= b.z && (flags & STP_BLOCK_OPEN) == 0; x++)
            flags |= frame.work.v[STP_WORK_FLAGS + y * columns + x];
    return (flags & STP_BLOCK_OPEN) != 0;
}

// Some pixel of a small box is open.
bool pixels_open(ivec4 box)
{
    uint open = 0;
    uvec4 w = box_words(box);
    for (uint y = w.y; y <= w.w; y++)
        for (uint x = w.x; x <= w.z && open == 0; x++)
            open |= open_bits(uvec2(x, y), box);
    return open != 0;
}

// Some block that its points' discs may reach has open pixels. Where that is many blocks, points look
// for themselves.
bool beside_open(ivec2 block)
{
    int reach = frame.rim_blocks;
    ivec2 last = ivec2(frame.grid_width, frame.grid_height) / STP_BLOCK - 1;
    return reach > 2 || blocks_open(ivec4(max(block - reach, ivec2(0)), min(block + reach, last)));
}

void list_point(uvec2 p, bool large)
{
    uint argument = large ? STP_WORK_LARGE : STP_WORK_RIM, each = large ? 1 : gl_WorkGroupSize.x;
    uint slot = atomicAdd(frame.work.v[argument + 3], 1);
    frame.rim.v[large ? frame.grid_width * frame.grid_height - 1 - slot : slot] = p.y << 16 | p.x;
    if (slot % each == 0)
        count_groups(argument, slot / each + 1);
}

void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_BLOCKS + 3])
        return;
    uint block = listed_block(TOUCHED, index);
    ivec2 at = ivec2(block % columns, block / columns), corner = at * STP_BLOCK;
    uint end = beside_open(at) ? STP_GROUP : 0;
    for (uint i = gl_LocalInvocationIndex; i < end;) {
        Texel t = EMPTY;
        t.depth = NOTHING;
        ivec2 p = corner;
        bool found = false;
        for (; i < end && !found; i += gl_WorkGroupSize.x) {
            p = corner + ivec2(i % STP_BLOCK, i / STP_BLOCK);
            t = texel_load(0, p);
            found = texel_valid(t);
        }
        vec2 reach = disc_reach(t);
        ivec4 box = disc_box(t, reach);
        uvec2 side = uvec2(box.zw - box.xy + 1);
        bool large = side.x * side.y > STP_LARGE_AREA;
        bool far = found && max(reach.x, reach.y) > NEAR_REACH;
        if (far && (large ? blocks_open(box / STP_BLOCK) : pixels_open(box)))
            list_point(uvec2(p), large);
    }
}
