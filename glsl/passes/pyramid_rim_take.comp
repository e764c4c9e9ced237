#version 460
#extension GL_GOOGLE_include_directive : require
// The points, of those on the device, that reach open pixels before all others, take the place of what
// level 0 has there: what they hide is not looked at again.
#include "lib/common.glsl"
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/discs.glsl"
layout(local_size_x_id = PLAN_LANES) in;

void take(ivec2 p, uint index, float depth, bool found)
{
    uvec4 point = texelFetch(point_texels, int(index));
    Texel t = point_disc(index, point, depth, Place(ivec2(0), vec2(0)));
    t.center = level_middle(0, p); // the key has the depth there
    if (!found)
        return;
    texel_store(0, p, t);
#if ATTRIBUTES > 0
    attributes_store(0, p, point_attributes(index));
#endif
}

// The lists of the points' next chunk start empty.
void reset_lists()
{
    const uint arguments[3] = { STP_WORK_FIND, STP_WORK_RIM, STP_WORK_LARGE };
    for (int i = 0; i < 3; i++)
        frame.work.v[arguments[i]] = frame.work.v[arguments[i] + 3] = 0;
}

// A thread's pixels up to the next that is reached.
void main()
{
    uint listed = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (listed >= frame.work.v[STP_WORK_OPEN + 3])
        return;
    if (listed == 0 && gl_LocalInvocationIndex == 0)
        reset_lists();
    uint block = listed_block(OPEN, listed);
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    uvec2 open = uvec2(frame.work.v[open_word(block, 0)], frame.work.v[open_word(block, 1)]);
    disc_view_keep();
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP;) {
        bool found = false;
        uint index = 0;
        float depth = 0;
        uvec2 p = corner;
        for (; i < STP_GROUP && !found; i += gl_WorkGroupSize.x) {
            uvec2 key = unpackUint2x32(frame.keys.v[block * STP_GROUP + i]);
            uint id = key.x;
            depth = depth_ordered(key.y);
            p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
            found = any(notEqual(open & open_bit(i), uvec2(0))) && id - push_first < push_count;
            index = found ? id - push_first : 0;
        }
        take(ivec2(p), index, depth, found);
    }
}
