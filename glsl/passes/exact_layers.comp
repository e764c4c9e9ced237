#version 460
#extension GL_GOOGLE_include_directive : require
// The fragments of a pixel, cut into layers and composited from the front (docs/transparency.md).
// Nothing is sorted: a sweep over the slots sums the layer that starts at the nearest fragment left,
// and finds where the next one starts. Overflowed pixels are left to the repair passes.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#include "lib/slots.glsl"
#include "lib/layers.glsl"

// The first terms are made once and kept in registers.
const uint KEPT = 16;

// What a sweep looks for: the layer, and the start of the next.
struct Sweep {
    bool solid; // the layer is opaque, and ends the ray
    uint64_t best, next;
    float near, epsilon, wall; // wall: depth of the nearest opaque fragment
    uint id;
    Sums sums;
};

void sweep_term(inout Sweep s, Term t, bool present)
{
    bool ours = present && t.depth >= s.near;
    if (MIXED)
        ours = ours && word_opaque(t.word) == s.solid && (s.solid || t.depth < s.wall);
    bool counts = ours && t.depth <= s.near + s.epsilon;
    s.next = ours && !counts ? min(s.next, t.rank) : s.next;
    sums_take(s.sums, counts, t, s.near, s.epsilon, s.id);
}

void find_first(inout uint64_t next, inout uint64_t wall, uint64_t rank, uint word)
{
    bool opaque = rank != ~0ul && word_opaque(word);
    next = opaque ? next : min(next, rank);
    if (MIXED)
        wall = opaque ? min(wall, rank) : wall;
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
    Term kept[KEPT];
    uint64_t next = ~0ul, wall = ~0ul;
    [[unroll]] for (uint i = 0; i < KEPT; i++) {
        kept[i] = slot_term(slot_read(pixel, i, i < count), i < count, p);
        find_first(next, wall, kept[i].rank, kept[i].word);
    }
    for (uint i = KEPT; i < count; i++) {
        Slot slot = slot_read(pixel, i, true);
        find_first(next, wall, slot_rank(slot), slot_word(slot));
    }
    Ray ray = RAY_START;
    while (next != ~0ul || wall != ~0ul) {
        Sweep s;
        s.wall = MIXED && wall != ~0ul ? rank_depth(wall) : 1.0 / 0.0;
        s.solid = MIXED && (next == ~0ul || rank_depth(next) >= s.wall);
        s.best = s.solid ? wall : next;
        s.next = ~0ul;
        s.near = rank_depth(s.best);
        s.epsilon = slots_epsilon(s.best);
        s.id = slot_id(uint(s.best));
        s.sums = SUMS_NONE;
        [[unroll]] for (uint i = 0; i < KEPT; i++)
            sweep_term(s, kept[i], i < count);
        for (uint i = KEPT; i < count; i++)
            sweep_term(s, slot_term(slot_read(pixel, i, true), true, p), true);
        float alpha = OPACITY == 1 ? frame.opacity : sums_alpha(s.sums, s.id);
        ray_layer(ray, p, sums_surface(s.sums, s.best, s.epsilon), s.solid ? 1 : alpha);
        next = s.solid ? ~0ul : s.next;
        wall = s.solid ? ~0ul : wall;
    }
    ray_write(ray, p);
    ray_deep(ray, p, true);
}
