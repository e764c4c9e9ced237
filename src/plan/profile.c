#include "plan/profile.h"

#include <stdlib.h>
#include <string.h>

#include "plan/offer.h"

/* Nanoseconds. Made by `stipple devices --calibrate --json` on an idle machine. */
static const double built_in[PLAN_COSTS][PLAN_TERMS] = { 0 };

void calibration_built_in(struct stp_calibration *calibration)
{
    *calibration = (struct stp_calibration){ 0 };
    for (unsigned kind = 0; kind < PLAN_COSTS; kind++)
        memcpy(calibration->ns[kind], built_in[kind], sizeof built_in[kind]);
}

cJSON *calibration_to_json(const struct stp_calibration *calibration)
{
    cJSON *root = cJSON_CreateObject();
    bool whole = cJSON_AddBoolToObject(root, "measured", calibration->measured) != NULL;
    for (unsigned kind = 0; whole && plan_cost_name(kind); kind++) {
        cJSON *prices = cJSON_AddObjectToObject(root, plan_cost_name(kind));
        for (unsigned term = 0; term < PLAN_TERMS; term++)
            if (calibration->ns[kind][term] > 0)
                whole = cJSON_AddNumberToObject(prices, plan_term_name(term),
                                                calibration->ns[kind][term]) &&
                        whole;
        whole = whole && prices;
    }
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
