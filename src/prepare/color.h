/* Colours and opacities that the file did not carry. */
#ifndef STP_PREPARE_COLOR_H
#define STP_PREPARE_COLOR_H

#include "scene/scene.h"

/* Whether splats need colours of their own: some object has them, or the albedos differ. */
bool scene_wants_color(const struct stp_scene *scene);

/* Gives splats, all of one object, the colours that the object asks for; where the cloud had none,
 * the albedo. Normals and positions must be final. */
enum stp_result color_object(const struct stp_env *env, const struct scene_object *object,
                             enum stp_up up, struct splats *splats);

/* Multiplies the object's opacity into the splats' own. */
enum stp_result opacity_object(const struct stp_env *env, const struct scene_object *object,
                               struct splats *splats);

#endif
