/* float to half, as every EXR reader expects it back. */
#ifndef STP_WRITE_HALF_H
#define STP_WRITE_HALF_H

#include <stdint.h>
#include <string.h>

/* Round to nearest even; beyond +-65504 (and infinite): +-65504; NaN stays a quiet NaN. */
static inline uint16_t half_from_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u)
        return (uint16_t)(sign | 0x7e00u);
    if (magnitude >= 0x477fe000u)
        return (uint16_t)(sign | 0x7bffu);
    if (magnitude >= 0x38800000u) {
        /* Normal: rebias the exponent by 127 - 15, drop 13 bits, ties to even. */
        uint32_t odd = magnitude >> 13 & 1;
        return (uint16_t)(sign | (magnitude - 0x38000000u + 0xfffu + odd) >> 13);
    }
    /* Subnormal: 0.5 has an ulp of 2^-24, so the sum's low bits are the rounded half. */
    float absolute, sum;
    uint32_t low;
    memcpy(&absolute, &magnitude, sizeof absolute);
    sum = absolute + 0.5f;
    memcpy(&low, &sum, sizeof low);
    return (uint16_t)(sign | (low - 0x3f000000u));
}

#endif
