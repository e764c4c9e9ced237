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
#include "lib/reach.glsl"
layout(local_size_x_id = PLAN_LANES) in;

// The nearest of the points that a thread has met in a row in one pixel: its key is written when the next
// falls into another, since atomics are most of what a point costs.
struct Held {
    uint at, depth, id;
};
const uint NOWHERE = 0xffffffffu;

void put(Held h)
{
#ifdef WITH_ATOMIC64
    atomicMin(frame.keys.v[h.at], uint64_t(h.depth) << 32 | h.id);
#else
    UintRef word = UintRef(uint64_t(frame.keys));
#ifdef NEAREST_ID
    if (word.v[2 * h.at + 1] == h.depth)
        atomicMin(word.v[2 * h.at], h.id);
#else
    // What an earlier chunk left lies behind: its id goes.
    if (atomicMin(word.v[2 * h.at + 1], h.depth) > h.depth)
        word.v[2 * h.at] = STP_NO_POINT;
#endif
#endif
}

// Ids grow: of equal depths the one that is held stays.
void project(uint index, inout Held held)
{
    Place place;
    uvec2 pixel;
    vec2 offset;
    uvec4 t = texelFetch(point_texels, int(min(index, push_count - 1)));
    float z = point_place(uintBitsToFloat(t.xyz), place);
    bool seen = point_pixel(place, pixel, offset) && point_seen(t, z) && index < push_count;
    Held h = Held(grid_index(pixel), depth_order(z), push_first + index);
    bool next = seen && h.at != held.at;
    if (next && held.at != NOWHERE)
        put(held);
    if (next || (seen && h.depth < held.depth))
        held = h;
}

// Some disc of the cluster may reach beyond the pixels beside its own, as wide as lib/rim.glsl draws it.
bool cluster_far(Cluster c)
{
    float depth = ORTHOGRAPHIC ? 1 : cluster_nearest(c);
    float reach = max(c.reach * max(frame.focal[0], frame.focal[1]) / depth, frame.pyramid_floor);
    return reach > NEAR_REACH - MOST_CROWD;
}

// A bit for each of the run's clusters that may be seen. Every thread tests them all: what threads tell
// each other would cost a CPU device more.
uint clusters_seen(uint first, inout bool far)
{
    uint seen = 0;
    for (uint i = 0; i < STP_POINT_RUN / STP_CLUSTER; i++) {
        uint point = first + i * STP_CLUSTER;
        Cluster c = cluster_load(point / STP_CLUSTER);
        bool may = point < push_count && cluster_seen(c);
        seen |= may ? 1u << i : 0;
        far = far || (RIM_FAR && may && cluster_far(c));
    }
    return seen;
}

// A thread takes points that lie next to each other: as many of a cluster as there are threads for it.
void main()
{
    uint first = workgroup_index() * STP_POINT_RUN;
    point_view_keep();
    uint seen = 0xffffffffu >> (32 - STP_POINT_RUN / STP_CLUSTER);
    bool far = false;
    if (CULL_CLUSTERS || RIM_FAR) {
        uint may = clusters_seen(first, far);
        seen = CULL_CLUSTERS ? may : seen;
    }
    if (far)
        frame.work.v[STP_WORK_FAR] = 1;
    uint run = STP_CLUSTER / gl_WorkGroupSize.x, count = bitCount(seen) * run, point = 0;
    Held held = Held(NOWHERE, 0, 0);
    for (uint i = 0; i < count; i++) {
        if (i % run == 0) { // the first of another
            point = first + findLSB(seen) * STP_CLUSTER + gl_LocalInvocationIndex * run;
            seen &= seen - 1;
        }
        project(point + i % run, held);
    }
    if (held.at != NOWHERE)
        put(held);
}
