/* One picture by several processes (sort-last): each holds a share of the splats and renders it;
 * the nearest of all depths and the sums of what lies within epsilon of it are then exchanged. How
 * they are exchanged is the caller's: MPI in the command, threads in a test. docs/machines.md. */
#ifndef STIPPLE_MACHINES_H
#define STIPPLE_MACHINES_H

#include <stipple/render.h>

#ifdef __cplusplus
extern "C" {
#endif

enum stp_reduction { STP_REDUCE_MINIMUM = 0, STP_REDUCE_SUM };

/* Both functions are collective: they return when every process has called them, and all call
 * them in the same order, since all plan the same picture. */
struct stp_machines {
    unsigned rank, count; /* rank < count; rank 0, the root, gets the picture */
    void *user;
    /* STP_OK where every process passed STP_OK, else the largest result that anyone passed. */
    enum stp_result (*agree)(void *user, enum stp_result mine);
    /* In place, element by element over all processes. to_all false: the root alone gets the
     * result, and the others' values are theirs to lose. Failing is the whole job's end: it does
     * not return then. */
    void (*reduce)(void *user, enum stp_reduction reduction, int64_t *values, size_t count,
                   bool to_all);
};

/* Of a prepared scene keeps the splats n rank / count up to n (rank + 1) / count, in canonical
 * order; facts and origin stay those of the whole. Frame the camera before. Such a scene is for
 * plans and for stp_render_share only. Call once. */
STP_API enum stp_result stp_scene_share(const struct stp_env *env, struct stp_scene *scene,
                                        unsigned rank, unsigned count);

/* As stp_render, of a plan for a shared scene; collective. *image is the picture at the root, with
 * the bits that stp_render gives for the whole scene, and NULL elsewhere. A process that fails
 * logs its line and makes all others return its result, silently. */
STP_API enum stp_result stp_render_share(const struct stp_env *env, struct stp_context *context,
                                         const struct stp_scene *scene, const struct stp_plan *plan,
                                         const struct stp_machines *machines, unsigned repeat,
                                         struct stp_image **image, struct stp_render_stats *stats);

#ifdef __cplusplus
}
#endif
#endif
