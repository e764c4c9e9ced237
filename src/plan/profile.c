#include "plan/profile.h"

#include <stdlib.h>
#include <string.h>

#include "plan/offer.h"

/* Nanoseconds: `stipple devices --calibrate --json` on an idle machine, by `tools/bench_auto.py
 * prices`. */
static const double built_in[PLAN_COSTS][PLAN_TERMS] = {
    [PLAN_COST_EXACT_PACKED] = { [PLAN_TERM_DRAWN] = 225,
                                 [PLAN_TERM_LARGE] = 5.36e+04,
                                 [PLAN_TERM_LARGE_BOX] = 14.4,
                                 [PLAN_TERM_FRAGMENTS] = 6.77,
                                 [PLAN_TERM_PIXELS] = 2.68,
                                 [PLAN_TERM_TOUCHED] = 24.1,
                                 [PLAN_TERM_DEEP] = 4.93,
                                 [PLAN_TERM_OVERFLOW] = 7.6e+03 },
    [PLAN_COST_EXACT_PACKED_IDS] = { [PLAN_TERM_SPLATS] = 44.6,
                                     [PLAN_TERM_LARGE] = 9.46e+04,
                                     [PLAN_TERM_LARGE_BOX] = 4.18,
                                     [PLAN_TERM_PIXELS] = 5.05,
                                     [PLAN_TERM_TOUCHED] = 103,
                                     [PLAN_TERM_DEEP] = 29.7,
                                     [PLAN_TERM_OVERFLOW] = 3.22e+03 },
    [PLAN_COST_EXACT_ID] = { [PLAN_TERM_FRAME] = 1.37e+06,
                             [PLAN_TERM_DRAWN] = 230,
                             [PLAN_TERM_LARGE] = 6.43e+04,
                             [PLAN_TERM_LARGE_BOX] = 18.3,
                             [PLAN_TERM_FRAGMENTS] = 16.7,
                             [PLAN_TERM_PIXELS] = 15.4,
                             [PLAN_TERM_TOUCHED] = 114,
                             [PLAN_TERM_OVERFLOW] = 7.27e+03 },
    [PLAN_COST_TWO_PASS] = { [PLAN_TERM_DRAWN] = 243,
                             [PLAN_TERM_LARGE] = 3.67e+04,
                             [PLAN_TERM_LARGE_BOX] = 9.53,
                             [PLAN_TERM_FRAGMENTS] = 34.7,
                             [PLAN_TERM_PIXELS] = 49 },
    [PLAN_COST_TWO_PASS_COLOR] = { [PLAN_TERM_DRAWN] = 204,
                                   [PLAN_TERM_LARGE_BOX] = 39,
                                   [PLAN_TERM_FRAGMENTS] = 38.6,
                                   [PLAN_TERM_PIXELS] = 34.6,
                                   [PLAN_TERM_TOUCHED] = 71 },
    [PLAN_COST_TWO_PASS_RASTER] = { [PLAN_TERM_FRAME] = 1.18e+07,
                                    [PLAN_TERM_SPLATS] = 90.9,
                                    [PLAN_TERM_DRAWN] = 1.18e+03,
                                    [PLAN_TERM_BOX] = 14.7,
                                    [PLAN_TERM_LARGE] = 5.36e+04,
                                    [PLAN_TERM_PIXELS] = 19.3,
                                    [PLAN_TERM_TOUCHED] = 6.44 },
    [PLAN_COST_DEFERRED_PACKED] = { [PLAN_TERM_DRAWN] = 96.8,
                                    [PLAN_TERM_BOX] = 1.24,
                                    [PLAN_TERM_LARGE] = 2.87e+03,
                                    [PLAN_TERM_FRAGMENTS] = 4.27,
                                    [PLAN_TERM_TOUCHED] = 14.5,
                                    [PLAN_TERM_DEEP] = 1.08,
                                    [PLAN_TERM_OVERFLOW] = 7.34 },
    [PLAN_COST_DEFERRED_ID] = { [PLAN_TERM_DRAWN] = 160,
                                [PLAN_TERM_BOX] = 0.612,
                                [PLAN_TERM_LARGE] = 5.07e+03,
                                [PLAN_TERM_FRAGMENTS] = 4.19,
                                [PLAN_TERM_TOUCHED] = 0.276,
                                [PLAN_TERM_DEEP] = 0.173,
                                [PLAN_TERM_OVERFLOW] = 36.6 },
    [PLAN_COST_DEFERRED_EXACT] = { [PLAN_TERM_DRAWN] = 480,
                                   [PLAN_TERM_LARGE_BOX] = 24.7,
                                   [PLAN_TERM_FRAGMENTS] = 9.63,
                                   [PLAN_TERM_TOUCHED] = 17,
                                   [PLAN_TERM_DEEP] = 3.82,
                                   [PLAN_TERM_OVERFLOW] = 17.1 },
    [PLAN_COST_DEFERRED_RASTER] = { [PLAN_TERM_FRAME] = 7.29e+05,
                                    [PLAN_TERM_DRAWN] = 938,
                                    [PLAN_TERM_LARGE] = 2.21e+04,
                                    [PLAN_TERM_LARGE_BOX] = 0.929,
                                    [PLAN_TERM_FRAGMENTS] = 20.5,
                                    [PLAN_TERM_PIXELS] = 27.1,
                                    [PLAN_TERM_TOUCHED] = 27.7 },
    [PLAN_COST_DEFERRED_RASTER_ID] = { [PLAN_TERM_FRAME] = 2.04e+06,
                                       [PLAN_TERM_DRAWN] = 1.45e+03,
                                       [PLAN_TERM_LARGE_BOX] = 7.6,
                                       [PLAN_TERM_FRAGMENTS] = 11.5,
                                       [PLAN_TERM_PIXELS] = 29.1,
                                       [PLAN_TERM_DEEP] = 11.2 },
    [PLAN_COST_PYRAMID] = { [PLAN_TERM_SPLATS] = 113,
                            [PLAN_TERM_LARGE_BOX] = 11.2,
                            [PLAN_TERM_PIXELS] = 23.7,
                            [PLAN_TERM_TOUCHED] = 86 },
    [PLAN_COST_PYRAMID_COLOR] = { [PLAN_TERM_DRAWN] = 83.5,
                                  [PLAN_TERM_LARGE_BOX] = 3.83,
                                  [PLAN_TERM_PIXELS] = 34.4,
                                  [PLAN_TERM_TOUCHED] = 129 },
    [PLAN_COST_LAYERS_PACKED] = { [PLAN_TERM_DRAWN] = 23.5,
                                  [PLAN_TERM_LARGE_BOX] = 1.27,
                                  [PLAN_TERM_FRAGMENTS] = 10.1,
                                  [PLAN_TERM_PIXELS] = 4.88,
                                  [PLAN_TERM_TOUCHED] = 3.19,
                                  [PLAN_TERM_DEEP] = 23.7,
                                  [PLAN_TERM_OVERFLOW] = 80.6 },
    [PLAN_COST_LAYERS_PACKED_IDS] = { [PLAN_TERM_BOX] = 19.7,
                                      [PLAN_TERM_LARGE] = 5.54e+04,
                                      [PLAN_TERM_FRAGMENTS] = 19.3,
                                      [PLAN_TERM_PIXELS] = 2.55,
                                      [PLAN_TERM_DEEP] = 29.3,
                                      [PLAN_TERM_OVERFLOW] = 79.3 },
    [PLAN_COST_LAYERS_ID] = { [PLAN_TERM_SPLATS] = 540,
                              [PLAN_TERM_BOX] = 19.7,
                              [PLAN_TERM_LARGE] = 1.79e+04,
                              [PLAN_TERM_LARGE_BOX] = 26.3,
                              [PLAN_TERM_FRAGMENTS] = 0.158,
                              [PLAN_TERM_PIXELS] = 9.39,
                              [PLAN_TERM_TOUCHED] = 144,
                              [PLAN_TERM_DEEP] = 58.4,
                              [PLAN_TERM_OVERFLOW] = 71.5 },
    [PLAN_COST_PEEL] = { [PLAN_TERM_SPLATS] = 46.2,
                         [PLAN_TERM_DRAWN] = 7.67,
                         [PLAN_TERM_BOX] = 19.2,
                         [PLAN_TERM_LARGE_BOX] = 17.9,
                         [PLAN_TERM_PIXELS] = 24.2,
                         [PLAN_TERM_TOUCHED] = 31.8 },
    [PLAN_COST_PEEL_COLOR] = { [PLAN_TERM_DRAWN] = 63.4,
                               [PLAN_TERM_FRAGMENTS] = 33.8,
                               [PLAN_TERM_PIXELS] = 22.4,
                               [PLAN_TERM_TOUCHED] = 69.2 },
    [PLAN_COST_PEEL_RASTER] = { [PLAN_TERM_FRAME] = 1.78e+07,
                                [PLAN_TERM_DRAWN] = 1.62e+03,
                                [PLAN_TERM_BOX] = 16.9,
                                [PLAN_TERM_LARGE_BOX] = 2.8,
                                [PLAN_TERM_FRAGMENTS] = 16.2,
                                [PLAN_TERM_TOUCHED] = 17 },
};

