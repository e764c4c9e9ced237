/* Scattering of bits: even numbers out of counters. */
#ifndef STP_BASE_MIX_H
#define STP_BASE_MIX_H

#include <stdint.h>

/* The 32-bit finaliser of MurmurHash3 (Appleby). The reference and glsl/lib/sample.glsl have their
 * own, so that neither is tested against itself. */
static inline uint32_t mix_bits(uint32_t h)
{
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

#endif
