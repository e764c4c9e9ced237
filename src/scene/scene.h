/* The scene: owned points per object, then the prepared splats and facts. */
#ifndef STP_SCENE_SCENE_H
#define STP_SCENE_SCENE_H

#include <stipple/view.h>

#include "load/cloud.h"
#include "scene/splats.h"

struct scene_object {
    struct cloud cloud; /* released by prepare */
    struct stp_material material;
    double epsilon; /* 0 until prepare resolves it to the median radius of the object */
    float opacity;
};

struct stp_scene {
    struct scene_object *objects;
    unsigned object_count;
    struct stp_light lights[STP_MAX_LIGHTS];
    unsigned light_count; /* at least 1 after create: the head light */
    bool has_camera;      /* a scene .json may carry one */
    bool camera_intrinsics;    /* a new size scales them; else the field of view stays */
    struct stp_camera camera;
    struct splats splats;
    struct stp_facts facts;
    bool prepared;
};

/* Takes ownership of *cloud (it is zeroed). */
enum stp_result scene_add_cloud(const struct stp_env *env, struct stp_scene *scene,
                                struct cloud *cloud, const struct stp_object_params *object);

#endif
