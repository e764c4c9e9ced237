/* Exact nearest neighbours of points in canonical order: a tree of boxes over runs of them. */
#ifndef STP_PREPARE_NEIGHBOURS_H
#define STP_PREPARE_NEIGHBOURS_H

#include <stipple/result.h>

#define TREE_LEAF   8  /* points a leaf */
#define TREE_FAN    8  /* children a node */
#define TREE_LEVELS 12 /* 8^12 > 2^32 / 8 */
#define MAX_NEAREST 64

struct tree_boxes {
    double low[3][TREE_FAN], high[3][TREE_FAN];
};

struct neighbour_tree {
    size_t count;
    const double (*position)[3]; /* borrowed */
    unsigned levels;
    size_t size[TREE_LEVELS]; /* children of a level: leaves on level 0 */
    struct tree_boxes *level[TREE_LEVELS];
};

/* Any order of points gives right answers; a spatial one gives them fast. */
enum stp_result neighbour_tree_build(const struct stp_env *env, const double (*position)[3],
                                     size_t count, struct neighbour_tree *tree);
void neighbour_tree_release(struct neighbour_tree *tree);

struct neighbours {
    unsigned count;
    double distance[MAX_NEAREST]; /* squared, ascending; ties by id */
    uint32_t id[MAX_NEAREST];
};
/* The min(k, count - 1) nearest of point i, itself apart. k <= MAX_NEAREST. */
void neighbours_of(const struct neighbour_tree *tree, size_t i, unsigned k,
                   struct neighbours *nearest);

#endif
