#include "plan/profile.h"

#include <stdlib.h>
#include <string.h>

#include "plan/offer.h"

/* Nanoseconds. Made by `stipple devices --calibrate --json` on an idle machine. */
static const double built_in[PLAN_COSTS][PLAN_TERMS] = {
    [PLAN_COST_EXACT_PACKED] = { [PLAN_TERM_SPLATS] = 21.9,
                                 [PLAN_TERM_BOX] = 4.24,
                                 [PLAN_TERM_LARGE] = 1.09e+03,
                                 [PLAN_TERM_FRAGMENTS] = 6.15,
                                 [PLAN_TERM_TOUCHED] = 43.6,
                                 [PLAN_TERM_DEEP] = 3.55 },
    [PLAN_COST_EXACT_PACKED_IDS] = { [PLAN_TERM_DRAWN] = 119,
                                     [PLAN_TERM_BOX] = 0.829,
                                     [PLAN_TERM_FRAGMENTS] = 0.137,
                                     [PLAN_TERM_TOUCHED] = 115,
                                     [PLAN_TERM_DEEP] = 21 },
    [PLAN_COST_EXACT_ID] = { [PLAN_TERM_FRAME] = 5020000,
                             [PLAN_TERM_SPLATS] = 9.49,
                             [PLAN_TERM_DRAWN] = 52.8,
                             [PLAN_TERM_BOX] = 2.82,
                             [PLAN_TERM_FRAGMENTS] = 8.44,
                             [PLAN_TERM_TOUCHED] = 143,
                             [PLAN_TERM_DEEP] = 1.34 },
    [PLAN_COST_TWO_PASS] = { [PLAN_TERM_FRAME] = 7710000,
                             [PLAN_TERM_SPLATS] = 87.3,
                             [PLAN_TERM_LARGE_BOX] = 6.54,
                             [PLAN_TERM_PIXELS] = 8.25,
                             [PLAN_TERM_TOUCHED] = 71.7 },
    [PLAN_COST_TWO_PASS_COLOR] = { [PLAN_TERM_FRAME] = 3920000,
                                   [PLAN_TERM_DRAWN] = 485,
                                   [PLAN_TERM_LARGE_BOX] = 6.65,
                                   [PLAN_TERM_FRAGMENTS] = 6.18,
                                   [PLAN_TERM_PIXELS] = 9.85,
                                   [PLAN_TERM_TOUCHED] = 81 },
    [PLAN_COST_TWO_PASS_RASTER] = { [PLAN_TERM_FRAME] = 15360000,
                                    [PLAN_TERM_DRAWN] = 1.44e+03,
                                    [PLAN_TERM_BOX] = 5.55,
                                    [PLAN_TERM_FRAGMENTS] = 6.24,
                                    [PLAN_TERM_PIXELS] = 2.51,
                                    [PLAN_TERM_TOUCHED] = 40.7 },
    [PLAN_COST_DEFERRED_PACKED] = { [PLAN_TERM_DRAWN] = 105,
                                    [PLAN_TERM_LARGE] = 974,
                                    [PLAN_TERM_LARGE_BOX] = 0.456,
                                    [PLAN_TERM_FRAGMENTS] = 1.76,
                                    [PLAN_TERM_PIXELS] = 0.0931,
                                    [PLAN_TERM_TOUCHED] = 28.2,
                                    [PLAN_TERM_OVERFLOW] = 5.1 },
    [PLAN_COST_DEFERRED_ID] = { [PLAN_TERM_DRAWN] = 83.5,
                                [PLAN_TERM_BOX] = 0.995,
                                [PLAN_TERM_FRAGMENTS] = 1.71,
                                [PLAN_TERM_PIXELS] = 3.33,
                                [PLAN_TERM_TOUCHED] = 15.9,
                                [PLAN_TERM_OVERFLOW] = 21.4 },
    [PLAN_COST_DEFERRED_EXACT] = { [PLAN_TERM_FRAME] = 1020000,
                                   [PLAN_TERM_DRAWN] = 211,
                                   [PLAN_TERM_LARGE_BOX] = 0.261,
                                   [PLAN_TERM_FRAGMENTS] = 3.73,
                                   [PLAN_TERM_TOUCHED] = 22.2,
                                   [PLAN_TERM_OVERFLOW] = 24.1 },
    [PLAN_COST_DEFERRED_RASTER] = { [PLAN_TERM_FRAME] = 1040000,
                                    [PLAN_TERM_DRAWN] = 1.11e+03,
                                    [PLAN_TERM_BOX] = 0.804,
                                    [PLAN_TERM_TOUCHED] = 42.5,
                                    [PLAN_TERM_DEEP] = 6.94 },
    [PLAN_COST_DEFERRED_RASTER_ID] = { [PLAN_TERM_DRAWN] = 927,
                                       [PLAN_TERM_BOX] = 7.71,
                                       [PLAN_TERM_FRAGMENTS] = 4.3,
                                       [PLAN_TERM_TOUCHED] = 29.6,
                                       [PLAN_TERM_DEEP] = 19.2 },
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
