/* stp_report: the reference, the plans that apply, their frames in turns, the files. */
#include "study/study.h"

#include <stipple/report.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "reference/reference.h"
#include "scene/scene.h"

/* Why a configuration does not apply: the line that its plan would have logged. */
static void keep_line(void *user, enum stp_log_level level, const char *line)
{
    struct report_skip *skip = user;
    if (level == STP_LOG_ERROR)
        snprintf(skip->why, sizeof skip->why, "%s", line);
}

static enum stp_result make_plan(struct study *study, const struct study_config *config,
                                 struct report_skip *skip, struct stp_plan **plan)
{
    struct stp_env env = { .threads = study->quiet.threads, .log = keep_line, .user = skip };
    struct stp_render_params params = study->params.render;
    params.method = config->method;
    params.path = config->path;
    params.payload = config->payload;
    params.voronoi = config->voronoi;
    params.transparency = config->transparency;
    params.peel_layers = config->peel_layers;
    params.axis_merge = config->merge;
    params.axis_h = config->axis_h;
    params.samples = params.aovs = 0;
    if (config->epsilon_scale != 1)
        params.epsilon = study->epsilon * config->epsilon_scale;
    return stp_plan_create(&env, study->scene, study->camera, &params,
                           stp_context_limits(study->context), plan);
}

static void add_frame(struct study *study, const struct study_config *config, struct stp_plan *plan)
{
    struct report_row *row = &study->report.row[study->frame_count];
    struct study_config settled = *config;
    if (config->overlap > 0 && config->payload == STP_PAYLOAD_AUTO)
        settled.payload = plan->payload;
    study_describe(&settled, row);
    if (config->overlap > 0)
        row->grouping = study->scene->facts.grouping;
    row->scene_bytes = plan_bytes(plan, PLAN_SCENE);
    row->transient_bytes = plan_bytes(plan, PLAN_TRANSIENT);
    row->tiles = plan->tile_count;
    row->pass_count = plan->pass_count;
    study->has_exact |= plan->method == STP_METHOD_EXACT;
    study->frame[study->frame_count++] = (struct study_frame){ .config = *config, .plan = plan };
}

static void add_skip(struct study *study, const struct study_config *config,
                     const struct report_skip *skip)
{
    struct report_row row = { 0 };
    char name[REPORT_NAME_SIZE];
    struct report_skip *added = &study->report.skip[study->report.skip_count++];
    *added = *skip;
    study_describe(config, &row);
    snprintf(added->name, sizeof added->name, "%s", report_row_name(&row, name));
}

/* Groups that cover the surface, for those that want them; the scene keeps them. */
static enum stp_result cover(struct study *study, const struct study_config *config)
{
    struct stp_cover_params params = { .groups = study->params.group.max_groups };
    struct stp_render_params render = study->params.render;
    render.method = config->method;
    render.transparency = config->transparency;
    if (study->scene->cover.groups ||
        !stp_plan_needs_cover(&study->scene->facts, &render, stp_context_limits(study->context)))
        return STP_OK;
    return stp_scene_cover(study->env, study->scene, &params);
}

/* A configuration that does not apply is left out, with the reason; only want of host memory ends
 * the study. */
enum stp_result study_try(struct study *study, const struct study_config *config)
{
    struct report_skip skip = { "", "" };
    struct stp_plan *plan = NULL;
    enum stp_result result = STP_OK;
    if (config->overlap > 0)
        result = groupings_use(study->env, &study->groups, &study->params.group, config->overlap);
    if (result == STP_OK)
        result = cover(study, config);
    if (result != STP_OK)
        return result;
    result = make_plan(study, config, &skip, &plan);
    if (result == STP_ERROR_MEMORY)
        return log_error(study->env, result, "%s", skip.why);
    const char *mismatch = result == STP_OK ? study_mismatch(config, plan) : NULL;
    if (result == STP_OK && !mismatch) {
        add_frame(study, config, plan);
        return STP_OK;
    }
    stp_plan_destroy(&plan);
    if (mismatch)
        snprintf(skip.why, sizeof skip.why, "%s", mismatch);
    add_skip(study, config, &skip);
    return STP_OK;
}

static enum stp_result make_frames(struct study *study)
{
    struct study_config configs[STUDY_MAX_CONFIGS];
    unsigned count = study_configs(&study->scene->facts, study->params.quick, configs);
    unsigned most = count + REPORT_MAX_PICKS; /* auto may add its own */
    study->frame = mem_zalloc(most, sizeof *study->frame);
    study->report.row = mem_zalloc(most + 1, sizeof *study->report.row);
    study->report.skip = mem_zalloc(most, sizeof *study->report.skip);
    if (!study->frame || !study->report.row || !study->report.skip)
        return log_no_memory(study->env, count * sizeof *study->report.row, "the report");
    enum stp_result result = STP_OK;
    for (unsigned i = 0; result == STP_OK && i < count; i++) {
        /* One epsilon cannot stand for the many of several objects. */
        bool many = configs[i].epsilon_scale != 1 && study->scene->object_count > 1;
        if (!many)
            result = study_try(study, &configs[i]);
    }
    if (result == STP_OK && study->frame_count == 0)
        result = log_error(study->env, STP_ERROR_FEATURE, "no method applies: %s",
                           study->report.skip_count ? study->report.skip[0].why : "nothing tried");
    return result;
}

