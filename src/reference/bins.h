/* Splats by picture tile, in canonical order within each. */
#ifndef STP_REFERENCE_BINS_H
#define STP_REFERENCE_BINS_H

#include "reference/disc.h"

#define TILE 32 /* pixels a side */

struct bins {
    uint32_t across, down; /* tiles */
    size_t *first;         /* across * down + 1 */
    uint32_t *splat;
};

/* Every splat is in every tile in which it has a fragment. */
enum stp_result bins_build(const struct stp_env *env, const struct view *view, struct bins *bins);
void bins_release(struct bins *bins);

/* The cells [*first, *last] of size `cell`, of [begin, end), that an interval touches. */
bool cells_touched(double min, double max, double cell, uint32_t begin, uint32_t end,
                   uint32_t *first, uint32_t *last);

#endif