void calibration_built_in(struct stp_calibration *calibration)
{
    *calibration = (struct stp_calibration){ 0 };
    for (unsigned kind = 0; kind < PLAN_COSTS; kind++)
        memcpy(calibration->ns[kind], built_in[kind], sizeof built_in[kind]);
}

/* Every bit of them: a price that was read decides as one that was measured. */
static bool add_prices(cJSON *root, const char *name, const double *ns)
{
    cJSON *prices = cJSON_AddObjectToObject(root, name);
    char text[JSON_NUMBER_SIZE];
    bool whole = prices != NULL;
    for (unsigned term = 0; whole && term < PLAN_TERMS; term++)
        if (ns[term] > 0)
            whole = cJSON_AddRawToObject(prices, plan_term_name(term),
                                         json_number_text(ns[term], text)) != NULL;
    return whole;
}

cJSON *calibration_to_json(const struct stp_calibration *calibration)
{
    cJSON *root = cJSON_CreateObject();
    bool whole = root && cJSON_AddBoolToObject(root, "measured", calibration->measured);
    for (unsigned kind = 0; whole && plan_cost_name(kind); kind++)
        whole = add_prices(root, plan_cost_name(kind), calibration->ns[kind]);
    if (whole)
        return root;
    cJSON_Delete(root);
    return NULL;
}