static enum stp_result render_reference(struct study *study)
{
    struct stp_render_params params = study->params.render;
    params.samples = params.aovs = 0;
    double start = clock_ms();
    enum stp_result result =
        reference_render(study->env, study->scene, study->camera, &params, &study->reference);
    if (result != STP_OK)
        return result;
    double ms = clock_ms() - start;
    struct report_row *row = &study->report.row[study->frame_count];
    struct stp_compare_params compare = { .epsilon = study->epsilon };
    *row = (struct report_row){ .method = "reference",
                                .path = "",
                                .payload = "",
                                .voronoi = "",
                                .epsilon_scale = 1,
                                .is_reference = true,
                                .ms = { 1, ms, ms, ms, ms, ms } };
    study->report.row_count = study->frame_count + 1;
    return stp_compare(&study->quiet, study->reference, study->reference, &compare, &row->error);
}

static void describe(struct study *study)
{
    const struct stp_report_params *p = &study->params;
    const struct stp_limits *limits = stp_context_limits(study->context);
    struct report *r = &study->report;
    r->title = p->title ? p->title : "scene";
    r->command = p->command;
    r->device = limits->device;
    r->driver = limits->driver;
    r->version = stp_version();
    r->width = study->camera->width;
    r->height = study->camera->height;
    r->is_volume = study->scene->volume != NULL;
    r->splats = r->is_volume ? study->scene->volume->kernels.count : study->scene->splats.count;
    r->epsilon = study->epsilon;
    r->min_splat = p->render.min_splat < 0   ? 0
                   : p->render.min_splat > 0 ? p->render.min_splat
                                             : STP_DEFAULT_MIN_SPLAT;
    r->kernel = p->render.kernel == STP_KERNEL_GAUSS ? "gauss" : "parabola";
    r->cull = p->render.cull == STP_CULL_BACK ? "back" : "none";
    r->rounds = p->rounds ? p->rounds : p->quick ? 2 : 3;
}

static enum stp_result study_all(struct study *study, const char *folder)
{
    double start = clock_ms();
    enum stp_result result = make_frames(study);
    if (result == STP_OK)
        result = study_pick(study);
    if (result == STP_OK)
        result = render_reference(study);
    if (result == STP_OK)
        result = study_time(study);
    if (result == STP_OK)
        result = study_log_costs(study);
    if (result == STP_OK) {
        report_find_front(&study->report);
        result = study_profile(study);
    }
    if (result == STP_OK)
        result = study_samples(study);
    if (result == STP_OK && study->context->messages)
        result = log_error(study->env, STP_ERROR_VALIDATION, "%u validation messages",
                           study->context->messages);
    study->report.seconds = (clock_ms() - start) * 1e-3;
    return result == STP_OK ? study_write(study, folder) : result;
}

static void release(struct study *study)
{
    for (unsigned i = 0; i < study->frame_count; i++) {
        study_frame_sleep(study, &study->frame[i]);
        stp_plan_destroy(&study->frame[i].plan);
        heat_release(&study->frame[i].heat);
        mem_free(study->frame[i].ms);
    }
    groupings_end(&study->groups, false);
    stp_image_destroy(&study->reference);
    mem_free(study->frame);
    mem_free(study->report.row);
    mem_free(study->report.skip);
}

/* What depth errors are relative to: of a volume the finest spacing. */
static double default_epsilon(const struct study *study)
{
    const struct stp_scene *scene = study->scene;
    if (study->params.render.epsilon > 0)
        return study->params.render.epsilon;
    if (scene->volume && !volume_is_range(scene->volume))
        return volume_finest(&scene->volume->grid);
    return scene->object_count == 1 ? scene->objects[0].epsilon
                                    : (double)scene->facts.radius_median;
}

enum stp_result stp_report(const struct stp_env *env, struct stp_context *context,
                           struct stp_scene *scene, const struct stp_camera *camera,
                           const struct stp_report_params *params, const char *folder)
{
    static const struct stp_report_params defaults;
    struct study study = { .env = env, .context = context, .scene = scene, .camera = camera };
    if (!context || !scene->prepared || !(scene->splats.count || scene->volume))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "a report needs a context and a prepared scene with splats or a volume");
    study.params = params ? *params : defaults;
    if (env)
        study.quiet = *env;
    study.quiet.progress = NULL;
    study.epsilon = default_epsilon(&study);
    study.budget = study_budget(context);
    groupings_begin(&study.groups, scene);
    describe(&study);
    context->env = &study.quiet;
    enum stp_result result = study_all(&study, folder);
    release(&study);
    context->env = NULL;
    return result;
}
