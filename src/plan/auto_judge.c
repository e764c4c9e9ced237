#include "plan/auto.h"

#include <math.h>

#define CELLS_FEW   256
#define CELLS_PART  4096     /* of each further look, until all are seen */
#define LOOK_MOST   67108864 /* fragments of a picture that is looked at whole: some ten seconds */
#define CELLS_DRAWN 16384    /* where each look takes a picture of its own, as pyramid's */
/* An estimate counts as within the bound when it still is this many standard errors higher, and as
 * beyond when it still is that many lower. */
#define CONFIDENCE 3
/* A few cells may miss the few pixels where most of the error is: near the bound the many decide,
 * and while the standard error is more than this share of what is said to be the most. */
#define TAIL 1.3
#define SURE 0.1
/* Fewer cells than this, that have covered pixels, do not tell what the mean over these is. */
#define COVERED 16
/* Groups of the probe's splats alone put more or fewer of them together than the scene's: what is
 * this many times beyond the bound with those is not worth grouping the scene for. */
#define LOCAL_MARGIN 2
/* Of the eye dome (glsl/passes/eye_dome.comp), a share of the light per relative depth: the pixel's
 * own counts 8 log2 e = 11.5, each of eight neighbours' log2 e; all, independent, 12.2 and less. */
#define DOME_SLOPE 16.0

enum stp_result auto_probe(struct choosing *c, unsigned which)
{
    static const struct probe_sample samples[] = { { .cells = CELLS_FEW, .alone = true },
                                                   { .cells = AUTO_CELLS, .alone = true } };
    if (c->probed[which])
        return STP_OK;
    enum stp_result result = probe_make(c->env, c->scene, c->camera, &c->params, &c->survey,
                                        &samples[which], &c->probe[which]);
    c->probed[which] = result == STP_OK;
    return result;
}

enum stp_result auto_local(struct choosing *c, double overlap, const struct auto_local **local)
{
    for (unsigned i = 0; i < c->local_count; i++) {
        *local = &c->local[i];
        if (c->local[i].overlap == overlap)
            return STP_OK;
    }
    enum stp_result result = auto_probe(c, 0);
    if (result != STP_OK)
        return result;
    struct auto_local *made = &c->local[c->local_count];
    struct stp_group_params params = c->group;
    params.overlap = made->overlap = overlap;
    if (c->probe[0].splats == 0)
        made->facts = (struct stp_grouping){ .groups = 1, .overlap = overlap };
    else
        result = probe_group(c->env, &c->probe[0], &params, &made->group, &made->facts);
    if (result == STP_OK)
        c->local_count++;
    *local = made;
    return result;
}

static enum stp_result make_plan(struct choosing *c, const struct auto_candidate *candidate,
                                 const struct stp_grouping *grouping, struct stp_plan **plan)
{
    return plan_try(c->env, c->scene, c->camera, &c->params, c->limits, &candidate->way, grouping,
                    plan);
}

enum stp_result auto_price(struct choosing *c, struct auto_candidate *candidate,
                           const struct stp_grouping *grouping, bool *applies)
{
    struct stp_plan *plan = NULL;
    enum stp_result result = make_plan(c, candidate, grouping, &plan);
    *applies = plan != NULL;
    if (!plan)
        return result;
    candidate->ms = plan_predict(plan, &c->survey, &c->limits->calibration);
    candidate->grouping = *grouping;
    candidate->way.payload = plan->payload;
    stp_plan_destroy(&plan);
    return STP_OK;
}

/* Shading by depth is not the probe's: a pixel's colour then hangs on its neighbours' depths too.
 */
static double dome_error(const struct stp_plan *plan)
{
    if (!plan->facts.eye_dome)
        return 0;
    if (plan->method == STP_METHOD_DEFERRED || plan->method == STP_METHOD_PYRAMID)
        return INFINITY;
    double step = plan->constant[PLAN_PACKED] ? plan->frame.depth_step / 4 : 0;
    double depth = fmax(plan->frame.depth_low, plan->frame.epsilon);
    return DOME_SLOPE * step / (plan->camera.orthographic ? 1 / plan->frame.eye_dome_scale : depth);
}

/* What the spread does not tell where most of the error is in a few cells: as much as of
 * PROBE_UNSEEN cells like the worst that was seen, or as the method's rare ones, over those that
 * are left. */
static double unseen(const struct auto_estimate *e)
{
    const struct probe_tally *t = &e->error.tally;
    if (!(t->n > 0) || t->cells >= t->all_cells)
        return 0;
    double worst = fmax(t->most - t->e / t->cells, e->rare);
    return PROBE_UNSEEN * worst * (1 - t->cells / t->all_cells) / t->n;
}

/* Whether enough of the picture was seen for any of it to hold: all, or as many cells as COVERED
 * with equally many covered pixels would be. */
static bool known(const struct auto_estimate *e)
{
    const struct probe_tally *t = &e->error.tally;
    return t->cells >= t->all_cells || (t->n > 0 && t->n * t->n >= COVERED * t->nn);
}

void auto_conclude(struct auto_estimate *e)
{
    const struct probe_error *error = &e->error;
    e->low = fmax(0, error->mean - CONFIDENCE * error->spread - error->rounding - e->more);
    e->high = error->mean + CONFIDENCE * error->spread + unseen(e) + error->rounding +
              error->flips + e->more;
}

