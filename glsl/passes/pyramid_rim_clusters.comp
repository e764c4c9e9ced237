#version 460
#extension GL_GOOGLE_include_directive : require
// The clusters whose points' discs may reach an open pixel.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
#include "lib/clusters.glsl"
layout(local_size_x_id = PLAN_LANES) in;

// Pixels of the grid that its discs may touch. False: none.
bool cluster_box(Cluster c, out ivec4 box)
{
    vec2 focal = vec2(frame.focal[0], frame.focal[1]);
    float r = c.radius + c.reach, z = c.center.z - r, far_end = c.center.z + r;
    bool crosses = !ORTHOGRAPHIC && z <= 0; // it may be anywhere
    vec2 low = c.center.xy - r, high = c.center.xy + r;
    if (!ORTHOGRAPHIC) {
        low /= mix(vec2(far_end), vec2(z), lessThan(low, vec2(0)));
        high /= mix(vec2(z), vec2(far_end), lessThan(high, vec2(0)));
    }
    vec2 middle = vec2(frame.center[0], frame.center[1]) - vec2(frame.grid_x, frame.grid_y);
    float slack = 2 + frame.pyramid_floor; // samples lie in their pixels
    low = floor(middle + focal * low - slack);
    high = floor(middle + focal * high + slack);
    vec2 last = vec2(frame.grid_width, frame.grid_height) - 1;
    box = crosses ? ivec4(0, 0, last) : ivec4(clamp(low, vec2(0), last), clamp(high, vec2(0), last));
    return crosses || (all(lessThanEqual(low, last)) && all(greaterThanEqual(high, vec2(0))));
}

// Where that is many words, points look for themselves.
const uint MANY_WORDS = 128;

// bare: some block that they may touch is.
bool beside_open(Cluster c, out bool bare)
{
    ivec4 box;
    bool touches = cluster_box(c, box);
    uvec4 w = box_words(box);
    uvec2 side = w.zw - w.xy + 1;
    bool many = side.x * side.y > MANY_WORDS;
    uint columns = frame.grid_width / STP_BLOCK, flags = 0, open = 0;
    uint end = touches && !many ? side.x * side.y : 0;
    for (uint i = 0; i < end; i++) {
        uvec2 word = w.xy + uvec2(i % side.x, i / side.x);
        flags |= frame.work.v[STP_WORK_FLAGS + word.y / 2 * columns + word.x];
        open |= open_bits(word, box);
    }
    bare = many || (flags & STP_BLOCK_BARE) != 0;
    return touches && (bare || open != 0);
}

void main()
{
    if (!discs_far())
        return;
    uint first = workgroup_index() * STP_POINT_RUN;
    for (uint i = gl_LocalInvocationIndex; i < STP_POINT_RUN / STP_CLUSTER; i += gl_WorkGroupSize.x) {
        uint point = first + i * STP_CLUSTER;
        Cluster c = cluster_load(point / STP_CLUSTER);
        bool bare;
        if (point >= push_count || cluster_culled(c) || !beside_open(c, bare))
            continue;
        uint slot = atomicAdd(frame.work.v[STP_WORK_FIND + 3], 1);
        frame.large.v[push_count + slot] = point | (bare ? 1 : 0);
        count_groups(STP_WORK_FIND, slot + 1);
        frame.work.v[STP_WORK_FIND + 2] = 1;
    }
}
