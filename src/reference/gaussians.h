/* The splats of a surface as truncated Gaussians, every ray's sorted by depth: what method axis
 * approximates by its lists. */
#ifndef STP_REFERENCE_GAUSSIANS_H
#define STP_REFERENCE_GAUSSIANS_H

#include "reference/tile.h"

/* The current sample of every pixel. Without memory the scratch says so. */
void tile_gaussians(const struct tile *tile);
void gaussians_release(struct gaussians *gaussians);

#endif
