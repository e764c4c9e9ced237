/* Range images to ellipsoids, and what a view makes of them (docs/range.md). */
#ifndef STP_PREPARE_RANGE_H
#define STP_PREPARE_RANGE_H

#include "scene/scene.h"
#include "scene/volume.h"

/* Fills scene->volume's kernels, scene->facts and scene->core. On failure nothing has changed. */
enum stp_result prepare_range(const struct stp_env *env, struct stp_scene *scene,
                              const struct stp_prepare_params *params);

/* range_sources.c: kernels' sources, once their places, axes and voxels are there. deviation: of
 * each kernel's depth. */
enum stp_result range_find_sources(const struct stp_env *env, const struct range *range,
                                   const float *deviation, struct kernels *kernels);

/* Who looks. */
struct range_view {
    bool orthographic;
    double eye[3]; /* orthographic: the direction of sight */
};
struct range_view range_view_of(const struct stp_camera *camera);
/* Of kernel i: its optical depth per scene unit, weighted by uncertainty and angle, and its colour.
 */
double range_tau(const struct volume *volume, const struct range_view *view, size_t i);
void range_color(const struct volume *volume, const struct range_view *view, size_t i,
                 double color[3]);

#endif
