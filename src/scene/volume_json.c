/* "volume" of a scene .json: a file, what it is when it has no header, and how it looks. */
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene_json.h"
#include "scene/transfer_json.h"

void volume_entry_release(struct volume_entry *entry)
{
    mem_free(entry->file);
    mem_free(entry->function_file);
    entry->file = entry->function_file = NULL;
}

static enum stp_result get_dims(const struct json_at *at, const cJSON *item,
                                struct stp_volume_params *params)
{
    double dims[3];
    if (params->dims[0] || !json_has(item, "dims"))
        return STP_OK;
    enum stp_result result = json_get_numbers(at, item, "dims", 3, dims);
    for (int i = 0; result == STP_OK && i < 3; i++) {
        if (!(dims[i] >= 1 && dims[i] <= 4294967295.0) || dims[i] != (double)(uint32_t)dims[i])
            return json_error(at, "dims", "three whole numbers from 1 are needed");
        params->dims[i] = (uint32_t)dims[i];
    }
    return result;
}

static enum stp_result get_type(const struct json_at *at, const cJSON *item,
                                struct stp_volume_params *params)
{
    static const char *const names[] = { "", "u8", "u16", "i16", "f32" };
    const char *name = NULL;
    enum stp_result result = json_get_string(at, item, "type", &name);
    if (result != STP_OK || !name)
        return result;
    for (int i = 1; i < 5; i++)
        if (strcmp(names[i], name) == 0) {
            params->type = params->type ? params->type : (enum stp_voxel_type)i;
            return STP_OK;
        }
    return json_error(at, "type", "one of these is needed: u8 u16 i16 f32");
}

static enum stp_result get_spacing(const struct json_at *at, const cJSON *item,
                                   struct stp_volume_params *params)
{
    double spacing[3] = { 1, 1, 1 };
    if (params->spacing[0] > 0 || !json_has(item, "spacing"))
        return STP_OK;
    enum stp_result result = json_get_numbers(at, item, "spacing", 3, spacing);
    for (int i = 0; result == STP_OK && i < 3; i++) {
        if (!(spacing[i] > 0))
            return json_error(at, "spacing", "three numbers above 0 are needed");
        params->spacing[i] = spacing[i];
    }
    return result;
}

/* A preset's name, a path, or the function itself. */
static enum stp_result get_function(const struct json_at *root, const struct json_at *at,
                                    const cJSON *item, struct volume_entry *entry)
{
    const char *key = "transfer_function";
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(item, key);
    struct transfer_function preset;
    if (!value || entry->params.volume.transfer_function)
        return STP_OK;
    if (cJSON_IsObject(value)) {
        struct json_at below = json_below(at, key, -1);
        entry->has_function = true;
        return transfer_from_json(&below, value, &entry->function);
    }
    if (!cJSON_IsString(value))
        return json_error(at, key, "a preset, a path or an object is needed");
    entry->params.volume.transfer_function = value->valuestring;
    if (strcmp(value->valuestring, "auto") == 0 || transfer_preset(value->valuestring, &preset))
        return STP_OK;
    entry->function_file = scene_json_join(root->path, value->valuestring);
    entry->params.volume.transfer_function = entry->function_file;
    return entry->function_file ? STP_OK
                                : log_no_memory(root->env, strlen(value->valuestring), root->path);
}

static enum stp_result get_all(const struct json_at *root, const struct json_at *at,
                               const cJSON *item, struct volume_entry *entry)
{
    struct stp_volume_params *params = &entry->params.volume;
    const cJSON *material = cJSON_GetObjectItemCaseSensitive(item, "material");
    enum stp_result result = json_check_object(
        at, item, "file dims type spacing transfer_function unshaded material name comment");
    if (result == STP_OK)
        result = get_dims(at, item, params);
    if (result == STP_OK)
        result = get_type(at, item, params);
    if (result == STP_OK)
        result = get_spacing(at, item, params);
    if (result == STP_OK)
        result = json_get_bool(at, item, "unshaded", &params->unshaded);
    if (result == STP_OK && material && !entry->params.material) {
        struct json_at below = json_below(at, "material", -1);
        result = scene_json_material(&below, material, &entry->material);
        entry->params.material = &entry->material;
    }
    return result == STP_OK ? get_function(root, at, item, entry) : result;
}

enum stp_result volume_json_entry(const struct json_at *root, const cJSON *json,
                                  const struct stp_load_params *params, struct volume_entry *entry)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, "volume");
    struct json_at at = json_below(root, "volume", -1);
    const char *file = NULL;
    *entry = (struct volume_entry){ .params = *params };
    enum stp_result result = cJSON_IsString(item) ? STP_OK : get_all(root, &at, item, entry);
    if (result == STP_OK && cJSON_IsString(item))
        file = item->valuestring;
    else if (result == STP_OK)
        result = json_get_string(&at, item, "file", &file);
    if (result == STP_OK && (!file || !file[0]))
        result = json_error(&at, "file", "the path of a volume is needed");
    if (result == STP_OK && !(entry->file = scene_json_join(root->path, file)))
        result = log_no_memory(root->env, strlen(file), root->path);
    if (result != STP_OK)
        volume_entry_release(entry);
    return result;
}
