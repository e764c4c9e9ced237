/* stp_calibrate: every synthetic scene under every kind of plan, timed, and prices fitted to it. */
#include "study/calibrate.h"

#include <math.h>
#include <stdio.h>

#include "base/log.h"
#include "base/memory.h"
#include "plan/fit.h"
#include "plan/profile.h"
#include "record/record.h"
#include "report/report.h"
#include "study/study.h"

#define ROUNDS     2  /* far enough apart that what disturbs one may spare the other */
#define MOST_TIMED 8  /* frames of a visit */
#define ENOUGH     20 /* milliseconds of them, without what compiles */
#define LINE_SIZE  512
#define MOST_ROWS  64 /* of a kind */
#define MOST_HELD  128
#define CELLS      64 /* of a probe that counts layers */

struct rows {
    unsigned count, at; /* at: the next of this round */
    bool plain;         /* colours make no difference to this kind */
    double amount[MOST_ROWS * PLAN_TERMS], ns[MOST_ROWS];
};

/* A scene, ready for both rounds. */
struct bed {
    struct stp_scene *scene;
    struct stp_camera camera;
    struct stp_render_params params;
    struct survey survey;
    bool colored;
};

struct calibrating {
    const struct stp_env *env;
    struct stp_env quiet;
    struct stp_context *context;
    struct rows *rows; /* one a kind */
    struct bed *bed;   /* one a scene */
    /* Compiling takes longer than the frames: what one frame compiled is held for others. */
    unsigned held_count;
    struct record_pipelines *held[MOST_HELD];
    char line[LINE_SIZE];
};

/* False: they are new, and the first frame will compile. */
static bool hold(struct calibrating *c, struct record_pipelines *pipelines)
{
    for (unsigned i = 0; i < c->held_count; i++)
        if (c->held[i] == pipelines)
            return true;
    if (c->held_count < MOST_HELD) {
        gpu_use_kept(c->context, &pipelines->kept);
        c->held[c->held_count++] = pipelines;
    }
    return false;
}

/* The least of a few frames: what disturbs a frame only lengthens it. */
static enum stp_result time_plan(struct calibrating *c, const struct bed *bed,
                                 const struct stp_plan *plan, double *ms)
{
    struct record_frame frame;
    double each, unused, spent = 0;
    enum stp_result result = record_frame_create(&c->quiet, c->context, plan, &frame);
    if (result != STP_OK)
        return result;
    bool known = hold(c, frame.pipelines);
    result = record_upload(&c->quiet, &frame, bed->scene);
    if (result == STP_OK) /* compiles, and touches the memory */
        result = record_run(&c->quiet, &frame, bed->scene, NULL, ms, &unused);
    if (known)
        spent = *ms;
    for (unsigned i = 0; result == STP_OK && i < MOST_TIMED && spent < ENOUGH; i++) {
        result = record_run(&c->quiet, &frame, bed->scene, NULL, &each, &unused);
        *ms = fmin(*ms, each);
        spent += each;
    }
    record_frame_destroy(&frame);
    return result;
}

static enum stp_result add_row(struct calibrating *c, const struct bed *bed,
                               const struct stp_plan *plan, bool seen[PLAN_COSTS])
{
    double amount[PLAN_TERMS] = { 0 }, ms = 0;
    enum plan_cost kind = plan_offer_of(plan)->cost(plan, &bed->survey, amount);
    struct rows *rows = &c->rows[kind];
    if (seen[kind] || rows->at == MOST_ROWS || (bed->colored && rows->plain))
        return STP_OK;
    seen[kind] = true;
    rows->plain = rows->plain || !bed->colored;
    enum stp_result result = time_plan(c, bed, plan, &ms);
    if (result != STP_OK)
        return result;
    for (int t = 0; t < PLAN_TERMS; t++)
        rows->amount[rows->at * PLAN_TERMS + t] = amount[t];
    bool again = rows->at < rows->count;
    rows->ns[rows->at] = again ? fmin(rows->ns[rows->at], ms * 1e6) : ms * 1e6;
    rows->at++;
    rows->count += !again;
    return STP_OK;
}

static struct stp_render_params params_of(const struct bed *bed, const struct plan_candidate *way)
{
    struct stp_render_params p = bed->params;
    p.method = way->method;
    p.path = way->path;
    p.payload = way->payload;
    p.voronoi = way->overlap > 0 ? way->voronoi : p.voronoi;
    p.transparency = way->transparency;
    p.peel_layers = way->layers;
    return p;
}

/* Each kind once a scene, in the scene's own grouping. */
static enum stp_result run_offer(struct calibrating *c, const struct bed *bed,
                                 const struct plan_offer *offer, bool seen[PLAN_COSTS])
{
    const struct stp_env silent = { .threads = c->quiet.threads, .log = log_nothing };
    struct plan_candidate way[PLAN_MAX_OFFERED];
    unsigned count = offer->candidates(way);
    enum stp_result result = STP_OK;
    if ((offer->transparency != STP_TRANSPARENCY_AUTO) != bed->scene->facts.transparent)
        return STP_OK;
    for (unsigned i = 0; result == STP_OK && i < count; i++) {
        struct stp_plan *plan = NULL;
        struct stp_render_params p = params_of(bed, &way[i]);
        /* What does not apply has no price. */
        result = stp_plan_create(&silent, bed->scene, &bed->camera, &p, &c->context->limits, &plan);
        if (result == STP_OK)
            result = add_row(c, bed, plan, seen);
        else if (result == STP_ERROR_FEATURE || result == STP_ERROR_ARGUMENT)
            result = STP_OK;
        stp_plan_destroy(&plan);
    }
    return result;
}

