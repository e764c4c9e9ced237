/* Bounds of points, and reductions that are the same for any number of threads. */
#ifndef STP_PREPARE_BOUNDS_H
#define STP_PREPARE_BOUNDS_H

#include <stipple/result.h>

struct bounds {
    double low[3], high[3];
};

/* Of position[order[i]], or of position[i] where order is NULL. Fails only for lack of memory. */
enum stp_result bounds_of(const struct stp_env *env, const double (*position)[3],
                          const uint32_t *order, size_t count, struct bounds *bounds);
/* The longest side. */
double bounds_extent(const struct bounds *bounds);
double bounds_diagonal(const struct bounds *bounds);

/* Adds up `width` doubles over [0, count): fn fills sum[0..width) of one block; blocks are of a
 * fixed size and are added in order, so the result has the same bits for any thread count.
 * width <= SUM_WIDTH. */
#define SUM_WIDTH 8
typedef void (*block_sum_fn)(const void *context, size_t begin, size_t end, double *sum);
enum stp_result block_sum(const struct stp_env *env, size_t count, unsigned width, block_sum_fn fn,
                          const void *context, double *sum);

/* The value of that rank (0: the least); reorders the values. rank < count. */
double select_rank(double *values, size_t count, size_t rank);

#endif
