/* The environment as a scene owns it. Its levels are made by prepare/environment.h. */
#ifndef STP_SCENE_ENVIRONMENT_H
#define STP_SCENE_ENVIRONMENT_H

#include "base/json.h"
#include "base/vec.h"
#include "scene/scene.h"

/* Fails with a line when rotation or intensity is out of range; NULL is fine. */
enum stp_result environment_check_params(const struct stp_env *env,
                                         const struct stp_environment_params *params);

/* Rows of the rotation from the world to the map's frame: right of its centre, up, and its centre
 * (docs/glass.md, "Directions"). */
struct environment_frame {
    struct vec3 right, up, centre;
};
struct environment_frame environment_frame(enum stp_up up, double rotation);

/* The environment of a scene .json: "file", "rotation" (degrees), "intensity". `folder` is
 * prepended to a relative file. No such key: untouched. */
enum stp_result environment_from_json(const struct json_at *root, const cJSON *json,
                                      struct scene_environment *environment);

#endif
