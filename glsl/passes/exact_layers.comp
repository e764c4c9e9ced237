#version 460
#extension GL_GOOGLE_include_directive : require
// The fragments of a pixel, cut into layers and composited from the front (docs/transparency.md).
// Nothing is sorted: a sweep over the slots sums the layer that starts at the nearest fragment left,
// and finds where the next one starts. LISTS: of the pixels that overflowed their slots and have lists;
// what has neither is left to the mending passes.
#include "lib/common.glsl"
#ifdef LISTS
#define WIDE
#endif
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#include "lib/slots.glsl"
#include "lib/layers.glsl"
#ifdef LISTS
#include "lib/lists.glsl"
#endif

// The first terms are made once and kept in registers.
const uint KEPT = 16;

// What a sweep looks for: the layer, and the start of the next.
struct Sweep {
    bool solid; // the layer is opaque, and ends the ray
    Rank near, next;
    float end, part; // of the layer; 1 over its epsilon
    float wall;      // depth of the nearest opaque fragment
    Sums sums;
};

// True: the layer has it.
bool sweep_rank(inout Sweep s, Rank rank)
{
    float depth = rank.depth;
    bool counts = clamp(depth, s.near.depth, s.end) == depth, later = depth > s.end;
    if (MIXED) {
        bool ours = rank_opaque(rank) == s.solid && (s.solid || depth < s.wall);
        counts = counts && ours;
        later = later && ours;
    }
    rank_min(s.next, Rank(later ? depth : NEVER, rank.low));
    return counts;
}

void sweep_term(inout Sweep s, Term t)
{
    bool counts = sweep_rank(s, t.rank);
    sums_take(s.sums, counts, t, s.near, s.part);
}

void sweep_slot(inout Sweep s, Slot slot, uvec2 p)
{
    if (sweep_rank(s, slot_rank(slot, true)))
        sums_take(s.sums, true, slot_term(slot, true, p), s.near, s.part);
}

void find_first(inout Rank next, inout Rank wall, Rank rank)
{
    bool opaque = rank_opaque(rank);
    rank_min(next, Rank(opaque ? NEVER : rank.depth, rank.low));
    if (MIXED)
        rank_min(wall, Rank(opaque ? rank.depth : NEVER, rank.low));
}

// The nearest of what is left, transparent or opaque.
Sweep sweep_start(Rank next, Rank wall, out float epsilon)
{
    Sweep s;
    s.wall = wall.depth;
    s.solid = MIXED && next.depth >= wall.depth;
    s.near = s.solid ? wall : next;
    s.next = RANK_NONE;
    epsilon = rank_epsilon(s.near);
    s.end = s.near.depth + epsilon;
    s.part = 1 / epsilon;
    s.sums = SUMS_NONE;
    return s;
}

// A fragment made again by its id is much code: one copy of it, in turns, and no index that varies
// on registers.
void keep_by_id(out Term kept[KEPT], uint home, uint count, uvec2 p)
{
    [[unroll]] for (uint k = 0; k < KEPT; k++)
        kept[k] = TERM_NONE;
    for (uint i = 0; i < min(count, KEPT); i++) {
        Term term = slot_term(slot_read(home, i, true), true, p);
        [[unroll]] for (uint k = 0; k < KEPT; k++)
            if (k == i)
                kept[k] = term;
    }
}

#ifdef LISTS
bool fragments_of(uint pixel, out uint home, out uint count)
{
    uvec2 list = unpackUint2x32(frame.keys.v[list_word(pixel)]);
    home = list_begin() + list.y;
    count = min(list.x, frame.counts.v[pixel]);
    return list_has(pixel);
}
#else
bool fragments_of(uint pixel, out uint home, out uint count)
{
    home = pixel;
    count = frame.counts.v[pixel];
    return !slots_overflowed(pixel, count);
}
#endif

void main()
{
    uvec2 p;
    uint pixel, home, count;
    if (!resolve_pixel(p, pixel) || !fragments_of(pixel, home, count))
        return;
    Term kept[KEPT];
    Rank next = RANK_NONE, wall = RANK_NONE;
    if (PACKED) {
        [[unroll]] for (uint i = 0; i < KEPT; i++) {
            kept[i] = slot_term(slot_read(home, i, i < count), i < count, p);
            find_first(next, wall, kept[i].rank);
        }
    } else {
        keep_by_id(kept, home, count, p);
        [[unroll]] for (uint i = 0; i < KEPT; i++)
            find_first(next, wall, kept[i].rank);
    }
    for (uint i = KEPT; i < count; i++)
        find_first(next, wall, slot_rank(slot_read(home, i, true), true));
    Ray ray = RAY_START;
    while (next.depth < NEVER || wall.depth < NEVER) {
        float epsilon;
        Sweep s = sweep_start(next, wall, epsilon);
        [[unroll]] for (uint i = 0; i < KEPT; i++)
            sweep_term(s, kept[i]);
        for (uint i = KEPT; i < count; i++)
            sweep_slot(s, slot_read(home, i, true), p);
        float alpha = OPACITY == 1 ? frame.opacity : sums_alpha(s.sums, rank_id(s.near));
        ray_layer(ray, p, sums_surface(s.sums, s.near, epsilon), s.solid ? 1 : alpha);
        next.depth = s.solid ? NEVER : s.next.depth;
        next.low = s.next.low;
        wall.depth = s.solid ? NEVER : wall.depth;
    }
    ray_write(ray, p);
    ray_deep(ray, p, true);
}
