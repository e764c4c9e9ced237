#include "record/record.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "plan/survey.h"
#include "reference/reference.h"
#include "scene/scene.h"

/* The first frame, with all that is read of it. */
static enum stp_result run_first(const struct stp_env *env, struct record_frame *frame,
                                 const struct stp_scene *scene, struct stp_image *image,
                                 struct stp_render_stats *stats)
{
    struct record_deep deep;
    enum stp_result result = record_deep_create(env, frame->plan, &deep);
    frame->deep = deep.taken ? &deep : NULL;
    if (result == STP_OK)
        result = record_run(env, frame, scene, image, &stats->first_frame_ms, &stats->read_back_ms);
    if (result == STP_OK && frame->deep)
        result = record_deep_finish(env, &deep, image);
    frame->deep = NULL;
    record_deep_destroy(&deep);
    return result;
}

static enum stp_result run(const struct stp_env *env, struct record_frame *frame,
                           const struct stp_scene *scene, unsigned repeat, struct stp_image *image,
                           struct stp_render_stats *stats)
{
    double start = clock_ms();
    enum stp_result result = record_upload(env, frame, scene);
    stats->upload_ms = clock_ms() - start;
    if (result == STP_OK)
        result = run_first(env, frame, scene, image, stats);
    if (result == STP_OK && repeat)
        result = record_time(env, frame, scene, repeat, stats);
    if (result == STP_OK && frame->context->messages)
        result = log_error(env, STP_ERROR_VALIDATION, "%u validation messages",
                           frame->context->messages);
    return result;
}

static bool uses_shader(const struct stp_plan *plan, enum plan_shader shader)
{
    for (uint32_t i = 0; i < plan->pass_count; i++)
        if (plan->pass[i].shader == shader)
            return true;
    return false;
}

/* Attachments that are blended are float32. */
static bool blends(const struct stp_plan *plan)
{
    for (uint32_t i = 0; i < plan->pass_count; i++)
        if (plan->pass[i].kind == PLAN_DRAW && plan->pass[i].raster != PLAN_RASTER_WINNER)
            return true;
    return false;
}

/* More texels than every device has; the pyramid's points are cut to what the device has. */
static bool fetches(const struct stp_plan *plan)
{
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        enum plan_slot slot = plan->resource[i].slot;
        if (pass_is_texels(plan->resource[i].format) && slot != PLAN_TEXEL_POINTS &&
            slot != PLAN_TEXEL_RADII && slot != PLAN_TEXEL_CLUSTERS)
            return true;
    }
    return false;
}

enum stp_result record_check_features(const struct stp_env *env, const struct stp_context *context,
                                      const struct stp_plan *plan)
{
    const struct {
        uint32_t used;
        enum stp_feature feature;
    } needs[] = { { plan->constant[PLAN_FLOAT64], STP_FEATURE_FLOAT64 },
                  { plan->constant[PLAN_LAYERED], STP_FEATURE_VERTEX_LAYER },
                  { plan->path == STP_PATH_RASTER, STP_FEATURE_STORAGE_FORMATS },
                  { plan_covers(plan), STP_FEATURE_INDEPENDENT_BLEND },
                  { blends(plan), STP_FEATURE_FLOAT32_BLEND },
                  { fetches(plan), STP_FEATURE_TEXEL_BUFFERS },
                  { plan->path == STP_PATH_COMPUTE && plan->constant[PLAN_ATOMIC64],
                    STP_FEATURE_INT64_ATOMICS },
                  { uses_shader(plan, PLAN_SHADER_AXIS_BLOCK_SHUFFLED),
                    STP_FEATURE_SUBGROUP_SHUFFLE } };
    for (unsigned i = 0; i < sizeof needs / sizeof *needs; i++)
        if (needs[i].used && !(context->limits.features & needs[i].feature))
            return log_error(env, STP_ERROR_FEATURE, "the plan uses %s, which %s lacks",
                             stp_feature_name(needs[i].feature), context->limits.device);
    return STP_OK;
}

static enum stp_result render_on_device(const struct stp_env *env, struct stp_context *context,
                                        const struct stp_scene *scene, const struct stp_plan *plan,
                                        struct record_share *share, unsigned repeat,
                                        struct stp_image **image, struct stp_render_stats *stats)
{
    struct record_frame frame;
    struct stp_image *made = NULL;
    if (context->imported)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "an imported context submits nothing; use stp_frame_record");
    enum stp_result usable = record_check_features(env, context, plan);
    if (usable != STP_OK)
        return usable;
    context->env = env;
    enum stp_result result = STP_OK;
    if (plan_is_root(plan))
        result = record_picture(env, plan, &made);
    double start = clock_ms();
    if (result == STP_OK)
        result = record_frame_create(env, context, plan, &frame);
    if (result == STP_OK) {
        double created = clock_ms() - start;
        frame.share = share;
        result = run(env, &frame, scene, repeat, made, stats);
        stats->first_frame_ms += created;
        record_frame_destroy(&frame);
    }
    context->env = NULL;
    stats->bytes_scene = plan_bytes(plan, PLAN_SCENE);
    stats->bytes_transient = plan_bytes(plan, PLAN_TRANSIENT) + plan_bytes(plan, PLAN_OUTPUT);
    stats->bytes_peak = context->peak;
    if (result == STP_OK)
        *image = made;
    else
        stp_image_destroy(&made);
    return result;
}

