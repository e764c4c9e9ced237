/* Parallel radix sort of 64-bit keys that carry 32-bit values. */
#ifndef STP_PREPARE_RADIX_H
#define STP_PREPARE_RADIX_H

#include <stipple/result.h>

#include <string.h>

/* Sorts ascending by key; stable, so the result is the same for any number of threads. Digits
 * that no key varies in cost nothing. Takes 12 bytes a pair of scratch memory; on failure (out of
 * memory, logged) key and value are untouched. count < 2^32. */
enum stp_result radix_sort(const struct stp_env *env, size_t count, uint64_t *key, uint32_t *value);

/* Bits of a double that order as the numbers do. */
static inline uint64_t radix_ascending(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits >> 63 ? ~bits : bits | (uint64_t)1 << 63;
}

#endif
