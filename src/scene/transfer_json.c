/* Transfer functions in JSON (docs/volumes.md). */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "load/color.h"
#include "scene/transfer_json.h"

/* "#rrggbb", sRGB. */
static bool read_hash_color(const char *text, float color[3])
{
    unsigned part[3];
    if (strlen(text) != 7 || text[0] != '#')
        return false;
    for (int i = 1; i < 7; i++) /* sscanf alone would take signs, spaces and "0x" */
        if (!isxdigit((unsigned char)text[i]))
            return false;
    if (sscanf(text, "#%2x%2x%2x", &part[0], &part[1], &part[2]) != 3)
        return false;
    for (int c = 0; c < 3; c++)
        color[c] = (float)color_from_srgb(part[c] / 255.0);
    return true;
}

static enum stp_result get_color(const struct json_at *at, const cJSON *item, float color[3])
{
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(item, "color");
    double read[3] = { 1, 1, 1 };
    if (cJSON_IsString(value))
        return read_hash_color(value->valuestring, color)
                   ? STP_OK
                   : json_error(at, "color", "\"#rrggbb\" or three linear numbers are needed");
    enum stp_result result = json_get_numbers(at, item, "color", 3, read);
    for (int c = 0; result == STP_OK && c < 3; c++) {
        if (!(read[c] >= 0 && read[c] <= 65504))
            return json_error(at, "color", "three numbers from 0 to 65504 are needed");
        color[c] = (float)read[c];
    }
    return result;
}

static enum stp_result get_point(const struct json_at *at, const cJSON *item,
                                 struct transfer_point *point)
{
    struct transfer_point read = { 0 };
    double opacity = 0;
    enum stp_result result = json_check_object(at, item, "value color opacity");
    if (result == STP_OK && (!json_has(item, "value") || !json_has(item, "opacity")))
        return json_error(at, "value", "a point has a value and an opacity");
    if (result == STP_OK)
        result = json_get_number(at, item, "value", &read.value);
    if (result == STP_OK)
        result = json_get_number(at, item, "opacity", &opacity);
    if (result == STP_OK && !(opacity >= 0 && opacity <= 1))
        return json_error(at, "opacity", "a number from 0 to 1 is needed");
    if (result == STP_OK)
        result = get_color(at, item, read.color);
    if (result != STP_OK)
        return result;
    read.opacity = (float)opacity;
    *point = read;
    return STP_OK;
}

static enum stp_result get_points(const struct json_at *at, const cJSON *json,
                                  struct transfer_function *function)
{
    const cJSON *points = cJSON_GetObjectItemCaseSensitive(json, "points"), *item;
    int count = cJSON_IsArray(points) ? cJSON_GetArraySize(points) : 0;
    if (count < 1 || count > TRANSFER_POINTS)
        return json_error(at, "points", "an array of 1 to 256 points is needed");
    cJSON_ArrayForEach(item, points)
    {
        unsigned i = function->count;
        struct json_at below = json_below(at, "points", (int)i);
        enum stp_result result = get_point(&below, item, &function->point[i]);
        if (result != STP_OK)
            return result;
        if (i > 0 && !(function->point[i].value >= function->point[i - 1].value))
            return json_error(&below, "value", "values must not descend");
        function->count++;
    }
    return STP_OK;
}

enum stp_result transfer_from_json(const struct json_at *at, const cJSON *json,
                                   struct transfer_function *function)
{
    struct transfer_function read = { .name = "custom" };
    const char *name = NULL, *unit = NULL;
    enum stp_result result = json_check_object(at, json, "name unit points comment");
    if (result == STP_OK)
        result = json_get_string(at, json, "name", &name);
    if (result == STP_OK)
        result = json_get_string(at, json, "unit", &unit);
    if (result == STP_OK && unit && strcmp(unit, "value") != 0 && strcmp(unit, "range") != 0)
        return json_error(at, "unit", "\"value\" or \"range\" is needed");
    if (result == STP_OK)
        result = get_points(at, json, &read);
    if (result != STP_OK)
        return result;
    if (name)
        snprintf(read.name, sizeof read.name, "%s", name);
    read.of_range = unit && strcmp(unit, "range") == 0;
    *function = read;
    return STP_OK;
}

enum stp_result transfer_load(const struct stp_env *env, const char *path,
                              struct transfer_function *function)
{
    cJSON *json = NULL;
    enum stp_result result = json_read(env, path, &json);
    if (result != STP_OK)
        return result;
    struct json_at root = json_root(env, path);
    result = transfer_from_json(&root, json, function);
    cJSON_Delete(json);
    return result;
}
