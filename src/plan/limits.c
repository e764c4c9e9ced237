#include "plan/plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "plan/profile.h"

void stp_limits_lavapipe(struct stp_limits *limits)
{
    *limits = (struct stp_limits){
        .device = "llvmpipe",
        .driver = "llvmpipe, Mesa 22.3.6",
        .features = STP_FEATURE_INT64_ATOMICS | STP_FEATURE_VERTEX_LAYER |
                    STP_FEATURE_FLOAT32_BLEND | STP_FEATURE_INT64 | STP_FEATURE_FLOAT64 |
                    STP_FEATURE_STORAGE_FORMATS | STP_FEATURE_SHARED_MEMORY |
                    STP_FEATURE_INDEPENDENT_BLEND | STP_FEATURE_TEXEL_BUFFERS |
                    STP_FEATURE_SUBGROUP_SHUFFLE,
        .heap_bytes = (uint64_t)1 << 31,
        .max_allocation = (uint64_t)1 << 31,
        .max_image_size = 16384,
        .max_image_layers = 2048,
        .max_workgroups = 65535,
        .max_texels = PLAN_MANY_TEXELS,
        .processor = STP_PROCESSOR_CPU,
    };
    calibration_built_in(&limits->calibration);
}

static enum stp_result get_count(const struct json_at *at, const cJSON *root, const char *key,
                                 double most, double *value)
{
    if (!json_has(root, key))
        return json_error(at, key, "is missing; write the profile with stipple devices --json");
    enum stp_result result = json_get_number(at, root, key, value);
    if (result == STP_OK && !(*value >= 1 && *value <= most))
        result = json_error(at, key, "is out of range");
    if (result == STP_OK && *value != (double)(uint64_t)*value)
        result = json_error(at, key, "is not a whole number");
    return result;
}

static enum stp_result get_features(const struct json_at *at, const cJSON *root, unsigned *features)
{
    const cJSON *item, *list = cJSON_GetObjectItemCaseSensitive(root, "features");
    if (!cJSON_IsArray(list))
        return json_error(at, "features", "is not a list of names");
    cJSON_ArrayForEach(item, list)
    {
        unsigned bit = 1;
        const char *name;
        while ((name = stp_feature_name((enum stp_feature)bit)) &&
               !(cJSON_IsString(item) && strcmp(item->valuestring, name) == 0))
            bit *= 2;
        if (!name)
            return json_error(at, "features", "names a feature that is not known");
        *features |= bit;
    }
    return STP_OK;
}

static enum stp_result get_text(const struct json_at *at, const cJSON *root, const char *key,
                                char *text, size_t size)
{
    const char *value = "";
    enum stp_result result = json_get_string(at, root, key, &value);
    if (result == STP_OK)
        snprintf(text, size, "%s", value);
    return result;
}

static enum stp_result read_limits(const struct json_at *at, const cJSON *root,
                                   struct stp_limits *limits)
{
    double heap = 0, allocation = 0, size = 0, layers = 0, groups = 0, texels = 0, processor = 0;
    enum stp_result result = json_check_object(
        at, root,
        "device driver features heap_bytes max_allocation max_image_size max_image_layers "
        "max_workgroups max_texels processor calibration version api_version usable lacks");
    if (result == STP_OK)
        result = get_text(at, root, "device", limits->device, sizeof limits->device);
    if (result == STP_OK)
        result = get_text(at, root, "driver", limits->driver, sizeof limits->driver);
    if (result == STP_OK)
        result = get_features(at, root, &limits->features);
    if (result == STP_OK)
        result = get_count(at, root, "heap_bytes", 0x1p53, &heap);
    if (result == STP_OK)
        result = get_count(at, root, "max_allocation", 0x1p53, &allocation);
    if (result == STP_OK)
        result = get_count(at, root, "max_image_size", 0x1p32 - 1, &size);
    if (result == STP_OK)
        result = get_count(at, root, "max_image_layers", 0x1p32 - 1, &layers);
    if (result == STP_OK)
        result = get_count(at, root, "max_workgroups", 0x1p32 - 1, &groups);
    if (result == STP_OK)
        result = get_count(at, root, "max_texels", 0x1p32 - 1, &texels);
    if (result == STP_OK)
        result = get_count(at, root, "processor", STP_PROCESSOR_GPU, &processor);
    if (result == STP_OK)
        result = calibration_from_json(at, root, &limits->calibration);
    if (result != STP_OK)
        return result;
    limits->heap_bytes = (uint64_t)heap;
    limits->max_allocation = (uint64_t)allocation;
    limits->max_image_size = (uint32_t)size;
    limits->max_image_layers = (uint32_t)layers;
    limits->max_workgroups = (uint32_t)groups;
    limits->max_texels = (uint32_t)texels;
    limits->processor = (uint32_t)processor;
    return STP_OK;
}

enum stp_result stp_limits_load(const struct stp_env *env, const char *path,
                                struct stp_limits *limits)
{
    cJSON *root = NULL;
    struct stp_limits read = { 0 };
    calibration_built_in(&read.calibration);
    enum stp_result result = json_read(env, path, &root);
    if (result != STP_OK)
        return result;
    struct json_at at = json_root(env, path);
    result = read_limits(&at, root, &read);
    cJSON_Delete(root);
    if (result == STP_OK)
        *limits = read;
    return result;
}

static bool add_features(cJSON *root, unsigned features)
{
    cJSON *list = cJSON_AddArrayToObject(root, "features");
    bool whole = list != NULL;
    for (unsigned bit = 1; whole && stp_feature_name((enum stp_feature)bit); bit *= 2)
        if (features & bit)
            whole = cJSON_AddItemToArray(
                list, cJSON_CreateString(stp_feature_name((enum stp_feature)bit)));
    return whole;
}

char *stp_limits_print(const struct stp_limits *limits)
{
    const struct {
        const char *key;
        double value;
    } numbers[] = { { "heap_bytes", (double)limits->heap_bytes },
                    { "max_allocation", (double)limits->max_allocation },
                    { "max_image_size", limits->max_image_size },
                    { "max_image_layers", limits->max_image_layers },
                    { "max_workgroups", limits->max_workgroups },
                    { "max_texels", limits->max_texels },
                    { "processor", limits->processor } };
    cJSON *root = cJSON_CreateObject(), *calibration = calibration_to_json(&limits->calibration);
    bool whole = root && calibration && cJSON_AddStringToObject(root, "device", limits->device) &&
                 cJSON_AddStringToObject(root, "driver", limits->driver) &&
                 add_features(root, limits->features);
    for (unsigned i = 0; whole && i < sizeof numbers / sizeof *numbers; i++)
        whole = cJSON_AddNumberToObject(root, numbers[i].key, numbers[i].value) != NULL;
    whole = whole && cJSON_AddItemToObject(root, "calibration", calibration);
    if (!whole)
        cJSON_Delete(calibration);
    char *text = whole ? cJSON_Print(root) : NULL;
    cJSON_Delete(root);
    return text;
}
