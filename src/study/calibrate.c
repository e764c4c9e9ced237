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

#define ROUNDS     2 /* far enough apart that what disturbs one may spare the other */
#define TIMED      3
#define MOST_TIMED 10
#define ENOUGH     60 /* milliseconds */
#define LINE_SIZE  512
#define MOST_ROWS  64 /* of a kind */

struct rows {
    unsigned count, at; /* at: the next of this round */
    bool plain;         /* colours make no difference to this kind */
    double amount[MOST_ROWS * PLAN_TERMS], ns[MOST_ROWS];
};

struct calibrating {
    const struct stp_env *env;
    struct stp_env quiet;
    struct stp_context *context;
    struct rows *rows; /* one a kind */
    struct stp_scene *scene;
    bool colored;
    struct stp_camera camera;
    struct survey survey;
    char line[LINE_SIZE];
};

/* The least of a few frames: what disturbs a frame only lengthens it. */
static enum stp_result time_plan(struct calibrating *c, const struct stp_plan *plan, double *ms)
{
    struct record_frame frame;
    double each, unused, spent = 0;
    enum stp_result result = record_frame_create(&c->quiet, c->context, plan, &frame);
    if (result != STP_OK)
        return result;
    result = record_upload(&c->quiet, &frame, c->scene);
    if (result == STP_OK)
        result = record_run(&c->quiet, &frame, c->scene, NULL, &each, &unused); /* compiles */
    *ms = INFINITY;
    for (unsigned i = 0; result == STP_OK && i < MOST_TIMED && (i < TIMED || spent < ENOUGH); i++) {
        result = record_run(&c->quiet, &frame, c->scene, NULL, &each, &unused);
        *ms = fmin(*ms, each);
        spent += each;
    }
    record_frame_destroy(&frame);
    return result;
}

static enum stp_result add_row(struct calibrating *c, const struct stp_plan *plan,
                               bool seen[PLAN_COSTS])
{
    double amount[PLAN_TERMS] = { 0 }, ms = 0;
    enum plan_cost kind = plan_offer_of(plan->method)->cost(plan, &c->survey, amount);
    struct rows *rows = &c->rows[kind];
    if (seen[kind] || rows->at == MOST_ROWS || (c->colored && rows->plain))
        return STP_OK;
    seen[kind] = true;
    rows->plain = rows->plain || !c->colored;
    enum stp_result result = time_plan(c, plan, &ms);
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

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

/* Each kind once a scene, in the scene's own grouping. */
static enum stp_result run_candidates(struct calibrating *c, const struct stp_render_params *params)
{
    const struct stp_env silent = { .threads = c->quiet.threads, .log = swallow };
    bool seen[PLAN_COSTS] = { false };
    enum stp_result result = STP_OK;
    for (unsigned o = 0; o < plan_offer_count; o++) {
        struct plan_candidate way[PLAN_MAX_OFFERED];
        unsigned count = plan_offers[o]->candidates(way);
        for (unsigned i = 0; result == STP_OK && i < count; i++) {
            struct stp_plan *plan = NULL;
            struct stp_render_params p = *params;
            p.method = way[i].method;
            p.path = way[i].path;
            p.payload = way[i].payload;
            p.voronoi = way[i].overlap > 0 ? way[i].voronoi : p.voronoi;
            /* What does not apply has no price. */
            result = stp_plan_create(&silent, c->scene, &c->camera, &p, &c->context->limits, &plan);
            if (result == STP_OK)
                result = add_row(c, plan, seen);
            else if (result == STP_ERROR_FEATURE || result == STP_ERROR_ARGUMENT)
                result = STP_OK;
            stp_plan_destroy(&plan);
        }
    }
    return result;
}

static enum stp_result run_scene(struct calibrating *c, const struct calibrate_scene *what)
{
    /* One sphere shows its front; several, all they have. */
    struct stp_render_params params = { .min_splat = -1,
                                        .cull = what->shells > 1 ? STP_CULL_NONE : STP_CULL_BACK };
    c->colored = what->color;
    enum stp_result result = calibrate_scene_make(&c->quiet, what, &c->scene, &c->camera);
    if (result != STP_OK)
        return result;
    result = survey_make(&c->quiet, c->scene, &c->camera, &params, &c->survey);
    if (result == STP_OK)
        result = run_candidates(c, &params);
    survey_release(&c->survey);
    stp_scene_destroy(&c->scene);
    return result;
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
        for (unsigned i = 0; i < rows->count; i++) {
            double ns = 0;
            for (int t = 0; t < PLAN_TERMS; t++)
                ns += rows->amount[i * PLAN_TERMS + t] * calibration->ns[kind][t];
            log_info(c->env, "calibration: %s, row %u: measured %.3g ms, fitted %.3g",
                     plan_cost_name(kind), i, rows->ns[i] * 1e-6, ns * 1e-6);
        }
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
    if (!c.rows)
        return log_no_memory(env, PLAN_COSTS * sizeof *c.rows, "the calibration");
    context->env = &c.quiet;
    for (unsigned i = 0; result == STP_OK && i < ROUNDS * count; i++) {
        log_progress(env, "calibrate", (double)i / (ROUNDS * count));
        for (unsigned kind = 0; i % count == 0 && kind < PLAN_COSTS; kind++)
            c.rows[kind].at = 0;
        result = run_scene(&c, &scenes[i % count]);
    }
    context->env = NULL;
    if (result == STP_OK)
        fit(&c, calibration);
    else
        log_error(env, result, "calibrating %s: %s", context->limits.device,
                  c.line[0] ? c.line : stp_result_text(result));
    mem_free(c.rows);
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
