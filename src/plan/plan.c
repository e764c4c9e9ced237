#include "plan/offer.h"
#include "plan/pyramid_probe.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/camera.h"
#include "scene/scene.h"

#define MOST_SPLATS                                                                                \
    (INT32_MAX / 3) /* gl_VertexIndex is an int, and a draw has three vertices a splat */

/* What a caller casts or leaves uninitialised must not index a table. */
static enum stp_result check_choices(const struct stp_env *env, const struct stp_render_params *p)
{
    const struct {
        const char *what;
        unsigned value, last;
    } choice[] = {
        { "method", p->method, STP_METHOD_AXIS },
        { "transparency", p->transparency, STP_TRANSPARENCY_REFERENCE },
        { "layers", p->layers, STP_LAYERS_SINGLE },
        { "path", p->path, STP_PATH_COMPUTE },
        { "payload", p->payload, STP_PAYLOAD_PACKED },
        { "voronoi", p->voronoi, STP_VORONOI_EXACT },
        { "kernel", p->kernel, STP_KERNEL_GAUSS },
        { "shade", p->shade, STP_SHADE_FLAT },
        { "light_cube", p->light_cube, STP_OFF },
        { "cull", p->cull, STP_CULL_BACK },
        { "axis_merge", p->axis_merge, STP_AXIS_REFERENCE },
    };
    for (size_t i = 0; i < sizeof choice / sizeof *choice; i++)
        if (choice[i].value > choice[i].last)
            return log_error(env, STP_ERROR_ARGUMENT, "%s %u: the last there is has number %u",
                             choice[i].what, choice[i].value, choice[i].last);
    return STP_OK;
}

const struct stp_render_params *plan_params(const struct stp_render_params *params)
{
    static const struct stp_render_params defaults;
    return params ? params : &defaults;
}

enum stp_result plan_check(const struct stp_env *env, const struct stp_scene *scene,
                           const struct stp_camera *camera, const struct stp_render_params *params)
{
    if (!scene->prepared || (scene->splats.count == 0 && !scene->volume && !scene->stream))
        return log_error(env, STP_ERROR_ARGUMENT, "a plan needs a prepared scene with splats");
    if (camera->width == 0 || camera->height == 0 || camera->width > 65536 ||
        camera->height > 65536)
        return log_error(env, STP_ERROR_ARGUMENT, "%u x %u is no size that can be rendered",
                         camera->width, camera->height);
    if (params->epsilon != 0 && !(params->epsilon >= 1e-30 && params->epsilon <= 1e30))
        return log_error(env, STP_ERROR_ARGUMENT, "epsilon %g is not in 1e-30 .. 1e30",
                         params->epsilon);
    if (camera_check(env, camera) != STP_OK)
        return STP_ERROR_ARGUMENT;
    if (params->samples > STP_MAX_SAMPLES)
        return log_error(env, STP_ERROR_ARGUMENT, "%u samples a pixel: at most %u", params->samples,
                         STP_MAX_SAMPLES);
    if (params->environment_behind && !scene->facts.environment_levels)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the background is to be the environment, and the scene has none");
    enum stp_result result = check_choices(env, params);
    if (result != STP_OK)
        return result;
    size_t splats = scene->stream ? scene->facts.splats : scene->splats.count;
    if (splats > MOST_SPLATS)
        return log_error(env, STP_ERROR_ARGUMENT, "%zu splats: at most %d", splats, MOST_SPLATS);
    if (params->method != STP_METHOD_PYRAMID)
        return scene_check_whole(env, scene, "this method");
    if (params->aovs & STP_AOV_ID)
        return scene_check_whole(env, scene, "the aov id");
    return STP_OK;
}

