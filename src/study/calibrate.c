/* stp_calibrate: every synthetic scene under every kind of plan, timed, and prices fitted to it. */
#include "study/calibrate.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "plan/fit.h"
#include "plan/profile.h"
#include "record/record.h"
#include "report/report.h"
#include "study/study.h"
#include "study/yardstick.h"

#define SURE_ROUNDS 2     /* in which all is timed: the yardstick does not see every spell */
#define ROUNDS      3     /* at most: what has met a slow spell is timed again in the next */
#define PATIENCE    40000 /* milliseconds, of all waiting for the end of spells */
#define STEADY      1.2   /* times the yardstick's least: no slow spell */
#define LEAST_TIMED 3     /* frames of a visit */
#define MOST_TIMED  8
#define ENOUGH      12 /* milliseconds of them */
#define LINE_SIZE   512
#define MOST_ROWS   64 /* of a kind */
#define MOST_HELD   128
#define CELLS       64 /* of a probe that counts layers */

struct rows {
    bool plain; /* colours make no difference to this kind */
    /* One a scene. 0 ns: none. */
    double amount[MOST_ROWS * PLAN_TERMS], ns[MOST_ROWS];
    double pace[MOST_ROWS]; /* the yardstick beside it, when that was least */
};

/* A scene, ready for all rounds. */
struct bed {
    unsigned index;
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
    struct yardstick yardstick;
    double least;  /* of its readings */
    double waited; /* milliseconds */
    unsigned round;
    /* Compiling takes longer than the frames: what one frame compiled is held for others. */
    unsigned held_count;
    struct record_pipelines *held[MOST_HELD];
    char line[LINE_SIZE];
};

static void hold(struct calibrating *c, struct record_pipelines *pipelines)
{
    for (unsigned i = 0; i < c->held_count; i++)
        if (c->held[i] == pipelines)
            return;
    if (c->held_count < MOST_HELD) {
        gpu_use_kept(c->context, &pipelines->kept);
        c->held[c->held_count++] = pipelines;
    }
}

/* The median of a few warm frames, as a report has it: compute's frames spread more than the
 * rasteriser's, whose least is nearer to what they usually take. The first compiles, or touches new
 * memory, which takes as long as a price or two of a large picture's pixels. */
static enum stp_result time_plan(struct calibrating *c, const struct bed *bed,
                                 const struct stp_plan *plan, double *ms)
{
    struct record_frame frame;
    double each[MOST_TIMED], unused, spent = 0;
    unsigned n = 0;
    enum stp_result result = record_frame_create(&c->quiet, c->context, plan, &frame);
    if (result != STP_OK)
        return result;
    hold(c, frame.pipelines);
    result = record_upload(&c->quiet, &frame, bed->scene);
    if (result == STP_OK)
        result = record_run(&c->quiet, &frame, bed->scene, NULL, &unused, &unused);
    for (; result == STP_OK && n < MOST_TIMED && (n < LEAST_TIMED || spent < ENOUGH); n++) {
        result = record_run(&c->quiet, &frame, bed->scene, NULL, &each[n], &unused);
        spent += each[n];
    }
    if (result == STP_OK)
        *ms = report_times(each, n).median;
    record_frame_destroy(&frame);
    return result;
}

static enum stp_result read_yardstick(struct calibrating *c)
{
    enum stp_result result = yardstick_read(&c->quiet, &c->yardstick);
    c->least = fmin(c->least, c->yardstick.ms);
    return result;
}

/* Until a slow spell has ended, or patience. */
static enum stp_result sit_out(struct calibrating *c)
{
    enum stp_result result = STP_OK;
    while (result == STP_OK && c->yardstick.ms > STEADY * c->least && c->waited < PATIENCE) {
        result = read_yardstick(c);
        c->waited += YARDSTICK_FRAMES * c->yardstick.ms;
    }
    return result;
}

