#include "plan/profile.h"

#include <stdlib.h>
#include <string.h>

#include "plan/offer.h"

/* Nanoseconds, of Mesa's software device on two cores: `tools/bench_auto.py prices`, over ten
 * scanned models beside the calibration's own scenes; where methods have become faster the rows
 * were fitted anew, leaning on what was there (`--lean 0.1`). Calibration keeps their proportions
 * where its frames do not tell terms apart. */
static const double built_in[PLAN_COSTS][PLAN_TERMS] = {
    [PLAN_COST_EXACT_PACKED] = { [PLAN_TERM_SPLATS] = 15.5,
                                 [PLAN_TERM_BOX] = 8.48,
                                 [PLAN_TERM_LARGE] = 4920,
                                 [PLAN_TERM_LARGE_BOX] = 9.71,
                                 [PLAN_TERM_PIXELS] = 0.588,
                                 [PLAN_TERM_TOUCHED] = 29.4,
                                 [PLAN_TERM_OVERFLOW] = 2690 },
    [PLAN_COST_EXACT_PACKED_IDS] = { [PLAN_TERM_BOX] = 10.9,
                                     [PLAN_TERM_DEEP] = 2.87,
                                     [PLAN_TERM_LARGE_BOX] = 20.9,
                                     [PLAN_TERM_OVERFLOW] = 4.62e+03,
                                     [PLAN_TERM_PIXELS] = 0.204,
                                     [PLAN_TERM_SPLATS] = 4.96,
                                     [PLAN_TERM_TOUCHED] = 122 },
    [PLAN_COST_EXACT_ID] = { [PLAN_TERM_BOX] = 9.95,
                             [PLAN_TERM_DEEP] = 13,
                             [PLAN_TERM_FRAGMENTS] = 2.25,
                             [PLAN_TERM_FRAME] = 4.28e+05,
                             [PLAN_TERM_LARGE_BOX] = 11,
                             [PLAN_TERM_OVERFLOW] = 3.17e+03,
                             [PLAN_TERM_PIXELS] = 0.54,
                             [PLAN_TERM_SPLATS] = 23.6,
                             [PLAN_TERM_TOUCHED] = 95.1 },
    [PLAN_COST_EXACT_ID_COLOR] = { [PLAN_TERM_BOX] = 8.7,
                                   [PLAN_TERM_DEEP] = 8.32,
                                   [PLAN_TERM_DRAWN] = 46.6,
                                   [PLAN_TERM_FRAGMENTS] = 3.4,
                                   [PLAN_TERM_LARGE] = 3.86e+03,
                                   [PLAN_TERM_LARGE_BOX] = 10.6,
                                   [PLAN_TERM_OVERFLOW] = 2.08e+03,
                                   [PLAN_TERM_PIXELS] = 0.494,
                                   [PLAN_TERM_SPLATS] = 20.2,
                                   [PLAN_TERM_TOUCHED] = 55 },
    [PLAN_COST_TWO_PASS] = { [PLAN_TERM_BOX] = 8.9,
                             [PLAN_TERM_DRAWN] = 24.7,
                             [PLAN_TERM_FRAME] = 1.08e+06,
                             [PLAN_TERM_LARGE_BOX] = 4.07,
                             [PLAN_TERM_PIXELS] = 29.3,
                             [PLAN_TERM_SPLATS] = 79.7,
                             [PLAN_TERM_TOUCHED] = 37.2 },
    [PLAN_COST_TWO_PASS_COLOR] = { [PLAN_TERM_BOX] = 13.9,
                                   [PLAN_TERM_DRAWN] = 214,
                                   [PLAN_TERM_FRAGMENTS] = 0.21,
                                   [PLAN_TERM_LARGE_BOX] = 13.6,
                                   [PLAN_TERM_PIXELS] = 13.2,
                                   [PLAN_TERM_SPLATS] = 50.2,
                                   [PLAN_TERM_TOUCHED] = 84.6 },
    [PLAN_COST_TWO_PASS_RASTER] = { [PLAN_TERM_BOX] = 1.68,
                                    [PLAN_TERM_DRAWN] = 284,
                                    [PLAN_TERM_FRAGMENTS] = 9.18,
                                    [PLAN_TERM_FRAME] = 4.6e+06,
                                    [PLAN_TERM_PIXELS] = 31.6,
                                    [PLAN_TERM_SPLATS] = 231,
                                    [PLAN_TERM_TOUCHED] = 10.4 },
    [PLAN_COST_TWO_PASS_RASTER_COLOR] = { [PLAN_TERM_BOX] = 3.65,
                                          [PLAN_TERM_DRAWN] = 284,
                                          [PLAN_TERM_FRAGMENTS] = 8.74,
                                          [PLAN_TERM_FRAME] = 1.82e+06,
                                          [PLAN_TERM_PIXELS] = 37.8,
                                          [PLAN_TERM_SPLATS] = 305,
                                          [PLAN_TERM_TOUCHED] = 10.4 },
    [PLAN_COST_DEFERRED_PACKED] = { [PLAN_TERM_SPLATS] = 17.1,
                                    [PLAN_TERM_DRAWN] = 20,
                                    [PLAN_TERM_BOX] = 3.5,
                                    [PLAN_TERM_LARGE] = 6270,
                                    [PLAN_TERM_LARGE_BOX] = 2.95,
                                    [PLAN_TERM_TOUCHED] = 9.61,
                                    [PLAN_TERM_DEEP] = 0.655,
                                    [PLAN_TERM_OVERFLOW] = 6.8 },
    [PLAN_COST_DEFERRED_ID] = { [PLAN_TERM_BOX] = 2.28,
                                [PLAN_TERM_DRAWN] = 53.7,
                                [PLAN_TERM_FRAGMENTS] = 1.61,
                                [PLAN_TERM_FRAME] = 8.98e+05,
                                [PLAN_TERM_LARGE_BOX] = 4.13,
                                [PLAN_TERM_OVERFLOW] = 16,
                                [PLAN_TERM_SPLATS] = 2.51,
                                [PLAN_TERM_TOUCHED] = 47.4 },
    [PLAN_COST_DEFERRED_EXACT] = { [PLAN_TERM_FRAME] = 139000,
                                   [PLAN_TERM_SPLATS] = 49.4,
                                   [PLAN_TERM_BOX] = 0.128,
                                   [PLAN_TERM_LARGE_BOX] = 4.01,
                                   [PLAN_TERM_FRAGMENTS] = 11.7,
                                   [PLAN_TERM_PIXELS] = 0.709,
                                   [PLAN_TERM_TOUCHED] = 16.2,
                                   [PLAN_TERM_OVERFLOW] = 17.8 },
    [PLAN_COST_DEFERRED_RASTER] = { [PLAN_TERM_BOX] = 1.72,
                                    [PLAN_TERM_DEEP] = 6.06,
                                    [PLAN_TERM_FRAGMENTS] = 1.04,
                                    [PLAN_TERM_FRAME] = 6.48e+05,
                                    [PLAN_TERM_PIXELS] = 11.7,
                                    [PLAN_TERM_SPLATS] = 186,
                                    [PLAN_TERM_TOUCHED] = 10.8 },
    [PLAN_COST_DEFERRED_RASTER_ID] = { [PLAN_TERM_BOX] = 1.88,
                                       [PLAN_TERM_DEEP] = 5.42,
                                       [PLAN_TERM_DRAWN] = 485,
                                       [PLAN_TERM_FRAGMENTS] = 6,
                                       [PLAN_TERM_FRAME] = 1.14e+05,
                                       [PLAN_TERM_LARGE_BOX] = 0.738,
                                       [PLAN_TERM_PIXELS] = 23.7,
                                       [PLAN_TERM_SPLATS] = 57.6,
                                       [PLAN_TERM_TOUCHED] = 39.6 },
    [PLAN_COST_PYRAMID] = { [PLAN_TERM_SPLATS] = 62,
                            [PLAN_TERM_LARGE_BOX] = 4.21,
                            [PLAN_TERM_PIXELS] = 8.1,
                            [PLAN_TERM_TOUCHED] = 114 },
    [PLAN_COST_PYRAMID_COLOR] = { [PLAN_TERM_SPLATS] = 98.7,
                                  [PLAN_TERM_LARGE_BOX] = 3.89,
                                  [PLAN_TERM_PIXELS] = 12.2,
                                  [PLAN_TERM_TOUCHED] = 112 },
    [PLAN_COST_LAYERS_PACKED] = { [PLAN_TERM_SPLATS] = 3.04,
                                  [PLAN_TERM_BOX] = 8.69,
                                  [PLAN_TERM_LARGE] = 3320,
                                  [PLAN_TERM_LARGE_BOX] = 13.6,
                                  [PLAN_TERM_PIXELS] = 4.71,
                                  [PLAN_TERM_DEEP] = 25.9,
                                  [PLAN_TERM_OVERFLOW] = 41.7 },
    [PLAN_COST_LAYERS_PACKED_IDS] = { [PLAN_TERM_FRAME] = 9440000,
                                      [PLAN_TERM_SPLATS] = 9.14,
                                      [PLAN_TERM_DRAWN] = 9.86,
                                      [PLAN_TERM_BOX] = 6.4,
                                      [PLAN_TERM_LARGE] = 32800,
                                      [PLAN_TERM_FRAGMENTS] = 5.15,
                                      [PLAN_TERM_TOUCHED] = 126,
                                      [PLAN_TERM_DEEP] = 1.36,
                                      [PLAN_TERM_OVERFLOW] = 52.3 },
    [PLAN_COST_LAYERS_ID] = { [PLAN_TERM_DRAWN] = 43.4,
                              [PLAN_TERM_BOX] = 3.76,
                              [PLAN_TERM_FRAGMENTS] = 32.5,
                              [PLAN_TERM_PIXELS] = 12.5,
                              [PLAN_TERM_DEEP] = 97.4,
                              [PLAN_TERM_OVERFLOW] = 28.4 },
    [PLAN_COST_PEEL] = { [PLAN_TERM_SPLATS] = 110,
                         [PLAN_TERM_LARGE] = 13200,
                         [PLAN_TERM_LARGE_BOX] = 12,
                         [PLAN_TERM_FRAGMENTS] = 15.2,
                         [PLAN_TERM_PIXELS] = 17.8,
                         [PLAN_TERM_TOUCHED] = 65.4 },
    [PLAN_COST_PEEL_COLOR] = { [PLAN_TERM_SPLATS] = 136,
                               [PLAN_TERM_LARGE] = 13900,
                               [PLAN_TERM_LARGE_BOX] = 4.5,
                               [PLAN_TERM_FRAGMENTS] = 21.3,
                               [PLAN_TERM_PIXELS] = 13.2,
                               [PLAN_TERM_TOUCHED] = 89.9 },
    [PLAN_COST_PEEL_RASTER] = { [PLAN_TERM_BOX] = 9.71,
                                [PLAN_TERM_DRAWN] = 465,
                                [PLAN_TERM_FRAME] = 6.77e+06,
                                [PLAN_TERM_PIXELS] = 8.86 },
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
