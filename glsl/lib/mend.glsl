// The rays of pixels that have more fragments than slots, and no list (docs/transparency.md, "Many
// fragments"): their slots hold one layer's sums and the ray so far, and the splats of their blocks are
// drawn again once a layer. Needs pixel.glsl and terms.glsl.
#include "lib/lists.glsl"

// 64-bit words of such a pixel. The first three are mend_word of a fragment, or STP_SUMS_NONE.
const uint MEND_NOW = 0;    // the nearest fragment of the layer that is being summed
const uint MEND_NEXT = 1;   // of the transparent one after it
const uint MEND_WALL = 2;   // of what is opaque
const uint MEND_SUMS = 3;   // weight, depth, normal xyz, colour rgb, alpha, fragments
const uint MEND_SUM_WORDS = 10;
const uint MEND_NEAR = MEND_SUMS + MEND_SUM_WORDS; // the packed normal of the nearest
const uint MEND_RAY = MEND_NEAR + 1; // 32-bit words, two in each: mend_ray_*

uint mend_at(uint pixel, uint word)
{
    return slot_index(pixel, word);
}

bool mend_skip(uint pixel)
{
    return !deep(pixel) || list_has(pixel);
}

// Less is nearer, as in Rank.
uint64_t mend_word(Slot slot)
{
    uint high = PACKED ? floatBitsToUint(float(key_depth(slot.key))) : slot.key.y;
    return packUint2x32(uvec2(slot_word(slot), high));
}

Rank mend_rank(uint64_t word)
{
    uvec2 halves = unpackUint2x32(word);
    return Rank(PACKED ? uintBitsToFloat(halves.y) : depth_ordered(halves.y), halves.x);
}
