#version 460
#extension GL_GOOGLE_include_directive : require
// Every fragment kept, in one geometry pass: STP_SLOTS a pixel, counted. LISTS: drawn again, for the
// pixels that have more and a list for them.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/pixel.glsl"
#ifdef LISTS
#extension GL_EXT_shader_atomic_int64 : require
#include "lib/lists.glsl"
#else
#define FIRST_PASS
#endif

uint splat_encode(Splat s)
{
    return PACKED && PHONG == 0 ? normal_encode(s.normal) : 0;
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
    // STP_TAG_OPAQUE to SLOT_OPAQUE.
    uint word = MIXED ? id | (s.tag & STP_TAG_OPAQUE) << 24 : id;
    frame.keys.v[at] = PACKED ? key_packed(f, fragment_encode(s, f, encoded)) : key_id(f, word);
    if (KEY_IDS)
        frame.key_ids.v[at] = word;
}

#include "lib/rasterize.glsl"
