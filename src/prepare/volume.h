/* Voxels to kernels: classification by the transfer function, and normals from gradients. */
#ifndef STP_PREPARE_VOLUME_H
#define STP_PREPARE_VOLUME_H

#include "scene/scene.h"
#include "scene/volume.h"

/* Fills scene->volume's kernels, scene->facts and scene->core. May be called again, after the
 * transfer function has changed: the grid stays. On failure nothing has changed. */
enum stp_result prepare_volume(const struct stp_env *env, struct stp_scene *scene,
                               const struct stp_prepare_params *params);

/* From the histogram: nothing up to Otsu's threshold, then a ramp up to the 99.9th percentile. */
enum stp_result transfer_automatic(const struct stp_env *env, const struct grid *grid,
                                   struct transfer_function *function);

#endif
