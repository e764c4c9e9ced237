/* Order statistics without sorting and without histogram error. */
#include "report/metrics.h"

#include <math.h>
#include <string.h>

double samples_mean(const struct samples *samples)
{
    double sum = 0;
    for (size_t i = 0; i < samples->count; i++)
        sum += samples->value[i];
    return samples->count ? sum / (double)samples->count : 0;
}

double samples_max(const struct samples *samples)
{
    double max = 0;
    for (size_t i = 0; i < samples->count; i++)
        max = fmax(max, samples->value[i]);
    return max;
}

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* Values >= 0 order as their bits do: fixes the bits of the rank-th smallest (from 0), a byte at
 * a time from the top. */
static double select_rank(const struct samples *samples, size_t rank)
{
    uint64_t prefix = 0, mask = 0;
    for (int shift = 56; shift >= 0; shift -= 8) {
        size_t count[256] = { 0 };
        for (size_t i = 0; i < samples->count; i++) {
            uint64_t bits = bits_of(samples->value[i]);
            if ((bits & mask) == prefix)
                count[bits >> shift & 255]++;
        }
        uint64_t byte = 0;
        while (rank >= count[byte])
            rank -= count[byte++];
        prefix |= byte << shift;
        mask |= (uint64_t)255 << shift;
    }
    double value;
    memcpy(&value, &prefix, sizeof value);
    return value;
}

double samples_permille(const struct samples *samples, unsigned permille)
{
    uint64_t n = samples->count, rank = (n * permille + 999) / 1000;
    return n ? select_rank(samples, rank ? rank - 1 : 0) : 0;
}
