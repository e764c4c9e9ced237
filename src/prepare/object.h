/* One object: from its cloud to splats of its own. */
#ifndef STP_PREPARE_OBJECT_H
#define STP_PREPARE_OBJECT_H

#include "scene/scene.h"

struct object_splats {
    struct splats splats; /* canonical order; normals, radii and inputs set */
    bool estimated;       /* normals were, all of them */
};

/* Consumes object->cloud, resolves object->epsilon, adds to the counts of *facts. want_color: give
 * the splats colours even where the cloud has none. An object of no points gives no splats. */
enum stp_result prepare_object(const struct stp_env *env, struct scene_object *object,
                               enum stp_up up, const double *clip_box, bool want_color,
                               struct stp_facts *facts, struct object_splats *out);

#endif
