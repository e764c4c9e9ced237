#include "scene/samples.h"

unsigned sample_grid(unsigned samples)
{
    unsigned grid = 1;
    while ((uint64_t)grid * grid < samples)
        grid++;
    return grid;
}

/* The 32-bit finaliser of MurmurHash3 (Appleby). */
static uint32_t mix(uint32_t h)
{
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

void sample_position(unsigned grid, uint32_t i, uint32_t j, uint32_t index, double *px, double *py)
{
    if (grid == 1) {
        *px = i + 0.5;
        *py = j + 0.5;
        return;
    }
    uint32_t h = mix(mix(mix(i + 0x9e3779b9u) + j) + index);
    *px = i + (index % grid + ((h >> 16) + 0.5) / 65536) / grid;
    *py = j + (index / grid + ((h & 0xffff) + 0.5) / 65536) / grid;
}
