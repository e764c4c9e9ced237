/* Radii: missing ones from the local spacing, bad ones replaced. */
#ifndef STP_PREPARE_RADII_H
#define STP_PREPARE_RADII_H

#include "prepare/places.h"
#include "prepare/surroundings.h"

/* A radius that a splat can have. */
bool radius_is_good(float radius);

/* Lower median of the good ones; 0: there are none. */
enum stp_result radii_median(const struct stp_env *env, const float *radius, size_t count,
                             float *median);

/* What it is made of, for radii that are not there at once: the bins of their upper halves, or,
 * where *upper is one of those, of the lower halves within it; and the bin that holds a rank, which
 * becomes a rank within it. */
#define RADII_BINS 65536
void radii_tally(const float *radius, size_t count, size_t *bins, const uint32_t *upper);
uint32_t radii_bin_of_rank(const size_t *bins, size_t *rank);

/* How many are 0. */
size_t radii_unknown(const float *radius, size_t count);
/* Whether some radius is so large against the median that radii_blank_monsters must look. */
bool radii_are_suspect(const float *radius, size_t count, float median);
/* Sets to 0 what exceeds 64 times the median and 8 times the local spacing; *count: how many. */
enum stp_result radii_blank_monsters(const struct stp_env *env, const struct places *places,
                                     const struct neighbour_tree *tree, float *radius,
                                     size_t splats, float median, size_t *count);

/* Radii that are 0 become the spacing, at most 4 times the median spacing of the neighbours and 32
 * times the median of all, lest an outlier become a plate; *outliers counts those that were
 * bounded. Where everything coincides (or is one point): 1, or a millionth of the coordinates
 * where that is more. */
enum stp_result radii_fill(const struct stp_env *env, const struct places *places,
                           const struct surroundings *all, float *radius, size_t splats,
                           size_t *outliers);

#endif
