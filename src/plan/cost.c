/* From amounts and prices to milliseconds. */
#include "plan/offer.h"

#include <math.h>

const struct plan_offer *const plan_offers[] = { &plan_exact_offer,    &plan_twopass_offer,
                                                 &plan_deferred_offer, &plan_pyramid_offer,
                                                 &plan_layers_offer,   &plan_peel_offer };
const unsigned plan_offer_count = sizeof plan_offers / sizeof *plan_offers;

const char *plan_cost_name(enum plan_cost cost)
{
    static const char *const names[PLAN_COSTS] = {
        "exact packed",       "exact packed ids",
        "exact id",           "exact id color",
        "two-pass compute",   "two-pass compute color",
        "two-pass raster",    "two-pass raster color",
        "deferred packed",    "deferred id",
        "deferred exact",     "deferred raster",
        "deferred raster id", "pyramid",
        "pyramid color",      "layers packed",
        "layers packed ids",  "layers id",
        "peel compute",       "peel compute color",
        "peel raster",
    };
    return cost < PLAN_COSTS ? names[cost] : NULL;
}

const char *plan_term_name(enum plan_term term)
{
    static const char *const names[PLAN_TERMS] = { "frame",   "splats",    "drawn",     "box",
                                                   "large",   "large box", "fragments", "pixels",
                                                   "touched", "deep",      "overflow" };
    return term < PLAN_TERMS ? names[term] : NULL;
}

const struct plan_offer *plan_offer_of(const struct stp_plan *plan)
{
    for (unsigned i = 0; i < plan_offer_count; i++)
        if (plan_offers[i]->method == plan->method &&
            plan_offers[i]->transparency == plan->transparency)
            return plan_offers[i];
    return NULL;
}

void plan_common_amounts(const struct stp_plan *plan, const struct survey *survey,
                         double amount[PLAN_TERMS])
{
    amount[PLAN_TERM_FRAME] = plan->tile_count;
    amount[PLAN_TERM_SPLATS] = survey->splats * plan->tile_count;
    amount[PLAN_TERM_DRAWN] = survey->drawn;
    amount[PLAN_TERM_BOX] = survey->small_box;
    amount[PLAN_TERM_LARGE] = survey->large;
    amount[PLAN_TERM_LARGE_BOX] = survey->large_box;
    amount[PLAN_TERM_FRAGMENTS] = survey->fragments;
    amount[PLAN_TERM_PIXELS] = survey->pixels;
    amount[PLAN_TERM_TOUCHED] = survey->touched;
}

double plan_predict(const struct stp_plan *plan, const struct survey *survey,
                    const struct stp_calibration *calibration)
{
    const struct plan_offer *offer = plan_offer_of(plan);
    double amount[PLAN_TERMS] = { 0 }, ns = 0;
    if (!offer)
        return INFINITY;
    const double *price = calibration->ns[offer->cost(plan, survey, amount)];
    for (int t = 0; t < PLAN_TERMS; t++)
        ns += amount[t] * price[t];
    return ns > 0 ? ns * 1e-6 * plan_samples(plan) : INFINITY;
}

/* A colour is a few float operations more, whose roundings mostly cancel. Centres in float move
 * outlines by a thousandth of a pixel: one pixel on the wrong side is worth 1e-6 of a picture of
 * 10^6. The pyramid's texels are halves, where the probe has floats: a quarter of their last bit.
 */
double plan_rounding(const struct stp_plan *plan)
{
    double shade = 0x1p-24, halves = plan_offer_of(plan)->draw ? 0x1p-13 : 0;
    double centres = plan->constant[PLAN_FLOAT64] ? 0 : 2e-5;
    return (shade + halves + centres) * fmax(1, plan->facts.color_max);
}
