#version 460
#extension GL_GOOGLE_include_directive : require
// A workgroup a point: its disc's depth into the empty pixels that it covers, the nearest wins, ties go
// to the pixel that comes first. Without 64-bit atomics that takes a pass of its own (NEAREST_ID).
#include "lib/common.glsl"
#ifdef WITH_ATOMIC64
#extension GL_EXT_shader_atomic_int64 : require
#endif
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define ATTRIBUTES 0
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
layout(local_size_x_id = 22) in;

void visit(Texel t, float crowd, uint code, uvec2 p)
{
    float z;
    uint at = grid_index(p), state = UintRef(uint64_t(frame.keys)).v[2 * at];
    bool empty = state >= STP_RIM && state != STP_NO_POINT;
    if (!rim_hit(t, crowd, rim_position(p), z) || !empty)
        return;
    uint depth = depth_order(z);
#ifdef WITH_ATOMIC64
    atomicMin(frame.keys.v[at], uint64_t(depth) << 32 | code);
#elif defined(NEAREST_ID)
    UintRef word = UintRef(uint64_t(frame.keys));
    if (word.v[2 * at + 1] == depth)
        atomicMin(word.v[2 * at], code);
#else
    atomicMin(UintRef(uint64_t(frame.keys)).v[2 * at + 1], depth);
#endif
}

void main()
{
    uint index = gl_WorkGroupID.y * STP_ROW + gl_WorkGroupID.x;
    if (index >= frame.work.v[STP_WORK_RIM + 3])
        return;
    uint from = frame.rim.v[frame.grid_width * frame.grid_height - 1 - index];
    Texel t = texel_load(0, ivec2(from % frame.grid_width, from / frame.grid_width));
    float crowd = disc_crowd(t);
    ivec4 box = disc_box(t, disc_reach(t));
    // At most (2 STP_RIM_REACH + 3)^2 / 8 turns: below what lavapipe allows.
    uint width = uint(box.z - box.x + 1), count = width * uint(box.w - box.y + 1);
    for (uint i = gl_LocalInvocationIndex; i < count; i += gl_WorkGroupSize.x)
        visit(t, crowd, STP_RIM + from, uvec2(box.xy) + uvec2(i % width, i / width));
}
