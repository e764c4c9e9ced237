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

// The first slots are read once and kept in registers.
const uint KEPT = 8;

void take(inout Sums sums, Slot slot, bool present, float near, float epsilon, uint id, uvec2 p)
{
    Term term = slot_term(slot, present, p);
    sums_take(sums, present && term.depth <= near + epsilon, term, near, epsilon, id);
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
    uint64_t best = ~0ul;
    [[unroll]] for (uint i = 0; i < KEPT; i++) {
        kept[i] = slot_read(pixel, i, i < count);
        best = min(best, slot_rank(kept[i]));
    }
    for (uint i = KEPT; i < count; i++)
        best = min(best, slot_rank(slot_read(pixel, i, true)));
    bool hit = count > 0;
    float near = rank_depth(best), epsilon = hit ? slots_epsilon(best) : 0;
    uint id = slot_id(uint(best));
    Sums sums = SUMS_NONE;
    [[unroll]] for (uint i = 0; i < KEPT; i++)
        take(sums, kept[i], i < count, near, epsilon, id, p);
    for (uint i = KEPT; i < count; i++)
        take(sums, slot_read(pixel, i, true), true, near, epsilon, id, p);
    surface_write(p, hit, sums_surface(sums, best, epsilon));
}