/* Where each group begins when splats are taken group by group. */
static void group_ranges(struct stp_plan *plan, const struct stp_scene *scene)
{
    uint32_t counts[STP_MAX_GROUPS] = { 0 };
    for (size_t i = 0; i < scene->splats.count; i++)
        counts[scene->splats.group[i]]++;
    for (unsigned k = 0; k < STP_MAX_GROUPS; k++)
        plan->group_first[k + 1] = plan->group_first[k] + counts[k];
}

/* The extended groups, and the groups that they were extended from. */
static void cover_ranges(struct stp_plan *plan, const struct stp_scene *scene)
{
    const struct cover_groups *cover = &scene->cover;
    uint32_t counts[STP_MAX_GROUPS] = { 0 };
    for (size_t i = 0; i < scene->splats.count; i++)
        if (cover->home[i] < cover->groups)
            counts[cover->home[i]]++;
    for (unsigned k = 0; k < cover->groups; k++) {
        plan->group_first[k + 1] = plan->group_first[k] + counts[k];
        plan->cover_first[k + 1] = cover->first[k + 1];
    }
}

static enum stp_result fill(const struct stp_env *env, struct stp_plan *plan,
                            const struct stp_scene *scene)
{
    plan_frame_constants(plan, scene);
    enum stp_result result = plan_choose(env, plan);
    if (result != STP_OK || plan->method == STP_METHOD_REFERENCE)
        return result;
    if (plan->method == STP_METHOD_AXIS)
        result = plan_axis_prepare(env, plan, scene);
    if (result != STP_OK)
        return result;
    if (plan->method == STP_METHOD_AXIS)
        plan->frame.axis.splats = (uint32_t)plan->facts.splats;
    if (plan_covers(plan))
        cover_ranges(plan, scene);
    else if (plan->path == STP_PATH_RASTER && plan->method == STP_METHOD_DEFERRED)
        group_ranges(plan, scene);
    return plan_tiles(env, plan);
}

static struct stp_plan *start(const struct stp_scene *scene, const struct stp_camera *camera,
                              const struct stp_render_params *params,
                              const struct stp_limits *limits)
{
    struct stp_plan *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return NULL;
    made->params = *params;
    made->camera = *camera;
    made->facts = scene->facts;
    made->version = scene->version;
    made->share = (struct plan_share){ scene->share.rank, scene->share.count, scene->splats.count };
    if (scene->stream) {
        made->stream_count = scene->stream->chunk_count;
        memcpy(made->stream, scene->stream->chunk, sizeof made->stream);
    }
    made->limits = *limits;
    made->limits.features &= ~params->mask_features;
    if (params->background) {
        for (int i = 0; i < 4; i++)
            made->background[i] = params->background[i];
        made->params.background = made->background;
    }
    return made;
}

enum stp_result stp_plan_create(const struct stp_env *env, const struct stp_scene *scene,
                                const struct stp_camera *camera,
                                const struct stp_render_params *params,
                                const struct stp_limits *limits, struct stp_plan **plan)
{
    params = plan_params(params);
    enum stp_result result = plan_check(env, scene, camera, params);
    if (result != STP_OK)
        return result;
    struct stp_plan *made = start(scene, camera, params, limits);
    if (!made)
        return log_no_memory(env, sizeof *made, "the plan");
    result = fill(env, made, scene);
    if (result != STP_OK)
        stp_plan_destroy(&made);
    else
        *plan = made;
    return result;
}

/* The groups themselves, which only a pass a layer would ask for, are not known: all splats count
 * as the first's. */
