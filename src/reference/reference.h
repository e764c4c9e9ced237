/* The float64 renderer of ACCURACY terms: every method is measured against it. Slow, short,
 * obviously right; shares no code with passes/ or glsl/. */
#ifndef STP_REFERENCE_REFERENCE_H
#define STP_REFERENCE_REFERENCE_H

#include <stipple/image.h>
#include <stipple/plan.h>

#include "reference/disc.h"
#include "scene/scene.h"

/* Renders the prepared scene: R G B A Z N.* and the AOVs of params->aovs. */
enum stp_result reference_render(const struct stp_env *env, const struct stp_scene *scene,
                                 const struct stp_camera *camera,
                                 const struct stp_render_params *params, struct stp_image **image);

/* What the reference draws: for others that look at single pixels with its own eyes. */
struct view reference_view(const struct stp_scene *scene, const struct stp_camera *camera,
                           const struct stp_render_params *params);

#endif
