#version 460
#extension GL_GOOGLE_include_directive : require
// Mending, geometry: FIND looks for the first layer and for what is opaque; else the fragments of
// the layer at hand are summed, in fixed point, and the start of the next one is found.
#include "lib/common.glsl"
#extension GL_EXT_shader_atomic_int64 : require
#define WIDE
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/pixel.glsl"
#include "lib/terms.glsl"
#include "lib/mend.glsl"

uint splat_encode(uint id, Splat s)
{
    return slot_encode(s);
}

#ifdef FIND

void take(uint pixel, Slot slot, Splat s, Fragment f)
{
    Rank rank = slot_rank(slot, true);
    uint word = rank_opaque(rank) ? MEND_WALL : MEND_NEXT;
    atomicMin(frame.keys.v[mend_at(pixel, word)], mend_word(slot));
}

#else

void add(uint pixel, uint word, int64_t value)
{
    atomicAdd(frame.keys.v[mend_at(pixel, MEND_SUMS + word)], uint64_t(value));
}

// What the fragment adds, as it would from a slot.
void sum(uint pixel, Slot slot, Splat s, Fragment f, Rank near, float epsilon)
{
    float rho2 = PACKED ? key_rho2(slot.key) : f.rho2;
    Rank rank = slot_rank(slot, true);
    Traits traits = TRAITS ? traits_read(rank_id(rank)) : Traits(slot.key.x & STP_NORMAL_MASK, 0);
    vec3 n = PACKED ? normal_decode(traits.normal & STP_NORMAL_MASK) : fragment_normal(s, f);
    uint packed = PACKED ? traits.normal & STP_NORMAL_MASK : normal_encode(n);
    Sums one = SUMS_NONE;
    sums_take(one, true, term_make(rank, true, rho2, n, traits), near, 1 / epsilon);
    if ((SLOT_IDS || !PACKED) && slot_word(slot) == near.low)
        frame.keys.v[mend_at(pixel, MEND_NEAR)] = packed;
    add(pixel, 0, one.weight);
    add(pixel, 1, one.depth);
    for (uint i = 0; i < 3; i++)
        add(pixel, 2 + i, one.normal[i]);
    if (HAS_COLOR)
        for (uint i = 0; i < 3; i++)
            add(pixel, 5 + i, (one.high[i] << COLOR_PART_BITS) + one.low[i]);
    if (OPACITY == 2)
        add(pixel, 8, (one.high.a << STP_PART_BITS) + one.low.a);
    add(pixel, 9, 1);
}

void take(uint pixel, Slot slot, Splat s, Fragment f)
{
    uint64_t now = frame.keys.v[mend_at(pixel, MEND_NOW)];
    uint64_t wall = frame.keys.v[mend_at(pixel, MEND_WALL)];
    bool solid = MIXED && now == wall;
    Rank rank = slot_rank(slot, true), near = mend_rank(now);
    if (now == STP_SUMS_NONE || rank_opaque(rank) != solid || rank.depth < near.depth ||
        (!solid && rank.depth >= mend_rank(wall).depth))
        return;
    float epsilon = rank_epsilon(near);
    if (rank.depth <= near.depth + epsilon)
        sum(pixel, slot, s, f, near, epsilon);
    else if (!solid)
        atomicMin(frame.keys.v[mend_at(pixel, MEND_NEXT)], mend_word(slot));
}

#endif

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    if (!mend_skip(pixel) && !behind_host(pixel, f.depth))
        take(pixel, slot_make(id, s, f, encoded), s, f);
}

#include "lib/rasterize.glsl"