/* What this probe says of the candidate, with the groups of the scene or of the probe alone. */
static enum stp_result estimate(struct choosing *c, const struct auto_candidate *candidate,
                                const struct probe *probe, const struct auto_local *local,
                                struct auto_estimate *e)
{
    struct stp_plan *plan = NULL;
    const uint8_t *group = local ? local->group : c->scene->splats.group;
    *e = (struct auto_estimate){ .low = INFINITY, .high = INFINITY };
    enum stp_result result = make_plan(c, candidate, &candidate->grouping, &plan);
    if (!plan)
        return result;
    result = plan_judge(c->env, probe, plan, candidate->way.overlap > 0 ? group : NULL,
                        local != NULL, &e->error);
    e->more = plan_rounding(plan) + dome_error(plan);
    if (c->params.max_error > 0) /* else what any way would be off by does not matter */
        e->more += plan_light_cube_error(plan, c->scene) + c->levels_error;
    e->rare = plan_offer_of(plan)->rare * fmax(1, plan->facts.color_max);
    stp_plan_destroy(&plan);
    if (result == STP_OK)
        auto_conclude(e);
    return result;
}

/* Only what may be within the bound is worth grouping the scene for. */
static enum stp_result group(struct choosing *c, struct auto_candidate *candidate)
{
    const struct auto_local *local;
    double overlap = candidate->way.overlap;
    struct auto_estimate e;
    bool applies;
    enum stp_result result = auto_local(c, overlap, &local);
    if (result == STP_OK)
        result = auto_probe(c, 0);
    if (result == STP_OK)
        result = estimate(c, candidate, &c->probe[0], local, &e);
    if (result != STP_OK)
        return result;
    if (e.low > LOCAL_MARGIN * c->bound || isinf(e.high)) {
        candidate->stage = AUTO_REFUSED;
        candidate->error = e.high;
        return STP_OK;
    }
    result = groupings_use(c->env, &c->groupings, &c->group, overlap);
    if (result == STP_OK)
        result = auto_price(c, candidate, &c->scene->facts.grouping, &applies);
    candidate->stage = AUTO_GROUPED;
    return result;
}

/* Nothing more needs to be looked at. margin: how far within the bound is far enough. */
static bool settled(const struct choosing *c, const struct auto_estimate *e, double margin)
{
    const struct probe_tally *t = &e->error.tally;
    bool sure = known(e) && e->error.spread <= SURE * e->high;
    bool all = t->n > 0 && t->cells >= t->all_cells;
    return all || (sure && e->high * margin <= c->bound) || e->low > c->bound || isinf(e->high);
}

/* Part after part of the cells, until they settle it or none is left: then nothing is sampled. */
static enum stp_result look_on(struct choosing *c, const struct auto_candidate *candidate,
                               struct auto_estimate *e)
{
    enum stp_result result = STP_OK;
    uint32_t cells = candidate->way.method == STP_METHOD_PYRAMID ? CELLS_DRAWN : CELLS_PART;
    unsigned parts = 1;
    for (unsigned k = 0; result == STP_OK && k < parts && !(k && settled(c, e, 1)); k++) {
        const struct probe_sample sample = { .cells = cells, .part = k };
        struct probe probe;
        struct auto_estimate part;
        result = probe_make(c->env, c->scene, c->camera, &c->params, &c->survey, &sample, &probe);
        if (result != STP_OK)
            return result;
        result = estimate(c, candidate, &probe, NULL, &part);
        parts = probe.parts;
        probe_release(&probe);
        if (result == STP_OK && k) {
            probe_error_join(&part.error, &e->error);
            auto_conclude(&part);
        }
        *e = part;
    }
    return result;
}

/* The few cells decide when they can, else the many. */
static enum stp_result sample(struct choosing *c, const struct auto_candidate *candidate,
                              struct auto_estimate *e, bool *done)
{
    enum stp_result result = STP_OK;
    for (unsigned which = 0; result == STP_OK && which < 2 && !*done; which++) {
        result = auto_probe(c, which);
        if (result == STP_OK)
            result = estimate(c, candidate, &c->probe[which], NULL, e);
        *done = settled(c, e, which ? 1 : TAIL);
    }
    return result;
}

/* What samples leave open waits until nothing else is about as cheap. Of one picture, without a
 * bound, it is not worth more unless nothing is known; and where splats pile up a look would take
 * minutes. */
static enum stp_result decide(struct choosing *c, struct auto_candidate *candidate)
{
    struct auto_estimate e = { .high = INFINITY };
    enum stp_result result = STP_OK;
    bool done = false;
    if (candidate->way.overlap > 0)
        result = groupings_use(c->env, &c->groupings, &c->group, candidate->way.overlap);
    if (result == STP_OK)
        result = candidate->close ? look_on(c, candidate, &e) : sample(c, candidate, &e, &done);
    candidate->error = e.high;
    candidate->close = !done && !candidate->close && (c->params.max_error > 0 || !known(&e)) &&
                       c->survey.fragments <= LOOK_MOST;
    if (!candidate->close)
        candidate->stage = e.high <= c->bound && known(&e) ? AUTO_ACCEPTED : AUTO_REFUSED;
    return result;
}

enum stp_result auto_judge(struct choosing *c, struct auto_candidate *candidate)
{
    return candidate->stage == AUTO_PRICED ? group(c, candidate) : decide(c, candidate);
}
