#version 460
#extension GL_GOOGLE_include_directive : require
// Every fragment kept, in one geometry pass: STP_SLOTS a pixel, counted. LISTS: drawn again, for the
// pixels that have more and a list for them.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/terms.glsl"
#include "lib/pixel.glsl"
#ifdef LISTS
#extension GL_EXT_shader_atomic_int64 : require
#include "lib/lists.glsl"
#else
#define FIRST_PASS
#endif

// Of the threads that draw a splat, one.
bool speaks_for_splat()
{
#ifdef LARGE
    return gl_LocalInvocationIndex == 0;
#else
    return true;
#endif
}

uint splat_encode(uint id, Splat s)
{
#ifdef FIRST_PASS
    if (TRAITS && speaks_for_splat())
        traits_write(id, traits_make(id, s));
#endif
    return slot_encode(s);
}

#ifdef LISTS
// False: the pixel has no list.
bool slot_take(uint pixel, out uint at)
{
    if (!list_has(pixel))
        return false;
    uvec2 word = unpackUint2x32(atomicAdd(frame.keys.v[list_word(pixel)], 1ul));
    at = list_begin() + word.y + word.x;
    return word.x < frame.counts.v[pixel]; // no more than were counted, whatever a compiler did
}
#else
// False: the slots are full.
bool slot_take(uint pixel, out uint at)
{
    uint slot = atomicAdd(frame.counts.v[pixel], 1);
    at = slot_index(pixel, slot);
    return slot < STP_SLOTS;
}
#endif

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    uint at;
    if (behind_host(pixel, f.depth) || !slot_take(pixel, at))
        return;
    Slot slot = slot_make(id, s, f, encoded);
    frame.keys.v[at] = packUint2x32(slot.key);
    if (SLOT_IDS)
        frame.key_ids.v[at] = slot.id;
}

#include "lib/rasterize.glsl"