static enum stp_result render(const struct stp_env *env, struct stp_context *context,
                              const struct stp_scene *scene, const struct stp_plan *plan,
                              unsigned repeat, struct stp_image **image,
                              struct stp_render_stats *stats)
{
    if (plan->share.count)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the plan is for one of several processes: stp_render_share");
    enum stp_result result = plan_check_scene(env, plan, scene);
    if (result != STP_OK)
        return result;
    if (plan->method != STP_METHOD_REFERENCE)
        return context ? render_on_device(env, context, scene, plan, NULL, repeat, image, stats)
                       : log_error(env, STP_ERROR_ARGUMENT, "method %s needs a context",
                                   stp_method_name(plan->method));
    double start = clock_ms();
    result = reference_render(env, scene, &plan->camera, &plan->params, image);
    stats->first_frame_ms = clock_ms() - start;
    return result;
}

enum stp_result stp_render(const struct stp_env *env, struct stp_context *context,
                           const struct stp_scene *scene, const struct stp_plan *plan,
                           unsigned repeat, struct stp_image **image,
                           struct stp_render_stats *stats)
{
    struct stp_render_stats unused;
    struct stp_render_stats *filled = stats ? stats : &unused;
    *filled = (struct stp_render_stats){ 0 };
    enum stp_result result = render(env, context, scene, plan, repeat, image, filled);
    if (result != STP_OK || !stats)
        return result;
    struct spot_view view = spot_view_of(scene, &plan->camera, &plan->params);
    stats->splats_drawn = spot_count(env, &view);
    return STP_OK;
}

/* A number that processes with the same picture before them share (FNV-1a), below 2^62. */
static int64_t fingerprint(const struct stp_plan *plan, unsigned repeat)
{
    const uint64_t parts[] = { plan->facts.splats,    plan->facts.objects,
                               plan->camera.width,    plan->camera.height,
                               plan->tile_width,      plan->tile_height,
                               plan->tile_count,      plan->params.aovs,
                               plan_samples(plan),    repeat,
                               plan->facts.has_color, plan->share.count };
    uint64_t hash = 0xcbf29ce484222325u;
    for (unsigned i = 0; i < sizeof parts / sizeof *parts; i++)
        hash = (hash ^ parts[i]) * 0x100000001b3u;
    return (int64_t)(hash >> 2);
}

/* Collective, when all have agreed that nobody has failed. */
static enum stp_result check_alike(const struct stp_env *env, const struct stp_machines *m,
                                   const struct stp_plan *plan, unsigned repeat)
{
    int64_t mine = fingerprint(plan, repeat), both[2] = { mine, -mine };
    m->reduce(m->user, STP_REDUCE_MINIMUM, both, 2, true);
    if (both[0] == -both[1])
        return STP_OK;
    return m->rank == 0 ? log_error(env, STP_ERROR_ARGUMENT,
                                    "the processes have planned different pictures: give all the "
                                    "same scene, options and kind of device")
                        : STP_ERROR_ARGUMENT;
}

static enum stp_result check_share(const struct stp_env *env, const struct stp_context *context,
                                   const struct stp_scene *scene, const struct stp_plan *plan,
                                   const struct stp_machines *m)
{
    if (!context)
        return log_error(env, STP_ERROR_ARGUMENT, "method %s needs a context",
                         stp_method_name(plan->method));
    if (plan->share.count != m->count || plan->share.rank != m->rank ||
        scene->share.count != m->count || scene->share.rank != m->rank)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "process %u of %u has the scene of %u of %u, and a plan for %u of %u",
                         m->rank, m->count, scene->share.rank, scene->share.count, plan->share.rank,
                         plan->share.count);
    return plan_check_scene(env, plan, scene);
}

enum stp_result stp_render_share(const struct stp_env *env, struct stp_context *context,
                                 const struct stp_scene *scene, const struct stp_plan *plan,
                                 const struct stp_machines *machines, unsigned repeat,
                                 struct stp_image **image, struct stp_render_stats *stats)
{
    struct stp_render_stats unused;
    struct record_share share = { .machines = machines };
    struct stp_image *made = NULL;
    stats = stats ? stats : &unused;
    *stats = (struct stp_render_stats){ 0 };
    enum stp_result result = check_share(env, context, scene, plan, machines);
    if (result == STP_OK)
        result = record_share_create(env, plan, machines, &share);
    result = record_agree(&share, result);
    if (result == STP_OK)
        result = check_alike(env, machines, plan, repeat);
    share.agreed |= result != STP_OK;
    if (result == STP_OK)
        result = render_on_device(env, context, scene, plan, &share, repeat, &made, stats);
    if (!share.agreed)
        result = record_agree(&share, result);
    record_share_destroy(&share);
    if (result == STP_OK)
        *image = made;
    else
        stp_image_destroy(&made);
    return result;
}