enum stp_result plan_try(const struct stp_env *env, const struct stp_scene *scene,
                         const struct stp_camera *camera, const struct stp_render_params *params,
                         const struct stp_limits *limits, const struct plan_candidate *candidate,
                         const struct stp_grouping *grouping, struct stp_plan **plan)
{
    const struct stp_env quiet = { .threads = env ? env->threads : 0, .log = log_nothing };
    struct stp_plan *made = start(scene, camera, params, limits);
    if (!made)
        return log_no_memory(env, sizeof *made, "a plan");
    made->params.method = candidate->method;
    made->params.path = candidate->path;
    made->params.payload = candidate->payload;
    made->params.voronoi = candidate->overlap > 0 ? candidate->voronoi : params->voronoi;
    made->params.transparency = candidate->transparency;
    if (candidate->layers)
        made->params.peel_layers = candidate->layers;
    made->facts.grouping = *grouping;
    for (unsigned k = 1; k <= STP_MAX_GROUPS; k++)
        made->group_first[k] = (uint32_t)made->facts.splats;
    plan_frame_constants(made, scene);
    enum stp_result result = plan_choose(&quiet, made);
    if (result == STP_OK)
        result = plan_tiles(&quiet, made);
    bool same = result == STP_OK && made->path == candidate->path &&
                made->voronoi == candidate->voronoi &&
                (candidate->payload == STP_PAYLOAD_AUTO || made->payload == candidate->payload ||
                 candidate->method == STP_METHOD_TWO_PASS) &&
                pyramid_can_judge(made);
    if (same)
        *plan = made;
    else
        stp_plan_destroy(&made);
    return result == STP_ERROR_MEMORY ? log_no_memory(env, sizeof *made, "a plan") : STP_OK;
}

enum stp_result plan_copy(const struct stp_env *env, const struct stp_plan *plan,
                          struct stp_plan **copy)
{
    struct stp_plan *made = mem_alloc(1, sizeof *made);
    struct plan_tile *tiles = mem_alloc(plan->tile_count, sizeof *tiles);
    if (!made || !tiles) {
        mem_free(made);
        mem_free(tiles);
        return log_no_memory(env, sizeof *made, "a copy of the plan");
    }
    *made = *plan;
    memcpy(tiles, plan->tile, plan->tile_count * sizeof *tiles);
    made->tile = tiles;
    /* Recording needs no lists: uploading does, from the plan itself. */
    plan_axis_forget(made);
    if (plan->params.background)
        made->params.background = made->background;
    *copy = made;
    return STP_OK;
}

void stp_plan_destroy(struct stp_plan **plan)
{
    if (!plan || !*plan)
        return;
    mem_free((*plan)->tile);
    axis_lists_release(&(*plan)->axis);
    axis_blocks_release(&(*plan)->axis_blocks);
    mem_free(*plan);
    *plan = NULL;
}

void stp_plan_summarize(const struct stp_plan *plan, struct stp_plan_summary *summary)
{
    *summary = (struct stp_plan_summary){
        .method = plan->method,
        .transparency = plan->transparency,
        .path = plan->path,
        .payload = plan->payload,
        .voronoi = plan->voronoi,
        .why = plan->why,
        .scene_bytes = plan_bytes(plan, PLAN_SCENE),
        .transient_bytes = plan_bytes(plan, PLAN_TRANSIENT),
        .output_bytes = plan_bytes(plan, PLAN_OUTPUT),
        .tiles = plan->tile_count,
        .passes = plan->pass_count,
        .resources = plan->resource_count,
    };
}

/* A number that is cast to an enum may be anything. */
static const char *name_of(const char *const *names, size_t count, unsigned value)
{
    return value < count ? names[value] : NULL;
}
#define NAME_OF(names, value) name_of(names, sizeof names / sizeof *names, (unsigned)(value))

const char *stp_method_name(enum stp_method method)
{
    static const char *const names[] = { "auto",      "deferred", "two-pass", "exact",
                                         "reference", "pyramid",  "axis" };
    return NAME_OF(names, method);
}

const char *stp_transparency_name(enum stp_transparency transparency)
{
    static const char *const names[] = { "auto", "fast", "nearest", "peel", "exact", "reference" };
    return NAME_OF(names, transparency);
}

const char *stp_path_name(enum stp_path path)
{
    static const char *const names[] = { "auto", "raster", "compute" };
    return NAME_OF(names, path);
}
