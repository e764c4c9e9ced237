#version 460
#extension GL_GOOGLE_include_directive : require
// The fragments of a pixel, resolved exactly: ZP Eq. 1 in integers. Overflowed pixels are left to
// the repair passes.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#include "lib/slots.glsl"

// The first slots are read once and kept in registers. By id they are read again: a fragment made
// again is so much code that one copy of it, in turns, is both compiled and run sooner than eight.
const uint KEPT = 8;

void take(inout Sums sums, Slot slot, bool present, Rank near, float epsilon, uvec2 p)
{
    Term term = slot_term(slot, present, p);
    bool counts = term.rank.depth <= near.depth + epsilon && present;
    sums_take(sums, counts, term, near, 1 / epsilon);
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    uint count = frame.counts.v[pixel];
    if (slots_overflowed(pixel, count))
        return;
    Slot kept[KEPT];
    Rank near = RANK_NONE;
    [[unroll]] for (uint i = 0; i < KEPT; i++) {
        kept[i] = slot_read(pixel, i, i < count);
        rank_min(near, slot_rank(kept[i], i < count));
    }
    for (uint i = KEPT; i < count; i++)
        rank_min(near, slot_rank(slot_read(pixel, i, true), true));
    bool hit = count > 0;
    float epsilon = hit ? rank_epsilon(near) : 0;
    Sums sums = SUMS_NONE;
    if (PACKED)
        [[unroll]] for (uint i = 0; i < KEPT; i++)
            take(sums, kept[i], i < count, near, epsilon, p);
    for (uint i = PACKED ? KEPT : 0; i < count; i++)
        take(sums, slot_read(pixel, i, true), true, near, epsilon, p);
    surface_write(p, hit, sums_surface(sums, near, epsilon));
}
