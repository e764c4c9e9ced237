#version 460
#extension GL_GOOGLE_include_directive : require
// A thread a point, or, LARGE, a workgroup: its disc's depth into the open pixels that it covers, the
// nearest wins, ties go to the lower id. Without 64-bit atomics that takes a pass of its
// own (NEAREST_ID).
#include "lib/common.glsl"
#ifdef WITH_ATOMIC64
#extension GL_EXT_shader_atomic_int64 : require
#endif
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#include "lib/pyramid.glsl"
#include "lib/discs.glsl"
#include "lib/rim.glsl"
layout(local_size_x_id = PLAN_LANES) in;

void visit(Texel t, uint id, uvec2 p)
{
    float z;
    if (!rim_hit(t, 0, rim_position(p), z) || !(z + t.radius < open_limit(p)))
        return;
    uint at = grid_index(p), depth = depth_order(z);
#ifdef WITH_ATOMIC64
    atomicMin(frame.keys.v[at], uint64_t(depth) << 32 | id);
#else
    UintRef word = UintRef(uint64_t(frame.keys));
#ifdef NEAREST_ID
    if (word.v[2 * at + 1] == depth)
        atomicMin(word.v[2 * at], id);
#else
    // What an earlier chunk left lies behind: its id goes.
    if (atomicMin(word.v[2 * at + 1], depth) > depth)
        word.v[2 * at] = STP_RIM_NONE;
#endif
#endif
}

// Of the list; false: there are no more.
bool point_of(uint index, uint argument, uint slot, out Texel t, out uint id)
{
    bool there = index < frame.work.v[argument + 3];
    uint from = min(frame.large.v[there ? slot : 0], push_count - 1);
    Place place;
    uvec4 point = texelFetch(point_texels, int(from));
    float depth = point_place(uintBitsToFloat(point.xyz), place);
    t = point_disc(from, point, depth, place);
    PRECISE vec3 unit = t.normal * inversesqrt(inner(t.normal, t.normal));
    t.normal = unit;
    id = push_first + from;
    return there;
}

void main()
{
    Texel t;
    uint id;
    ivec4 box;
    disc_view_keep();
#ifdef LARGE
    uint index = gl_WorkGroupID.y * STP_ROW + gl_WorkGroupID.x;
    if (!point_of(index, STP_WORK_LARGE, push_count - 1 - index, t, id))
        return;
#else
    uint index = workgroup_index() * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
    if (!point_of(index, STP_WORK_RIM, index, t, id))
        return;
#endif
    disc_box(t, box);
    uvec4 words = box_words(box);
    uvec2 size = words.zw - words.xy + 1, at = uvec2(0), step = uvec2(1, 0);
#ifdef LARGE
    at = uvec2(gl_LocalInvocationIndex % size.x, gl_LocalInvocationIndex / size.x);
    step = uvec2(gl_WorkGroupSize.x % size.x, gl_WorkGroupSize.x / size.x);
#endif
    // At most (2 STP_RIM_REACH + 3)^2 / 8 turns, or STP_LARGE_AREA: below what lavapipe allows.
    uint bits = 0;
    uvec2 corner = uvec2(0);
    while (bits != 0 || at.y < size.y) {
        for (; bits == 0 && at.y < size.y; at = at.x >= size.x ? uvec2(at.x - size.x, at.y + 1) : at) {
            bits = open_bits(words.xy + at, box);
            corner = (words.xy + at) * uvec2(STP_BLOCK, STP_BLOCK / 2);
            at += step;
        }
        uint i = findLSB(bits);
        if (bits != 0)
            visit(t, id, corner + uvec2(i % STP_BLOCK, i / STP_BLOCK));
        bits &= bits - 1;
    }
}