static enum stp_result add_row(struct calibrating *c, const struct bed *bed,
                               const struct stp_plan *plan, bool seen[PLAN_COSTS])
{
    double amount[PLAN_TERMS] = { 0 }, ms = 0;
    enum plan_cost kind = plan_offer_of(plan)->cost(plan, &bed->survey, amount);
    struct rows *rows = &c->rows[kind];
    unsigned i = bed->index;
    bool again = rows->ns[i] > 0;
    if (seen[kind] || (bed->colored && rows->plain))
        return STP_OK;
    seen[kind] = true;
    rows->plain = rows->plain || !bed->colored;
    if (again && c->round >= SURE_ROUNDS && rows->pace[i] <= STEADY * c->least)
        return STP_OK;
    enum stp_result result = sit_out(c);
    double pace = c->yardstick.ms;
    if (result == STP_OK)
        result = time_plan(c, bed, plan, &ms);
    if (result == STP_OK)
        result = read_yardstick(c);
    if (result != STP_OK)
        return result;
    pace = fmax(pace, c->yardstick.ms);
    rows->ns[i] = again ? fmin(rows->ns[i], ms * 1e6) : ms * 1e6;
    rows->pace[i] = again ? fmin(rows->pace[i], pace) : pace;
    memcpy(&rows->amount[i * PLAN_TERMS], amount, sizeof amount);
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
    enum stp_result result = read_yardstick(c);
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
                                unsigned index)
{
    struct calibrate_scene grown = *what;
    struct bed *bed = &c->bed[index];
    if (c->context->limits.processor ==
        STP_PROCESSOR_GPU) { /* whose frames would be too short to tell apart */
        grown.splats *= 4;
        grown.size *= 2;
    }
    *bed = (struct bed){ .index = index, .colored = what->color };
    bed->params =
        (struct stp_render_params){ .min_splat = -1,
                                    .cull = what->opacity > 0 ? STP_CULL_NONE : STP_CULL_BACK };
    enum stp_result result = calibrate_scene_make(&c->quiet, &grown, &bed->scene, &bed->camera);
    if (result == STP_OK)
        result = survey_make(&c->quiet, bed->scene, &bed->camera, &bed->params, &bed->survey);
    if (result == STP_OK && what->opacity > 0)
        result = count_layers(c, bed);
    if (result == STP_OK && index == 0)
        result = yardstick_make(&c->quiet, c->context, bed->scene, &bed->camera, &c->yardstick);
    return result;
}

static void release(struct calibrating *c, unsigned count)
{
    yardstick_release(&c->yardstick);
    for (unsigned i = 0; c->bed && i < count; i++) {
        survey_release(&c->bed[i].survey);
        stp_scene_destroy(&c->bed[i].scene);
    }
    for (unsigned i = 0; i < c->held_count; i++)
        gpu_leave_kept(c->context, &c->held[i]->kept);
    mem_free(c->bed);
    mem_free(c->rows);
}

/* Leaves out the scenes that this kind has not drawn; returns how many are left. */
static unsigned close_up(struct rows *rows)
{
    unsigned n = 0;
    for (unsigned i = 0; i < MOST_ROWS; i++) {
        if (rows->ns[i] == 0)
            continue;
        memmove(&rows->amount[n * PLAN_TERMS], &rows->amount[i * PLAN_TERMS],
                PLAN_TERMS * sizeof *rows->amount);
        rows->ns[n++] = rows->ns[i];
    }
    return n;
}

static void fit(const struct calibrating *c, struct stp_calibration *calibration)
{
    struct stp_calibration known;
    calibration_built_in(&known);
    *calibration = (struct stp_calibration){ .measured = true };
    for (unsigned kind = 0; kind < PLAN_COSTS; kind++) {
        struct rows *rows = &c->rows[kind];
        unsigned count = close_up(rows);
        if (count == 0)
            continue;
        fit_prices(count, PLAN_TERMS, rows->amount, rows->ns, known.ns[kind],
                   calibration->ns[kind]);
        for (unsigned i = 0; i < count; i++)
            study_log_amounts(c->env, kind, &rows->amount[i * PLAN_TERMS], rows->ns[i] * 1e-6);
    }
}

static enum stp_result run_round(struct calibrating *c, const struct calibrate_scene *scenes,
                                 unsigned count)
{
    enum stp_result result = STP_OK;
    for (unsigned i = 0; result == STP_OK && i < count; i++) {
        log_progress(c->env, "calibrate", (double)(c->round * count + i) / (ROUNDS * count));
        if (c->round == 0)
            result = make_bed(c, &scenes[i], i);
        if (result == STP_OK)
            result = run_bed(c, &c->bed[i]);
    }
    return result;
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
    struct calibrating c = { .env = env, .context = context, .least = INFINITY };
    enum stp_result result = STP_OK;
    assert(count <= MOST_ROWS);
    c.quiet =
        (struct stp_env){ .threads = env ? env->threads : 0, .log = keep_line, .user = c.line };
    c.rows = mem_zalloc(PLAN_COSTS, sizeof *c.rows);
    c.bed = mem_zalloc(count, sizeof *c.bed);
    if (!c.rows || !c.bed) {
        release(&c, 0);
        return log_no_memory(env, PLAN_COSTS * sizeof *c.rows, "the calibration");
    }
    context->env = &c.quiet;
    for (; result == STP_OK && c.round < ROUNDS; c.round++)
        result = run_round(&c, scenes, count);
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
        log_info(env, "calibrating %s: about a minute, once", context->limits.device);
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
