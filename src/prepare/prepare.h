/* Points to splats, and splats to groups. CPU only; parallel; results depend neither on the order
 * of the input nor on the number of threads. */
#ifndef STP_PREPARE_PREPARE_H
#define STP_PREPARE_PREPARE_H

#include "scene/scene.h"

/* Fills scene->splats, scene->facts and scene->core from the objects' clouds, and releases the
 * clouds, each as soon as it is copied: after a failure the scene is good for destroying only. */
enum stp_result prepare_scene(const struct stp_env *env, struct stp_scene *scene,
                              const struct stp_prepare_params *params);

/* ZP 4.1, Eq. 5: the overlap graph, as compressed adjacency (CSR), both directions. */
struct overlap_graph {
    size_t count;
    size_t *first;       /* count + 1 */
    uint32_t *neighbour; /* sorted within a node */
    unsigned max_degree;
};
enum stp_result overlap_graph_build(const struct stp_env *env, const struct splats *splats,
                                    double overlap, unsigned relax, struct overlap_graph *graph);
void overlap_graph_release(struct overlap_graph *graph);

/* Largest First (ZP 4.1, Welsh-Powell order: degree descending, then canonical id): the colours a
 * sequential pass in that order gives, computed in parallel. */
enum stp_result largest_first_color(const struct stp_env *env, const struct overlap_graph *graph,
                                    uint8_t *color, unsigned *color_count);

/* Both, into scene->splats.group and facts.grouping; lowers c until max_groups holds. */
enum stp_result group_scene(const struct stp_env *env, struct stp_scene *scene,
                            const struct stp_group_params *params);

#endif
