#version 460
#extension GL_GOOGLE_include_directive : require
// The points whose discs may reach an open pixel, whether or not they won theirs: small discs on one
// list, large ones on another.
#include "lib/common.glsl"
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#define OPEN_GROWS
#include "lib/pyramid.glsl"
#include "lib/discs.glsl"
#include "lib/rim.glsl"
layout(local_size_x_id = PLAN_LANES) in;

// All of a bare block's pixels in the tile are open: no key stands there, and no limit.
void open_bare(uvec2 block, uint index)
{
    ivec2 tile = ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y);
    ivec4 box = ivec4(tile, tile + ivec2(frame.tile_width, frame.tile_height) - 1);
    uvec2 word = block * uvec2(1, 2);
    bool upper = box.y < int(word.y + 1) * (STP_BLOCK / 2), lower = box.w >= int(word.y + 1) * (STP_BLOCK / 2);
    list_open(index, uvec2(upper ? word_bits(word, box) : 0, lower ? word_bits(word + uvec2(0, 1), box) : 0));
}

// What the flags of these blocks are, together; those that are bare become open. Other threads set flags
// meanwhile.
uint visit_blocks(ivec4 b)
{
    uint flags = 0, columns = frame.grid_width / STP_BLOCK;
    for (int y = b.y; y <= b.w; y++)
        for (int x = b.x; x <= b.z; x++) {
            uint index = uint(y) * columns + uint(x), f = ATOMIC_LOAD(frame.work.v[STP_WORK_FLAGS + index]);
            flags |= f;
            if ((f & (STP_BLOCK_BARE | STP_BLOCK_OPEN)) == STP_BLOCK_BARE)
                open_bare(uvec2(x, y), index);
        }
    return flags;
}

// Some pixel of a small box is open.
bool pixels_open(ivec4 box)
{
    uint open = 0;
    uvec4 w = box_words(box);
    for (uvec2 at = w.xy; at.y <= w.w && open == 0;) {
        open = open_bits(at, box);
        bool ends = at.x == w.z;
        at = uvec2(ends ? w.x : at.x + 1, at.y + (ends ? 1 : 0));
    }
    return open != 0;
}

void list_point(uint index, bool large)
{
    uint argument = large ? STP_WORK_LARGE : STP_WORK_RIM, each = large ? 1 : gl_WorkGroupSize.x;
    uint slot = atomicAdd(frame.work.v[argument + 3], 1);
    frame.large.v[large ? push_count - 1 - slot : slot] = index;
    if (slot % each == 0)
        count_groups(argument, slot / each + 1);
}


void main()
{
    uint at = workgroup_index();
    if (at >= frame.work.v[STP_WORK_FIND + 3])
        return;
    uint listed = frame.large.v[push_count + at], first = listed / STP_CLUSTER * STP_CLUSTER;
    bool by_bare = listed != first; // else none of its blocks is
    disc_view_keep();
    for (uint i = gl_LocalInvocationIndex; i < STP_CLUSTER; i += gl_WorkGroupSize.x) {
        uint index = min(first + i, push_count - 1);
        Place place;
        ivec4 box;
        uvec4 point = texelFetch(point_texels, int(index));
        float depth = point_place(uintBitsToFloat(point.xyz), place);
        Texel t = point_disc(index, point, depth, place);
        if (first + i >= push_count || !point_seen(point, depth) || !disc_box(t, box))
            continue;
        uvec2 side = uvec2(box.zw - box.xy + 1);
        bool large = side.x * side.y > STP_LARGE_AREA;
        uint flags = by_bare || large ? visit_blocks(box / STP_BLOCK) : STP_BLOCK_OPEN;
        bool bare = (flags & STP_BLOCK_BARE) != 0, open = (flags & STP_BLOCK_OPEN) != 0;
        bool reaches = bare || (large ? open : pixels_open(box));
        if (reaches)
            list_point(index, large);
    }
}
