#include "plan/profile.h"

#include <stdlib.h>
#include <string.h>

#include "plan/offer.h"

/* Nanoseconds, of Mesa's software device on two cores, fitted to scanned models beside the
 * calibration's own scenes (`tools/bench_auto.py prices`): `exact`, `two-pass` and `deferred` by
 * the rasteriser to medians of three sweeps of 18, the rest to ten. Calibration keeps their
 * proportions where its frames do not tell terms apart. */
static const double built_in[PLAN_COSTS][PLAN_TERMS] = {
    [PLAN_COST_EXACT_PACKED] = { [PLAN_TERM_BOX] = 4.05,
                                 [PLAN_TERM_DRAWN] = 68.8,
                                 [PLAN_TERM_FRAGMENTS] = 1.5,
                                 [PLAN_TERM_LARGE] = 7.68e+03,
                                 [PLAN_TERM_LARGE_BOX] = 4.95,
                                 [PLAN_TERM_OVERFLOW] = 3.14e+03,
                                 [PLAN_TERM_PIXELS] = 1.49,
                                 [PLAN_TERM_TOUCHED] = 31.6 },
    [PLAN_COST_EXACT_PACKED_IDS] = { [PLAN_TERM_BOX] = 3.55,
                                     [PLAN_TERM_DEEP] = 14,
                                     [PLAN_TERM_DRAWN] = 51.7,
                                     [PLAN_TERM_LARGE] = 6.74e+03,
                                     [PLAN_TERM_LARGE_BOX] = 5.19,
                                     [PLAN_TERM_OVERFLOW] = 3.01e+03,
                                     [PLAN_TERM_PIXELS] = 1.99,
                                     [PLAN_TERM_SPLATS] = 22.3,
                                     [PLAN_TERM_TOUCHED] = 60.1 },
    [PLAN_COST_EXACT_ID] = { [PLAN_TERM_BOX] = 4.41,
                             [PLAN_TERM_DRAWN] = 108,
                             [PLAN_TERM_FRAGMENTS] = 12.6,
                             [PLAN_TERM_LARGE] = 2.57e+03,
                             [PLAN_TERM_LARGE_BOX] = 6.64,
                             [PLAN_TERM_OVERFLOW] = 2e+03,
                             [PLAN_TERM_PIXELS] = 1.56,
                             [PLAN_TERM_TOUCHED] = 44.6 },
    [PLAN_COST_EXACT_ID_COLOR] = { [PLAN_TERM_BOX] = 6.35,
                                   [PLAN_TERM_DEEP] = 11.7,
                                   [PLAN_TERM_DRAWN] = 63.2,
                                   [PLAN_TERM_FRAGMENTS] = 8.61,
                                   [PLAN_TERM_LARGE_BOX] = 9.88,
                                   [PLAN_TERM_OVERFLOW] = 1.78e+03,
                                   [PLAN_TERM_PIXELS] = 1.83,
                                   [PLAN_TERM_SPLATS] = 26,
                                   [PLAN_TERM_TOUCHED] = 48 },
    [PLAN_COST_TWO_PASS] = { [PLAN_TERM_BOX] = 6.11,
                             [PLAN_TERM_DRAWN] = 176,
                             [PLAN_TERM_FRAGMENTS] = 3.8,
                             [PLAN_TERM_LARGE_BOX] = 1.2,
                             [PLAN_TERM_PIXELS] = 10.7,
                             [PLAN_TERM_TOUCHED] = 44.2 },
    [PLAN_COST_TWO_PASS_COLOR] = { [PLAN_TERM_BOX] = 9.56,
                                   [PLAN_TERM_DRAWN] = 202,
                                   [PLAN_TERM_FRAGMENTS] = 4.04,
                                   [PLAN_TERM_LARGE_BOX] = 2.72,
                                   [PLAN_TERM_PIXELS] = 16.8,
                                   [PLAN_TERM_SPLATS] = 9.1,
                                   [PLAN_TERM_TOUCHED] = 52.5 },
    [PLAN_COST_TWO_PASS_RASTER] = { [PLAN_TERM_BOX] = 1.73,
                                    [PLAN_TERM_DRAWN] = 426,
                                    [PLAN_TERM_FRAGMENTS] = 8.17,
                                    [PLAN_TERM_FRAME] = 1.66e+06,
                                    [PLAN_TERM_PIXELS] = 8.78,
                                    [PLAN_TERM_SPLATS] = 145,
                                    [PLAN_TERM_TOUCHED] = 19.7 },
    [PLAN_COST_TWO_PASS_RASTER_COLOR] = { [PLAN_TERM_BOX] = 2.68,
                                          [PLAN_TERM_DRAWN] = 300,
                                          [PLAN_TERM_FRAGMENTS] = 12.9,
                                          [PLAN_TERM_FRAME] = 7.38e+05,
                                          [PLAN_TERM_PIXELS] = 11.8,
                                          [PLAN_TERM_SPLATS] = 201,
                                          [PLAN_TERM_TOUCHED] = 21.9 },
    [PLAN_COST_DEFERRED_PACKED] = { [PLAN_TERM_BOX] = 2.85,
                                    [PLAN_TERM_DEEP] = 0.305,
                                    [PLAN_TERM_DRAWN] = 21.7,
                                    [PLAN_TERM_FRAGMENTS] = 1.31,
                                    [PLAN_TERM_LARGE] = 760,
                                    [PLAN_TERM_LARGE_BOX] = 3.92,
                                    [PLAN_TERM_OVERFLOW] = 4.31,
                                    [PLAN_TERM_PIXELS] = 1.27,
                                    [PLAN_TERM_SPLATS] = 14.3,
                                    [PLAN_TERM_TOUCHED] = 15.1 },
    [PLAN_COST_DEFERRED_ID] = { [PLAN_TERM_BOX] = 2.14,
                                [PLAN_TERM_DEEP] = 0.0391,
                                [PLAN_TERM_DRAWN] = 69.6,
                                [PLAN_TERM_FRAGMENTS] = 1.78,
                                [PLAN_TERM_LARGE_BOX] = 3.53,
                                [PLAN_TERM_OVERFLOW] = 12.4,
                                [PLAN_TERM_PIXELS] = 1.23,
                                [PLAN_TERM_SPLATS] = 11.5,
                                [PLAN_TERM_TOUCHED] = 30.5 },
    [PLAN_COST_DEFERRED_EXACT] = { [PLAN_TERM_BOX] = 0.496,
                                   [PLAN_TERM_DRAWN] = 14.3,
                                   [PLAN_TERM_FRAGMENTS] = 12,
                                   [PLAN_TERM_LARGE_BOX] = 4,
                                   [PLAN_TERM_OVERFLOW] = 9.82,
                                   [PLAN_TERM_PIXELS] = 2.08,
                                   [PLAN_TERM_SPLATS] = 43.6,
                                   [PLAN_TERM_TOUCHED] = 24.8 },
    [PLAN_COST_DEFERRED_RASTER] = { [PLAN_TERM_BOX] = 0.877,
                                    [PLAN_TERM_DEEP] = 1.81,
                                    [PLAN_TERM_DRAWN] = 213,
                                    [PLAN_TERM_FRAGMENTS] = 3.99,
                                    [PLAN_TERM_FRAME] = 3.34e+05,
                                    [PLAN_TERM_LARGE_BOX] = 0.229,
                                    [PLAN_TERM_OVERFLOW] = 0.0282,
                                    [PLAN_TERM_PIXELS] = 4.06,
                                    [PLAN_TERM_SPLATS] = 88.2,
                                    [PLAN_TERM_TOUCHED] = 19.4 },
    [PLAN_COST_DEFERRED_RASTER_ID] = { [PLAN_TERM_DEEP] = 1.57,
                                       [PLAN_TERM_DRAWN] = 268,
                                       [PLAN_TERM_FRAGMENTS] = 4.47,
                                       [PLAN_TERM_FRAME] = 2.93e+05,
                                       [PLAN_TERM_OVERFLOW] = 7.4,
                                       [PLAN_TERM_PIXELS] = 4.92,
                                       [PLAN_TERM_SPLATS] = 79.4,
                                       [PLAN_TERM_TOUCHED] = 34.8 },
    [PLAN_COST_PYRAMID] = { [PLAN_TERM_DRAWN] = 22.7,
                            [PLAN_TERM_FRAME] = 7.15e+05,
                            [PLAN_TERM_LARGE_BOX] = 2.53,
                            [PLAN_TERM_PIXELS] = 8.17,
                            [PLAN_TERM_SPLATS] = 7.61,
                            [PLAN_TERM_TOUCHED] = 82.8 },
    [PLAN_COST_PYRAMID_COLOR] = { [PLAN_TERM_DRAWN] = 26,
                                  [PLAN_TERM_FRAME] = 2.55e+05,
                                  [PLAN_TERM_LARGE_BOX] = 2.85,
                                  [PLAN_TERM_PIXELS] = 11.8,
                                  [PLAN_TERM_SPLATS] = 48.9,
                                  [PLAN_TERM_TOUCHED] = 94.4 },
    [PLAN_COST_LAYERS_PACKED] = { [PLAN_TERM_BOX] = 6.67,
                                  [PLAN_TERM_DEEP] = 20.4,
                                  [PLAN_TERM_DRAWN] = 10.9,
                                  [PLAN_TERM_LARGE_BOX] = 7.79,
                                  [PLAN_TERM_OVERFLOW] = 56.1,
                                  [PLAN_TERM_PIXELS] = 4.2,
                                  [PLAN_TERM_SPLATS] = 13.1,
                                  [PLAN_TERM_TOUCHED] = 3.19 },
    [PLAN_COST_LAYERS_PACKED_IDS] = { [PLAN_TERM_BOX] = 3.42,
                                      [PLAN_TERM_DEEP] = 2.97,
                                      [PLAN_TERM_DRAWN] = 4.84,
                                      [PLAN_TERM_FRAGMENTS] = 2.98,
                                      [PLAN_TERM_FRAME] = 3.04e+06,
                                      [PLAN_TERM_LARGE] = 6.8e+03,
                                      [PLAN_TERM_LARGE_BOX] = 0.186,
                                      [PLAN_TERM_OVERFLOW] = 64,
                                      [PLAN_TERM_SPLATS] = 4.87,
                                      [PLAN_TERM_TOUCHED] = 60.1 },
    [PLAN_COST_LAYERS_ID] = { [PLAN_TERM_BOX] = 5.81,
                              [PLAN_TERM_DEEP] = 42,
                              [PLAN_TERM_DRAWN] = 18.1,
                              [PLAN_TERM_FRAGMENTS] = 23.4,
                              [PLAN_TERM_LARGE_BOX] = 0.243,
                              [PLAN_TERM_OVERFLOW] = 47.8,
                              [PLAN_TERM_PIXELS] = 4.05 },
    [PLAN_COST_PEEL] = { [PLAN_TERM_BOX] = 2.13,
                         [PLAN_TERM_FRAGMENTS] = 13.8,
                         [PLAN_TERM_FRAME] = 3.81e+05,
                         [PLAN_TERM_LARGE_BOX] = 5.2,
                         [PLAN_TERM_PIXELS] = 10.9,
                         [PLAN_TERM_SPLATS] = 69.3,
                         [PLAN_TERM_TOUCHED] = 40.7 },
    [PLAN_COST_PEEL_COLOR] = { [PLAN_TERM_BOX] = 1.26,
                               [PLAN_TERM_FRAGMENTS] = 20.7,
                               [PLAN_TERM_FRAME] = 3.87e+05,
                               [PLAN_TERM_LARGE_BOX] = 2.99,
                               [PLAN_TERM_PIXELS] = 14.1,
                               [PLAN_TERM_SPLATS] = 86.9,
                               [PLAN_TERM_TOUCHED] = 59.7 },
    [PLAN_COST_PEEL_RASTER] = { [PLAN_TERM_BOX] = 7.72,
                                [PLAN_TERM_DRAWN] = 641,
                                [PLAN_TERM_FRAGMENTS] = 1.62,
                                [PLAN_TERM_FRAME] = 6.85e+06,
                                [PLAN_TERM_LARGE_BOX] = 1.69,
                                [PLAN_TERM_SPLATS] = 158,
                                [PLAN_TERM_TOUCHED] = 2.43 },
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
