/* Tiles: the fragments of every sample, found twice: for the nearest, then for the sums. */
#ifndef STP_REFERENCE_TILE_H
#define STP_REFERENCE_TILE_H

#include "reference/bins.h"
#include "reference/planes.h"

/* One thread's; of a tile's pixels, row by row. */
struct scratch {
    double px[TILE * TILE], py[TILE * TILE]; /* the sample's position and ray */
    struct ray ray[TILE * TILE];
    struct nearest nearest[TILE * TILE];
    struct sums sums[TILE * TILE];
    struct pixel pixel[TILE * TILE];
};

void tile_render(const struct view *view, const struct bins *bins, size_t tile,
                 struct scratch *scratch, const struct planes *planes);

#endif
