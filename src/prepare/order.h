/* The canonical order of splats: Morton, then every attribute, then the input index. */
#ifndef STP_PREPARE_ORDER_H
#define STP_PREPARE_ORDER_H

#include "prepare/bounds.h"
#include "scene/splats.h"

/* Puts the splats in canonical order. Positions are finite and below 1e18. The Morton code has 21
 * bits an axis over the bounds of the centres; splats that share a cell are sorted by the Morton
 * code over their own bounds, again and again, and where they coincide by the bits of every
 * attribute, so that neither a far outlier nor a heap of coincident points spoils the locality.
 * input == NULL stands for 0, 1, 2...; it is filled. *duplicates, if not NULL, gets how many splats
 * equal their predecessor in everything but the input index. On failure (out of memory, logged)
 * the splats are whole, in an unknown order. */
enum stp_result order_splats(const struct stp_env *env, struct splats *splats, size_t *duplicates);

/* The same for some of the splats in the box: the order that they have among all of those. And the
 * first key of that order, 63 bits. */
enum stp_result order_splats_within(const struct stp_env *env, struct splats *splats,
                                    const struct bounds *within, size_t *duplicates);
uint64_t order_code(const double p[3], const struct bounds *box);

#endif
