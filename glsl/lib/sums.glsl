#include "lib/pixel.glsl"
// A pixel's fixed-point sums: order-independent. Words: 0 id (low half) and depth bits (high half)
// of the nearest, 1 weight, 2-4 normal, 5 depth above the nearest over epsilon, 6-8 colour,
// 9 fragments; 10 opacity, where splats have their own. With REPAIR they live in the slots of a pixel that overflowed them (exact), else in
// a buffer of their own (two-pass).

uint sum_words()
{
    if (OPACITY == 2)
        return STP_SUM_WORDS + 1;
    bool all = HAS_COLOR || SHADE == 1 || (AOVS & 2) != 0;
    return all ? STP_SUM_WORDS : STP_SUM_WORDS_PLAIN;
}

uint sums_at(uint pixel, uint word)
{
    return REPAIR ? slot_index(pixel, word) : pixel * sum_words() + word;
}

bool sums_skip(uint pixel)
{
    return REPAIR && frame.counts.v[pixel] <= STP_SLOTS;
}

Uint64Ref sums_buffer()
{
    if (REPAIR)
        return frame.keys;
    return frame.sums;
}

UintRef sums_halves()
{
    return UintRef(uint64_t(sums_buffer()));
}

