/* Plans of small scenes that are filled by hand; nothing here knows a device. */
#ifndef TEST_PLANS_H
#define TEST_PLANS_H

#include "../pass/device.h"
#include "plan/offer.h"

/* One log line, kept. */
struct plan_log {
    unsigned lines;
    char last[1024];
};

static inline void plan_keep_line(void *user, enum stp_log_level level, const char *line)
{
    struct plan_log *log = user;
    log->lines++;
    snprintf(log->last, sizeof log->last, "%s", line);
}

/* What a plan is made from: a test changes some of it, then calls plan_of. */
struct inputs {
    struct stp_scene *scene;
    struct stp_camera camera;
    struct stp_render_params params;
    struct stp_limits limits;
};

/* 100 discs of one object without colours, 4 groups at c = 0.85, seen at 64 x 48 by lavapipe. */
static inline struct inputs plain_inputs(void)
{
    struct inputs in = { .scene = scene_make(100, 1, 0.1), .camera = plain_camera(64, 48, 50) };
    for (int i = 0; i < 100; i++)
        scene_add(in.scene, v3(i % 10 * 0.1, i / 10 * 0.1, -3), v3(0, 0.1, 1), 0.1);
    scene_finish(in.scene);
    in.scene->splats.group = calloc(100, 1);
    for (int i = 0; i < 100; i++)
        in.scene->splats.group[i] = (uint8_t)(i % 4);
    in.scene->facts.grouping = (struct stp_grouping){ .groups = 4, .overlap = 0.85 };
    stp_limits_lavapipe(&in.limits);
    return in;
}

static inline void color_inputs(struct inputs *in)
{
    in->scene->splats.color = calloc(in->scene->splats.count, sizeof *in->scene->splats.color);
    in->scene->facts.has_color = true;
    in->scene->facts.color_max = 1;
}

/* One opacity for all, or each its own and some 1. */
static inline void fade_inputs(struct inputs *in, bool mixed)
{
    struct stp_facts *f = &in->scene->facts;
    f->transparent = true;
    f->opacity_min = 0.5f;
    f->uniform_opacity = !mixed;
    f->mixed = mixed;
}

/* As stp_scene_cover leaves it: half of the splats are in two groups. */
static inline void cover_inputs(struct inputs *in)
{
    struct cover_groups *cover = &in->scene->cover;
    in->scene->facts.cover = (struct stp_cover){ .groups = 2,
                                                 .members = 150,
                                                 .duplicates = 0.5,
                                                 .coverage = { 0.98, 0.99 },
                                                 .factor = { 1, 1.01 } };
    cover->groups = 2;
    cover->first[1] = 70;
    cover->first[2] = 150;
    cover->home = calloc(100, 1);
    for (int i = 0; i < 100; i++)
        cover->home[i] = (uint8_t)(i % 2);
}

static inline struct stp_plan *plan_of(const struct inputs *in)
{
    struct stp_plan *plan = NULL;
    assert_int_equal(stp_plan_create(NULL, in->scene, &in->camera, &in->params, &in->limits, &plan),
                     STP_OK);
    return plan;
}

static inline void release_inputs(struct inputs *in)
{
    stp_scene_destroy(&in->scene);
}

/* What plans cannot give: one line says so, and nothing is made. */
struct plan_refusal {
    void (*set)(struct inputs *in);
    const char *word; /* of the line */
};

static inline void expect_refusals(struct inputs (*make)(void), const struct plan_refusal *refused,
                                   size_t count)
{
    for (size_t i = 0; i < count; i++) {
        struct inputs in = make();
        struct plan_log log = { 0 };
        struct stp_env env = { .log = plan_keep_line, .user = &log };
        struct stp_plan *plan = NULL;
        refused[i].set(&in);
        assert_int_equal(stp_plan_create(&env, in.scene, &in.camera, &in.params, &in.limits, &plan),
                         STP_ERROR_ARGUMENT);
        assert_null(plan);
        assert_int_equal(log.lines, 1);
        if (!strstr(log.last, refused[i].word))
            fail_msg("no \"%s\" in: %s", refused[i].word, log.last);
        release_inputs(&in);
    }
}

/* For tests of what auto decides: lavapipe, and no prices but those that are set. */
static inline void price_nothing(struct inputs *in)
{
    in->params.min_splat = -1;
    stp_limits_lavapipe(&in->limits);
    memset(&in->limits.calibration, 0, sizeof in->limits.calibration);
}

/* So many milliseconds a frame. */
static inline void price_frame(struct inputs *in, enum plan_cost kind, double ms)
{
    in->limits.calibration.ns[kind][PLAN_TERM_FRAME] = ms * 1e6;
}

static inline struct stp_choice choose(const struct inputs *in)
{
    struct stp_choice choice;
    assert_int_equal(
        stp_choose(NULL, in->scene, &in->camera, NULL, &in->params, &in->limits, &choice), STP_OK);
    return choice;
}

static inline const struct plan_resource *resource_named(const struct stp_plan *plan,
                                                         const char *name)
{
    for (uint32_t i = 0; i < plan->resource_count; i++)
        if (strcmp(plan->resource[i].name, name) == 0)
            return &plan->resource[i];
    return NULL;
}

static inline const struct plan_pass *pass_named(const struct stp_plan *plan, const char *name)
{
    for (uint32_t i = 0; i < plan->pass_count; i++)
        if (strcmp(plan->pass[i].name, name) == 0)
            return &plan->pass[i];
    return NULL;
}

#endif
