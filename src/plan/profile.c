#include "plan/profile.h"

#include <stdlib.h>
#include <string.h>

#include "plan/offer.h"

/* Nanoseconds, of Mesa's software device on two cores: `tools/bench_auto.py prices`, over ten
 * scanned models beside the calibration's own scenes; the rasteriser's later than the others, at
 * the level that two-pass by compute had in both fits. Calibration keeps their proportions where
 * its frames do not tell terms apart. */
static const double built_in[PLAN_COSTS][PLAN_TERMS] = {
    [PLAN_COST_EXACT_PACKED] = { [PLAN_TERM_SPLATS] = 15.5,
                                 [PLAN_TERM_BOX] = 8.48,
                                 [PLAN_TERM_LARGE] = 4920,
                                 [PLAN_TERM_LARGE_BOX] = 9.71,
                                 [PLAN_TERM_PIXELS] = 0.588,
                                 [PLAN_TERM_TOUCHED] = 29.4,
                                 [PLAN_TERM_OVERFLOW] = 2690 },
    [PLAN_COST_EXACT_PACKED_IDS] = { [PLAN_TERM_SPLATS] = 22,
                                     [PLAN_TERM_BOX] = 9.85,
                                     [PLAN_TERM_LARGE_BOX] = 18.9,
                                     [PLAN_TERM_PIXELS] = 1.37,
                                     [PLAN_TERM_TOUCHED] = 42.1,
                                     [PLAN_TERM_DEEP] = 10.2,
                                     [PLAN_TERM_OVERFLOW] = 1560 },
    [PLAN_COST_EXACT_ID] = { [PLAN_TERM_SPLATS] = 57.7,
                             [PLAN_TERM_BOX] = 14.8,
                             [PLAN_TERM_LARGE] = 7300,
                             [PLAN_TERM_LARGE_BOX] = 19.1,
                             [PLAN_TERM_PIXELS] = 5.07,
                             [PLAN_TERM_TOUCHED] = 100,
                             [PLAN_TERM_DEEP] = 7.04 },
    [PLAN_COST_TWO_PASS] = { [PLAN_TERM_SPLATS] = 73.1,
                             [PLAN_TERM_DRAWN] = 70.1,
                             [PLAN_TERM_BOX] = 9.16,
                             [PLAN_TERM_LARGE] = 10400,
                             [PLAN_TERM_LARGE_BOX] = 26.6,
                             [PLAN_TERM_PIXELS] = 13,
                             [PLAN_TERM_TOUCHED] = 53.6 },
    [PLAN_COST_TWO_PASS_COLOR] = { [PLAN_TERM_SPLATS] = 89.4,
                                   [PLAN_TERM_DRAWN] = 42.2,
                                   [PLAN_TERM_BOX] = 11.8,
                                   [PLAN_TERM_LARGE] = 11600,
                                   [PLAN_TERM_LARGE_BOX] = 38.1,
                                   [PLAN_TERM_PIXELS] = 16.4,
                                   [PLAN_TERM_TOUCHED] = 63 },
    [PLAN_COST_TWO_PASS_RASTER] = { [PLAN_TERM_BOX] = 3.67,
                                    [PLAN_TERM_DRAWN] = 303,
                                    [PLAN_TERM_FRAGMENTS] = 11.3,
                                    [PLAN_TERM_FRAME] = 1.77e+06,
                                    [PLAN_TERM_PIXELS] = 28.4,
                                    [PLAN_TERM_SPLATS] = 235 },
    [PLAN_COST_DEFERRED_PACKED] = { [PLAN_TERM_SPLATS] = 17.1,
                                    [PLAN_TERM_DRAWN] = 20,
                                    [PLAN_TERM_BOX] = 3.5,
                                    [PLAN_TERM_LARGE] = 6270,
                                    [PLAN_TERM_LARGE_BOX] = 2.95,
                                    [PLAN_TERM_TOUCHED] = 9.61,
                                    [PLAN_TERM_DEEP] = 0.655,
                                    [PLAN_TERM_OVERFLOW] = 6.8 },
    [PLAN_COST_DEFERRED_ID] = { [PLAN_TERM_SPLATS] = 20.5,
                                [PLAN_TERM_BOX] = 2.92,
                                [PLAN_TERM_LARGE] = 9000,
                                [PLAN_TERM_LARGE_BOX] = 2.35,
                                [PLAN_TERM_PIXELS] = 0.401,
                                [PLAN_TERM_TOUCHED] = 2.04,
                                [PLAN_TERM_DEEP] = 0.364,
                                [PLAN_TERM_OVERFLOW] = 27.8 },
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
    [PLAN_COST_DEFERRED_RASTER_ID] = { [PLAN_TERM_BOX] = 1.52,
                                       [PLAN_TERM_DEEP] = 20.6,
                                       [PLAN_TERM_DRAWN] = 401,
                                       [PLAN_TERM_FRAGMENTS] = 5.52,
                                       [PLAN_TERM_LARGE] = 5.94e+03,
                                       [PLAN_TERM_SPLATS] = 69.6,
                                       [PLAN_TERM_TOUCHED] = 0.654 },
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
