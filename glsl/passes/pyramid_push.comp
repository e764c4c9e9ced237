#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.3: empty and hidden texels of level push_first are made from the level above it; the rest stay
// as they were pulled. LISTED: only where blocks of the picture may be touched.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/push.glsl"
layout(local_size_x_id = PLAN_LANES) in;

void push(uint level, ivec2 p)
{
    Texel own = texel_load(level, p);
    bool valid = texel_valid(own);
    Pushed r = push_from(level + 1, p, valid ? own.center : level_middle(level, p), valid);
    if (!(r.weight > 0) || (valid && own.depth - own.extent <= r.reach))
        return;
    texel_store(level, p, r.disc);
    attributes_store(level, p, Attributes(r.attributes.color / r.weight, r.attributes.id, r.attributes.object));
}

void main()
{
    uvec2 size = level_size(push_first);
#ifdef LISTED
    // A block of the picture has side x side texels of this level.
    uint side = STP_BLOCK >> push_first, each = side * side, columns = frame.grid_width / STP_BLOCK;
    uint count = frame.work.v[STP_WORK_BLOCKS + 3] * each;
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x) {
        uint at = workgroup_index() * STP_GROUP + i;
        if (at >= count)
            continue;
        uint block = listed_block(TOUCHED, at / each), inner = at % each;
        push(push_first, ivec2(uvec2(block % columns, block / columns) * side +
                               uvec2(inner % side, inner / side)));
    }
#else
    uint block = workgroup_index(), columns = (size.x + STP_BLOCK - 1) / STP_BLOCK;
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x) {
        uvec2 p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
        if (all(lessThan(p, size)))
            push(push_first, ivec2(p));
    }
#endif
}
