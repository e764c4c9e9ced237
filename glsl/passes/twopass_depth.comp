#version 460
#extension GL_GOOGLE_include_directive : require
// The classical first pass: the nearest depth of every pixel, and the lowest id that has it.
// Of a transparent scene, behind the layers that are peeled. Without 64-bit atomics the id takes a pass of its own (NEAREST_ID).
// OPAQUE_ONLY: before any layer is peeled, the depth at which something opaque ends the ray.
#include "lib/common.glsl"
#ifdef WITH_ATOMIC64
#extension GL_EXT_shader_atomic_int64 : require
#endif
// The id's pass finds the depth again; and which variant draws a splat must not show.
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/sums.glsl"
#include "lib/peel.glsl"
#ifndef NEAREST_ID
#define FIRST_PASS
#endif
// BINNED: a pixel is one thread's, and no atomics are needed.

uint splat_encode(uint id, Splat s)
{
    return 0;
}

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
#ifdef OPAQUE_ONLY
    atomicMin(frame.limits.v[pixel], depth_order(f.depth));
#else
    if (sums_skip(pixel) || peeled(pixel, id, f.depth))
        return;
    uint at = sums_at(pixel, 0), depth = depth_order(f.depth);
#ifdef WITH_ATOMIC64
    atomicMin(sums_buffer().v[at], uint64_t(depth) << 32 | id);
#elif defined(NEAREST_ID)
    if (sums_halves().v[2 * at + 1] == depth)
        atomicMin(sums_halves().v[2 * at], id);
#else
    atomicMin(sums_halves().v[2 * at + 1], depth);
#endif
#endif
}

#ifdef BINNED
struct Held {
    uint depth, id;
};

Held held_begin(uint pixel)
{
    uint at = 2 * sums_at(pixel, 0);
    return Held(sums_halves().v[at + 1], sums_halves().v[at]);
}

void held_take(inout Held held, bool hit, uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    uint depth = hit ? depth_order(f.depth) : ~0u;
    bool first = depth < held.depth || (depth == held.depth && id < held.id);
    held.depth = first ? depth : held.depth;
    held.id = first ? id : held.id;
}

void held_end(uint pixel, Held held)
{
    uint at = 2 * sums_at(pixel, 0);
    sums_halves().v[at] = held.id;
    sums_halves().v[at + 1] = held.depth;
}

#endif
#include "lib/rasterize.glsl"
