#version 460
#extension GL_GOOGLE_include_directive : require
// Every fragment kept, in one geometry pass: STP_SLOTS a pixel, counted.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/pixel.glsl"
#define FIRST_PASS

uint splat_encode(Splat s)
{
    return PACKED && PHONG == 0 ? normal_encode(s.normal) : 0;
}

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    if (behind_host(pixel, f.depth))
        return;
    uint slot = atomicAdd(frame.counts.v[pixel], 1);
    if (slot >= STP_SLOTS)
        return;
    uint at = slot_index(pixel, slot);
    // STP_TAG_OPAQUE to SLOT_OPAQUE.
    uint word = MIXED ? id | (s.tag & STP_TAG_OPAQUE) << 24 : id;
    frame.keys.v[at] = PACKED ? key_packed(f, fragment_encode(s, f, encoded)) : key_id(f, word);
    if (KEY_IDS)
        frame.key_ids.v[at] = word;
}

#include "lib/rasterize.glsl"
