#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.1: every point to one pixel, by one atomic. Depth decides, ties go to the lower id. An
// invocation takes many points: starting one costs a CPU device as much as projecting several.
// Without 64-bit atomics the id takes a pass of its own (NEAREST_ID).
#include "lib/common.glsl"
#ifdef WITH_ATOMIC64
#extension GL_EXT_shader_atomic_int64 : require
#endif
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/points.glsl"
#include "lib/clusters.glsl"
layout(local_size_x_id = 22) in;

void project(uint index)
{
    Splat s;
    uvec2 pixel;
    vec2 offset;
    bool seen = point_load(index, s);
    if (!point_pixel(s, pixel, offset) || !seen)
        return;
    uint at = grid_index(pixel), depth = depth_order(s.center.z), id = push_first + index;
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
        word.v[2 * at] = STP_NO_POINT;
#endif
#endif
}

// A bit for each of the run's clusters that may be seen. Every thread tests them all: what threads tell
// each other would cost a CPU device more.
uint clusters_seen(uint first)
{
    uint seen = 0;
    for (uint i = 0; i < STP_POINT_RUN / STP_CLUSTER; i++) {
        uint point = first + i * STP_CLUSTER;
        seen |= point < push_count && cluster_seen(point / STP_CLUSTER) ? 1u << i : 0;
    }
    return seen;
}

void main()
{
    uint first = workgroup_index() * STP_POINT_RUN;
    uint seen = CULL_CLUSTERS ? clusters_seen(first) : 0xffffffffu >> (32 - STP_POINT_RUN / STP_CLUSTER);
    uint count = bitCount(seen) * STP_CLUSTER, cluster = 0;
    for (uint i = gl_LocalInvocationIndex; i < count; i += gl_WorkGroupSize.x) {
        if (i % STP_CLUSTER < gl_WorkGroupSize.x) { // the first of another
            cluster = first + findLSB(seen) * STP_CLUSTER;
            seen &= seen - 1;
        }
        uint index = cluster + i % STP_CLUSTER;
        if (index < push_count)
            project(index);
    }
}