static enum stp_result read_prices(const struct json_at *at, const cJSON *prices, double *ns)
{
    for (unsigned term = 0; term < PLAN_TERMS; term++) {
        enum stp_result result = json_get_number(at, prices, plan_term_name(term), &ns[term]);
        if (result == STP_OK && !(ns[term] >= 0))
            result = json_error(at, plan_term_name(term), "is negative");
        if (result != STP_OK)
            return result;
    }
    return STP_OK;
}

enum stp_result calibration_from_json(const struct json_at *at, const cJSON *root,
                                      struct stp_calibration *calibration)
{
    const cJSON *object = cJSON_GetObjectItemCaseSensitive(root, "calibration");
    struct stp_calibration read = { 0 };
    if (!object)
        return STP_OK;
    if (!cJSON_IsObject(object))
        return json_error(at, "calibration", "is not an object");
    struct json_at below = json_below(at, "calibration", -1);
    enum stp_result result = json_get_bool(&below, object, "measured", &read.measured);
    for (unsigned kind = 0; result == STP_OK && plan_cost_name(kind); kind++) {
        const char *name = plan_cost_name(kind);
        const cJSON *prices = cJSON_GetObjectItemCaseSensitive(object, name);
        struct json_at at_kind = json_below(&below, name, -1);
        if (prices && !cJSON_IsObject(prices))
            result = json_error(&below, name, "is not an object");
        else if (prices)
            result = read_prices(&at_kind, prices, read.ns[kind]);
    }
    if (result == STP_OK)
        *calibration = read;
    return result;
}
