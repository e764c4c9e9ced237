/* What the ways to composite layers one by one tell auto: exact, which keeps every fragment, and
 * peeling to a few depths. Fast and nearest make no offer (docs/auto.md says why). */
#include "plan/offer.h"

static unsigned exact_candidates(struct plan_candidate candidate[PLAN_MAX_OFFERED])
{
    candidate[0] = (struct plan_candidate){ .method = STP_METHOD_EXACT,
                                            .path = STP_PATH_COMPUTE,
                                            .payload = STP_PAYLOAD_PACKED,
                                            .voronoi = STP_VORONOI_OFF,
                                            .transparency = STP_TRANSPARENCY_EXACT };
    candidate[1] = candidate[0];
    candidate[1].payload = STP_PAYLOAD_ID;
    return 2;
}

/* Fragments of the blocks that have more than slots. */
static double overflowed(const struct survey *survey)
{
    double sum = 0, most = (double)STP_SLOTS * SURVEY_BLOCK * SURVEY_BLOCK;
    for (size_t b = 0; b < (size_t)survey->across * survey->down; b++)
        sum += (double)survey->mass[b] > most ? (double)survey->mass[b] : 0;
    return sum;
}

/* A sweep over the slots a layer; what overflowed is drawn again, once a layer. */
static enum plan_cost exact_cost(const struct stp_plan *plan, const struct survey *survey,
                                 double amount[PLAN_TERMS])
{
    plan_common_amounts(plan, survey, amount);
    amount[PLAN_TERM_DEEP] = survey->layers * survey->touched;
    amount[PLAN_TERM_OVERFLOW] = survey->layers * overflowed(survey);
    if (!plan->constant[PLAN_PACKED])
        return PLAN_COST_LAYERS_ID;
    return plan->constant[PLAN_KEY_IDS] ? PLAN_COST_LAYERS_PACKED_IDS : PLAN_COST_LAYERS_PACKED;
}

/* What matters is how depths are rounded: it decides which layer takes a fragment. */
static void exact_keep(const struct stp_plan *plan, struct probe_fragment *fragment, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (plan->constant[PLAN_PACKED])
            plan_quantise_packed(plan, &fragment[i]);
        else
            fragment[i].depth = (double)(float)fragment[i].depth;
}

const struct plan_offer plan_layers_offer = { .method = STP_METHOD_EXACT,
                                              .transparency = STP_TRANSPARENCY_EXACT,
                                              .candidates = exact_candidates,
                                              .cost = exact_cost,
                                              .keep = exact_keep };

/* Two layers first: calibration times the first of a kind. */
static unsigned peel_candidates(struct plan_candidate candidate[PLAN_MAX_OFFERED])
{
    static const unsigned layers[] = { 2, 1, 4, 8, 16 };
    static const enum stp_path paths[] = { STP_PATH_COMPUTE, STP_PATH_RASTER };
    unsigned n = 0;
    for (unsigned i = 0; i < sizeof layers / sizeof *layers; i++)
        for (unsigned p = 0; p < 2; p++)
            candidate[n++] = (struct plan_candidate){ .method = STP_METHOD_TWO_PASS,
                                                      .path = paths[p],
                                                      .voronoi = STP_VORONOI_OFF,
                                                      .transparency = STP_TRANSPARENCY_PEEL,
                                                      .layers = layers[i] };
    return n;
}

/* Everything once a layer; where there is something opaque, its own pass, of half a layer's. */
static enum plan_cost peel_cost(const struct stp_plan *plan, const struct survey *survey,
                                double amount[PLAN_TERMS])
{
    double times = plan_repeats(plan) + (plan->constant[PLAN_MIXED] ? 0.5 : 0);
    plan_common_amounts(plan, survey, amount);
    for (int t = 0; t < PLAN_TERMS; t++)
        amount[t] *= times;
    if (plan->path == STP_PATH_RASTER)
        return PLAN_COST_PEEL_RASTER;
    return plan->constant[PLAN_HAS_COLOR] ? PLAN_COST_PEEL_COLOR : PLAN_COST_PEEL;
}

static void peel_keep(const struct stp_plan *, struct probe_fragment *fragment, size_t count)
{
    for (size_t i = 0; i < count; i++)
        fragment[i].depth = (double)(float)fragment[i].depth;
}

const struct plan_offer plan_peel_offer = { .method = STP_METHOD_TWO_PASS,
                                            .transparency = STP_TRANSPARENCY_PEEL,
                                            .candidates = peel_candidates,
                                            .cost = peel_cost,
                                            .keep = peel_keep };
