// The rays of pixels that have more fragments than slots, and no list (docs/transparency.md, "Many
// fragments"): their slots hold one layer's sums and the ray so far, and the splats of their blocks are
// drawn again once a layer. Needs pixel.glsl.
#include "lib/lists.glsl"

// 64-bit words of such a pixel. Of the first three, the high half is depth_order, the low half the id.
const uint MEND_NOW = 0;    // the nearest fragment of the layer that is being summed
const uint MEND_NEXT = 1;   // of the transparent one after it
const uint MEND_WALL = 2;   // of what is opaque
const uint MEND_SUMS = 3;   // weight, normal xyz, depth, albedo rgb, alpha, fragments
const uint MEND_SUM_WORDS = 10;
const uint MEND_RAY = MEND_SUMS + MEND_SUM_WORDS; // 32-bit words, two in each: mend_ray_*

uint mend_at(uint pixel, uint word)
{
    return slot_index(pixel, word);
}

bool mend_skip(uint pixel)
{
    return !deep(pixel) || list_has(pixel);
}

float mend_depth(uint64_t rank)
{
    return depth_ordered(uint(rank >> 32));
}
