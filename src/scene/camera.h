/* What every renderer asks of a camera. */
#ifndef STP_SCENE_CAMERA_H
#define STP_SCENE_CAMERA_H

#include <stipple/view.h>

/* Finite, with a picture, positive focal lengths and near before far (far may be infinite); in
 * perspective, near in front of the eye. Logs what is not so. */
enum stp_result camera_check(const struct stp_env *env, const struct stp_camera *camera);

#endif
