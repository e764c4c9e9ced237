/* A profile of a device, as `stipple devices --json` prints it, to limits. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/json.h"
#include "plan/plan.h"

static enum stp_result read_text(const struct json_at *at, const cJSON *object, const char *key,
                                 char text[256])
{
    const char *value = NULL;
    enum stp_result result = json_get_string(at, object, key, &value);
    if (result == STP_OK && !value)
        return json_error(at, key, "is missing");
    if (result == STP_OK)
        snprintf(text, 256, "%s", value);
    return result;
}

/* A whole number from 1 to `most`. */
static enum stp_result read_whole(const struct json_at *at, const cJSON *object, const char *key,
                                  double most, double *value)
{
    *value = NAN;
    enum stp_result result = json_get_number(at, object, key, value);
    if (result != STP_OK)
        return result;
    if (isnan(*value))
        return json_error(at, key, "is missing");
    if (*value < 1 || *value > most || *value != floor(*value))
        return json_error(at, key, "is not a whole number in range");
    return STP_OK;
}

static unsigned feature_of(const char *name)
{
    for (unsigned bit = 1; stp_feature_name((enum stp_feature)bit); bit *= 2)
        if (strcmp(stp_feature_name((enum stp_feature)bit), name) == 0)
            return bit;
    return 0;
}

static enum stp_result read_features(const struct json_at *at, const cJSON *object,
                                     unsigned *features)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, "features");
    if (!cJSON_IsArray(list))
        return json_error(at, "features", "is not an array of names");
    for (const cJSON *item = list->child; item; item = item->next) {
        unsigned bit = cJSON_IsString(item) ? feature_of(item->valuestring) : 0;
        if (!bit)
            return json_error(at, "features", "holds what is no feature's name");
        *features |= bit;
    }
    return STP_OK;
}

static enum stp_result read_numbers(const struct json_at *at, const cJSON *object,
                                    struct stp_limits *limits)
{
    static const char *const keys[] = { "heap_bytes",       "max_allocation", "max_image_size",
                                        "max_image_layers", "max_workgroups", "processor" };
    static const double most[] = { 0x1p53, 0x1p53, UINT32_MAX, UINT32_MAX, UINT32_MAX, 2 };
    double value[6];
    for (int i = 0; i < 6; i++) {
        enum stp_result result = read_whole(at, object, keys[i], most[i], &value[i]);
        if (result != STP_OK)
            return result;
    }
    limits->heap_bytes = (uint64_t)value[0];
    limits->max_allocation = (uint64_t)value[1];
    limits->max_image_size = (uint32_t)value[2];
    limits->max_image_layers = (uint32_t)value[3];
    limits->max_workgroups = (uint32_t)value[4];
    limits->processor = (uint32_t)value[5];
    return STP_OK;
}

static enum stp_result read_profile(const struct json_at *at, const cJSON *root,
                                    struct stp_limits *limits)
{
    enum stp_result result = json_check_object(
        at, root,
        "device driver features heap_bytes max_allocation max_image_size max_image_layers "
        "max_workgroups processor api_version usable lacks");
    if (result == STP_OK)
        result = read_text(at, root, "device", limits->device);
    if (result == STP_OK)
        result = read_text(at, root, "driver", limits->driver);
    if (result == STP_OK)
        result = read_features(at, root, &limits->features);
    if (result == STP_OK)
        result = read_numbers(at, root, limits);
    return result;
}

enum stp_result stp_limits_load(const struct stp_env *env, const char *path,
                                struct stp_limits *limits)
{
    cJSON *root = NULL;
    struct stp_limits read = { 0 };
    enum stp_result result = json_read(env, path, &root);
    if (result != STP_OK)
        return result;
    struct json_at at = json_root(env, path);
    result = read_profile(&at, root, &read);
    if (result == STP_OK)
        *limits = read;
    cJSON_Delete(root);
    return result;
}
