#include "prepare/prepare.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/color.h"
#include "prepare/environment.h"
#include "prepare/facts.h"
#include "prepare/merge.h"
#include "prepare/object.h"
#include "prepare/order.h"
#include "prepare/range.h"
#include "prepare/stream.h"
#include "prepare/volume.h"

struct preparation {
    const struct stp_env *env;
    struct stp_scene *scene;
    const struct stp_prepare_params *params;
    struct stp_facts facts;
    struct splats *sets; /* an object */
    size_t *first_input;
    size_t estimated; /* splats whose normals were */
};

static enum stp_result prepare_objects(struct preparation *p)
{
    struct stp_scene *scene = p->scene;
    bool want_color = scene_wants_color(scene);
    size_t first = 0;
    for (unsigned i = 0; i < scene->object_count; i++) {
        struct object_splats made;
        p->first_input[i] = first;
        first += scene->objects[i].cloud.count;
        enum stp_result result = prepare_object(p->env, &scene->objects[i], p->facts.up,
                                                p->params->clip_box, want_color, &p->facts, &made);
        if (result != STP_OK)
            return result;
        p->sets[i] = made.splats;
        p->estimated += made.estimated ? made.splats.count : 0;
        log_progress(p->env, "prepare", 0.9 * (i + 1) / scene->object_count);
    }
    return STP_OK;
}

static enum stp_result join_objects(struct preparation *p, struct splats *splats)
{
    struct stp_scene *scene = p->scene;
    if (scene->object_count == 1) {
        *splats = p->sets[0];
        p->sets[0] = (struct splats){ 0 };
        return STP_OK;
    }
    enum stp_result result =
        merge_splats(p->env, p->sets, scene->object_count, p->first_input, splats);
    return result == STP_OK ? order_splats(p->env, splats, NULL) : result;
}

void prepare_decide(const struct stp_scene *scene, const struct stp_prepare_params *params,
                    size_t estimated, struct stp_facts *f)
{
    f->normals = f->no_normal > f->splats / 2 ? STP_NORMALS_NONE
                 : estimated > f->splats / 2  ? STP_NORMALS_ESTIMATED
                                              : STP_NORMALS_GIVEN;
    f->eye_dome = f->normals == STP_NORMALS_NONE;
    f->two_sided = params->two_sided == STP_ON;
    if (params->two_sided == STP_AUTO)
        f->two_sided = estimated > 0 || f->eye_dome || f->outwardness < 0.1;
    f->objects = scene->object_count;
    f->lights = scene->light_count;
    for (unsigned i = 0; i < scene->light_count; i++)
        f->positional_lights |= scene->lights[i].positional && !scene->lights[i].at_eye;
}

/* Opacities that are all 1, and ellipses that are all discs, need no array. */
static void drop_plain(struct preparation *p, struct splats *splats)
{
    if (!p->facts.transparent) {
        mem_free(splats->opacity);
        splats->opacity = NULL;
    }
    if (!p->facts.phong) {
        mem_free(splats->phong);
        splats->phong = NULL;
    }
}

static enum stp_result prepare(struct preparation *p, struct splats *splats, double core[6])
{
    enum stp_result result = prepare_objects(p);
    if (result == STP_OK)
        result = join_objects(p, splats);
    if (result != STP_OK)
        return result;
    if (splats->count == 0)
        return facts_no_points(p->env, &p->facts);
    result = facts_measure(p->env, splats, &p->facts, core);
    if (result != STP_OK)
        return result;
    prepare_decide(p->scene, p->params, p->estimated, &p->facts);
    drop_plain(p, splats);
    return STP_OK;
}

/* Fills scene->splats, scene->facts and scene->core from the objects' clouds, and releases the
 * clouds, each as soon as it is copied: after a failure the scene is good for destroying only. */
static enum stp_result prepare_scene(const struct stp_env *env, struct stp_scene *scene,
                                     const struct stp_prepare_params *params)
{
    struct preparation p = { .env = env, .scene = scene, .params = params, .facts = scene->facts };
    struct splats splats = { 0 };
    double core[6];
    p.sets = mem_zalloc(scene->object_count, sizeof *p.sets);
    p.first_input = mem_zalloc(scene->object_count, sizeof *p.first_input);
    enum stp_result result = p.sets && p.first_input && scene->object_count > 0
                                 ? prepare(&p, &splats, core)
                             : scene->object_count > 0 ? log_no_memory(env, 64, "the objects")
                                                       : facts_no_points(p.env, &p.facts);
    for (unsigned i = 0; p.sets && i < scene->object_count; i++)
        splats_release(&p.sets[i]);
    mem_free(p.sets);
    mem_free(p.first_input);
    if (result != STP_OK) {
        splats_release(&splats);
        return result;
    }
    scene->splats = splats;
    scene->facts = p.facts;
    memcpy(scene->core, core, sizeof core);
    scene->prepared = true;
    log_progress(env, "prepare", 1);
    return STP_OK;
}

enum stp_result stp_scene_prepare(const struct stp_env *env, struct stp_scene *scene,
                                  const struct stp_prepare_params *params)
{
    static const struct stp_prepare_params defaults;
    if (!scene || scene->prepared)
        return log_error(env, STP_ERROR_ARGUMENT, "stp_scene_prepare: %s",
                         scene ? "the scene is prepared already" : "no scene");
    if (params && params->clip_box)
        for (int axis = 0; axis < 3; axis++)
            if (!(params->clip_box[axis] <= params->clip_box[axis + 3]))
                return log_error(env, STP_ERROR_ARGUMENT,
                                 "the clip box is empty: x0 y0 z0 must be below x1 y1 z1");
    enum stp_result result = environment_build(env, scene, &scene->environment);
    if (result != STP_OK)
        return result;
    environment_facts(scene, &scene->facts);
    if (scene->volume)
        return volume_is_range(scene->volume) ? prepare_range(env, scene, params)
                                              : prepare_volume(env, scene, params);
    params = params ? params : &defaults;
    bool whole = !scene->stream;
    if (!whole)
        result = prepare_stream(env, scene, params, &whole);
    if (result == STP_OK && scene->stream && whole)
        result = stream_read_whole(env, scene);
    return result == STP_OK && whole ? prepare_scene(env, scene, params) : result;
}
