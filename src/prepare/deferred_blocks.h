/* Splats in blocks of eight, under a tree of boxes: what the overlap graph searches. Blocks follow
 * the canonical (Morton) order, so they are compact; each box carries its largest radius, so any
 * range of radii is searched in time linear in what is found. */
#ifndef STP_PREPARE_DEFERRED_BLOCKS_H
#define STP_PREPARE_DEFERRED_BLOCKS_H

#include "scene/splats.h"

#define BLOCK_SPLATS 8
#define BLOCK_FANOUT 4
#define BLOCK_LEVELS 16

struct splat_block {
    double x[BLOCK_SPLATS], y[BLOCK_SPLATS], z[BLOCK_SPLATS], radius[BLOCK_SPLATS]; /* NaN pads */
};

/* The boxes of four children: bounds of the centres, and the largest radius. Absent children have
 * inverted bounds: nothing is near them. */
struct block_node {
    double low[3][BLOCK_FANOUT], high[3][BLOCK_FANOUT], radius[BLOCK_FANOUT];
};

struct block_tree {
    size_t splats, blocks;
    uint32_t *id; /* of each lane, ascending; UINT32_MAX pads */
    struct splat_block *block;
    unsigned levels; /* the last has one node; 0 when there are no blocks */
    size_t count[BLOCK_LEVELS];
    struct block_node *node[BLOCK_LEVELS]; /* children of node k are 4k to 4k + 3: nodes of the
                                              level below, and blocks at level 0 */
    struct block_node *nodes;              /* owns them all */
};

/* skip: NULL, or nonzero where a splat is left out. */
enum stp_result block_tree_build(const struct stp_env *env, const struct splats *splats,
                                 const uint8_t *skip, struct block_tree *tree);
void block_tree_release(struct block_tree *tree);

/* The blocks, ascending and with b itself, that may hold a splat closer than
 * overlap (r_i + r_j) to one of b's. `found` has room for tree->blocks. Never misses one: every
 * step rounds monotonically, so a box is never farther than what is in it. */
size_t block_tree_near(const struct block_tree *tree, size_t b, double overlap, uint32_t *found);

/* skip[i] = 2 (where it was 0) for each splat that `limit` or more others overlap which come
 * before it in the order of radius descending, then id: splats no colouring of `limit` colours in
 * that order has room for. Returns how many. Bounded work even when all splats coincide. */
enum stp_result block_tree_crowded(const struct stp_env *env, const struct splats *splats,
                                   double overlap, unsigned limit, uint8_t *skip, size_t *count);

#endif