static enum stp_result run_bed(struct calibrating *c, const struct bed *bed)
{
    bool seen[PLAN_COSTS] = { false };
    enum stp_result result = STP_OK;
    for (unsigned o = 0; result == STP_OK && o < plan_offer_count; o++)
        result = run_offer(c, bed, plan_offers[o], seen);
    return result;
}

static enum stp_result count_layers(struct calibrating *c, struct bed *bed)
{
    struct probe probe;
    enum stp_result result =
        probe_make(&c->quiet, bed->scene, &bed->camera, &bed->params, &bed->survey,
                   &(const struct probe_sample){ .cells = CELLS, .alone = true }, &probe);
    if (result != STP_OK)
        return result;
    bed->survey.layers = probe.layers;
    probe_release(&probe);
    return STP_OK;
}

static enum stp_result make_bed(struct calibrating *c, const struct calibrate_scene *what,
                                struct bed *bed)
{
    struct calibrate_scene grown = *what;
    if (c->context->limits.processor == 2) { /* whose frames would be too short to tell apart */
        grown.splats *= 4;
        grown.size *= 2;
    }
    *bed = (struct bed){ .colored = what->color };
    bed->params =
        (struct stp_render_params){ .min_splat = -1,
                                    .cull = what->opacity > 0 ? STP_CULL_NONE : STP_CULL_BACK };
    enum stp_result result = calibrate_scene_make(&c->quiet, &grown, &bed->scene, &bed->camera);
    if (result == STP_OK)
        result = survey_make(&c->quiet, bed->scene, &bed->camera, &bed->params, &bed->survey);
    if (result == STP_OK && what->opacity > 0)
        result = count_layers(c, bed);
    return result;
}

static void release(struct calibrating *c, unsigned count)
{
    for (unsigned i = 0; c->bed && i < count; i++) {
        survey_release(&c->bed[i].survey);
        stp_scene_destroy(&c->bed[i].scene);
    }
    for (unsigned i = 0; i < c->held_count; i++)
        gpu_leave_kept(c->context, &c->held[i]->kept);
    mem_free(c->bed);
    mem_free(c->rows);
}

static void fit(const struct calibrating *c, struct stp_calibration *calibration)
{
    struct stp_calibration known;
    calibration_built_in(&known);
    *calibration = (struct stp_calibration){ .measured = true };
    for (unsigned kind = 0; kind < PLAN_COSTS; kind++) {
        const struct rows *rows = &c->rows[kind];
        if (rows->count == 0)
            continue;
        fit_prices(rows->count, PLAN_TERMS, rows->amount, rows->ns, known.ns[kind],
                   calibration->ns[kind]);
        for (unsigned i = 0; i < rows->count; i++)
            study_log_amounts(c->env, kind, &rows->amount[i * PLAN_TERMS], rows->ns[i] * 1e-6);
    }
}

/* Why it failed, for the one line that says so. */
static void keep_line(void *user, enum stp_log_level level, const char *line)
{
    char *kept = user;
    if (level == STP_LOG_ERROR && !kept[0])
        snprintf(kept, LINE_SIZE, "%s", line);
}

enum stp_result calibrate_measure(const struct stp_env *env, struct stp_context *context,
                                  const struct calibrate_scene *scenes, unsigned count,
                                  struct stp_calibration *calibration)
{
    struct calibrating c = { .env = env, .context = context };
    enum stp_result result = STP_OK;
    c.quiet =
        (struct stp_env){ .threads = env ? env->threads : 0, .log = keep_line, .user = c.line };
    c.rows = mem_zalloc(PLAN_COSTS, sizeof *c.rows);
    c.bed = mem_zalloc(count, sizeof *c.bed);
    if (!c.rows || !c.bed) {
        release(&c, 0);
        return log_no_memory(env, PLAN_COSTS * sizeof *c.rows, "the calibration");
    }
    context->env = &c.quiet;
    for (unsigned i = 0; result == STP_OK && i < ROUNDS * count; i++) {
        log_progress(env, "calibrate", (double)i / (ROUNDS * count));
        for (unsigned kind = 0; i % count == 0 && kind < PLAN_COSTS; kind++)
            c.rows[kind].at = 0;
        if (i < count)
            result = make_bed(&c, &scenes[i], &c.bed[i]);
        if (result == STP_OK)
            result = run_bed(&c, &c.bed[i % count]);
    }
    context->env = NULL;
    if (result == STP_OK)
        fit(&c, calibration);
    else
        log_error(env, result, "calibrating %s: %s", context->limits.device,
                  c.line[0] ? c.line : stp_result_text(result));
    release(&c, count);
    return result;
}

enum stp_result stp_calibrate(const struct stp_env *env, struct stp_context *context,
                              const struct stp_calibrate_params *params)
{
    const struct stp_calibrate_params none = { 0 }, *p = params ? params : &none;
    struct stp_calibration read;
    char *path = NULL;
    bool found = false;
    enum stp_result result = calibrate_cache_path(env, &context->limits, &path);
    if (result == STP_OK && path && !p->again)
        result = calibrate_cache_read(env, path, &context->limits, &read, &found);
    if (result == STP_OK && !found && !p->only_cached) {
        log_info(env, "calibrating %s: some seconds, once", context->limits.device);
        result = calibrate_measure(env, context, calibrate_scenes, calibrate_scene_count, &read);
    }
    if (result == STP_OK && (found || !p->only_cached)) {
        context->limits.calibration = read;
        if (!found && path)
            calibrate_cache_write(env, path, &context->limits);
    }
    mem_free(path);
    return result;
}
