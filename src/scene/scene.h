/* The scene: owned points per object, then the prepared splats and facts. */
#ifndef STP_SCENE_SCENE_H
#define STP_SCENE_SCENE_H

#include <stipple/view.h>

#include "load/cloud.h"
#include "load/environment.h"
#include "scene/splats.h"
#include "scene/stream.h"
#include "scene/version.h"
#include "scene/volume.h"

/* Where an object's colours come from: its cloud, or prepare makes them. */
enum color_source {
    COLOR_OF_CLOUD = 0, /* the material's albedo where the cloud has none */
    COLOR_BY_HEIGHT,    /* a ramp along up, from the 1st to the 99th percentile of the object */
    COLOR_BY_NORMAL,    /* 0.5 n + 0.5, linear */
};

/* Of objects that bring none. */
#define SCENE_DEFAULT_MATERIAL                                                                     \
    {                                                                                              \
        .ambient = 0.1f, .diffuse = 0.7f, .specular = 0.2f, .shininess = 32, .albedo = {           \
            0.8f,                                                                                  \
            0.8f,                                                                                  \
            0.8f                                                                                   \
        }                                                                                          \
    }

struct scene_object {
    struct cloud cloud; /* released by prepare */
    struct stp_material material;
    double epsilon; /* 0 until prepare resolves it to the median radius of the object */
    bool estimated; /* its normals were: by prepare, or by the one that wrote the file */
    float opacity;  /* [0, 1], with the material's; in splats.opacity too, once prepared */
    enum color_source color_source;
    struct stp_optics optics; /* every field as it is meant: defaults filled in */
};

#define ENVIRONMENT_LEVELS 12

/* What a lobe of this roughness receives from every direction: `height` rows of `width` texels, and
 * a row before and after them that is the pole's one value. */
struct environment_level {
    float roughness;
    uint32_t width, height;
    size_t first; /* texel */
};

struct scene_environment {
    struct environment_map map; /* width 0: there is none */
    struct stp_environment_params params;
    unsigned level_count; /* made by prepare; level 0 is the map itself, roughness ascends */
    struct environment_level level[ENVIRONMENT_LEVELS];
    float (*texel)[3]; /* of all levels, intensity multiplied in */
    size_t texel_count;
};

/* Of a scene that keeps a share of its splats (stp_scene_share). */
struct scene_share {
    unsigned rank, count; /* count 0: the scene is whole */
    size_t first;         /* canonical id of the first splat that is kept */
};

struct stp_scene {
    struct scene_object *objects;
    unsigned object_count;
    struct stp_light lights[STP_MAX_LIGHTS];
    unsigned light_count;   /* at least 1 after create: the head light */
    bool has_camera;        /* a scene .json may carry one */
    bool camera_intrinsics; /* a new size scales them; else the field of view stays */
    struct stp_camera camera;
    struct scene_environment environment;
    struct splats splats;
    struct cover_groups cover;   /* after stp_scene_cover */
    struct volume *volume;       /* NULL: none; then there are no splats */
    struct scene_stream *stream; /* NULL: none; then the splats are in the file, facts.splats */
    struct stp_facts facts;
    double core[6]; /* set by prepare, min x y z max x y z: splats whose centres are outside are
                       outliers that automatic framing leaves out */
    bool prepared;
    struct scene_share share;
    struct scene_version version;
    uint32_t changes; /* so far */
};

/* After a change: the number that its part of the version takes. None comes twice, so that a
 * grouping that is kept aside and shown again may keep its own. */
uint32_t scene_change(struct stp_scene *scene);

void environment_release(struct scene_environment *environment);

/* An error where the points stay in their file; `what` wants them all, "grouping". */
enum stp_result scene_check_whole(const struct stp_env *env, const struct stp_scene *scene,
                                  const char *what);

/* Takes ownership of *cloud (it is zeroed); on failure the cloud stays the caller's. The first
 * cloud's up and format become the scene's. A prepared scene takes no more points. */
enum stp_result scene_add_cloud(const struct stp_env *env, struct stp_scene *scene,
                                struct cloud *cloud, const struct stp_object_params *object);

#endif
