/* Points to splats, and splats to groups. CPU only; parallel; results depend neither on the order
 * of the input nor on the number of threads. */
#ifndef STP_PREPARE_PREPARE_H
#define STP_PREPARE_PREPARE_H

#include "scene/scene.h"

/* What follows from the rest of *facts: normals, sides, lights. estimated: normals that were. */
void prepare_decide(const struct stp_scene *scene, const struct stp_prepare_params *params,
                    size_t estimated, struct stp_facts *facts);

/* ZP 4.1, Eq. 5: the overlap graph, as compressed adjacency, both directions. Rows are kept in
 * the pools that the parallel build filled: 4 bytes a directed edge and 4 a splat, never copied. */
#define OVERLAP_POOL 4096
struct overlap_graph {
    size_t count;    /* splats */
    size_t nodes;    /* of them in the graph: all but those left out */
    size_t edges;    /* undirected */
    uint32_t *end;   /* of splat i's row, in its pool */
    uint32_t **pool; /* one for every OVERLAP_POOL splats */
    unsigned max_degree;
};

/* Splat i's neighbours, ascending. */
struct overlap_row {
    const uint32_t *neighbour;
    size_t degree;
};
static inline struct overlap_row overlap_row(const struct overlap_graph *graph, size_t i)
{
    uint32_t first = i % OVERLAP_POOL ? graph->end[i - 1] : 0;
    return (struct overlap_row){ graph->pool[i / OVERLAP_POOL] + first, graph->end[i] - first };
}

/* Tolerances of relaxation (1), coplanar and of one colour. See docs/results/grouping.md for the
 * error that they allow. */
#define COPLANAR_DEGREES 1.0         /* between the normals */
#define COPLANAR_OFFSET  0.05        /* of either centre from the other's plane, in smaller radii */
#define COPLANAR_COLOR   (1.0 / 255) /* largest difference of a component, and of the opacity */

/* An edge joins i and j when d2 < t * t, in double without contraction, where d2 = dx*dx + dy*dy
 * + dz*dz of the absolute positions and t = overlap * (r_i + r_j); but none where `relax` (enum
 * stp_relax, or-ed) spares the pair:
 *   opposed   n_i.n_j < 0;
 *   coplanar  same object, and within the tolerances above.
 * A zero normal is neither. skip: NULL, or nonzero for splats left out (their rows are empty).
 * max_edges: 0, or the most undirected edges wanted; beyond it, or where the search itself is out
 * of proportion (twice as many overlaps before relaxation, or far too many candidates), *overload
 * is set (it may be NULL when max_edges is 0), the result is STP_OK and *graph is untouched. */
struct overlap_params {
    double overlap;
    unsigned relax;
    const uint8_t *skip;
    size_t max_edges;
};
enum stp_result overlap_graph_build(const struct stp_env *env, const struct splats *splats,
                                    const struct overlap_params *params,
                                    struct overlap_graph *graph, bool *overload);
void overlap_graph_release(struct overlap_graph *graph);

/* Does relaxation spare this pair its edge? The same for (i, j) and (j, i). */
bool overlap_relaxed(const struct splats *splats, unsigned relax, size_t i, size_t j);

/* Largest First (ZP 4.1, Welsh-Powell order: degree descending, then canonical id): exactly the
 * colours a sequential pass in that order gives. max_colors in [1, STP_MAX_GROUPS]: a node that
 * finds them all taken gets the one that fewest of its coloured neighbours hold (the lowest of
 * those), and is counted in *conflicts; where that is 0 the colouring is proper and *color_count
 * <= max_degree + 1. */
enum stp_result largest_first_color(const struct stp_env *env, const struct overlap_graph *graph,
                                    unsigned max_colors, uint8_t *color, unsigned *color_count,
                                    size_t *conflicts);

/* Equal in every attribute, bit for bit: the same fragments. The canonical order has put equals
 * side by side. */
bool splats_equal(const struct splats *splats, size_t i, size_t j);

/* Both, into scene->splats.group and facts.grouping.
 * - A splat equal to its predecessor in every attribute takes that one's group and no part in the
 *   graph: either of them winning a pixel gives the same fragment, counted once instead of twice.
 * - Where more than max_groups are needed, c is lowered, by bisection in 64ths of the way to
 *   GROUP_MIN_OVERLAP.
 * - Where that is not enough either there are heaps. Splats that are crowded at GROUP_MIN_OVERLAP
 *   (max_groups / 2 others, or max_groups - 1 where that is 7 or less, overlap them there and
 *   precede them by radius descending, then id) leave the graph and are spread over the groups in
 *   turn; the rest starts again from the asked c, so that a heap costs it nothing.
 * - group_warn says so; facts.grouping.crowded counts the splats that may share a group with one
 *   they overlap.
 * - So a million coincident splats are grouped too, in time and memory in proportion. */
#define GROUP_MIN_OVERLAP 0.1
enum stp_result group_scene(const struct stp_env *env, struct stp_scene *scene,
                            const struct stp_group_params *params);
/* Where the scene's grouping is not all that was asked, in a warning each. */
void group_warn(const struct stp_env *env, const struct stp_scene *scene,
                const struct stp_group_params *params);

#endif
