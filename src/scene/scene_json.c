#include "scene/scene_json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"
#include "scene/camera_json.h"
#include "scene/optics.h"

/* Names to values of an enum, ended by a NULL name. */
struct choice {
    const char *name;
    int value;
};

static enum stp_result get_choice(const struct json_at *at, const cJSON *object, const char *key,
                                  const struct choice *choices, int *value)
{
    const char *name = NULL;
    char what[96] = "one of these is needed:";
    enum stp_result result = json_get_string(at, object, key, &name);
    if (result != STP_OK || !name)
        return result;
    for (; choices->name; choices++) {
        size_t used = strlen(what);
        snprintf(what + used, sizeof what - used, " %s", choices->name);
        if (strcmp(choices->name, name) == 0) {
            *value = choices->value;
            return STP_OK;
        }
    }
    return json_error(at, key, what);
}

/* Is it what lies beside raw volumes: one description, or descriptions by files' names? */
static bool describes_volumes(const cJSON *json)
{
    const cJSON *item;
    if (json_has(json, "points") || json_has(json, "volume"))
        return false;
    if (json_has(json, "dims"))
        return true;
    cJSON_ArrayForEach(item, json) if (cJSON_IsObject(item) && json_has(item, "dims")) return true;
    return false;
}

enum stp_result scene_json_begin(const struct json_at *root, const cJSON *json, enum stp_up *up,
                                 int *entries)
{
    const struct choice ups[] = { { "auto", STP_UP_AUTO }, { "x", STP_UP_X },
                                  { "y", STP_UP_Y },       { "z", STP_UP_Z },
                                  { "-y", STP_UP_NEG_Y },  { NULL, 0 } };
    const cJSON *points = cJSON_GetObjectItemCaseSensitive(json, "points");
    int read = STP_UP_AUTO;
    if (describes_volumes(json))
        return json_error(root, "dims",
                          "describes a raw volume, and this is no scene: give the raw file, which "
                          "finds this one beside it");
    if (!points && json_has(json, "world_to_camera"))
        return json_error(root, "world_to_camera",
                          "describes a camera, and this is no scene: give it to --camera");
    enum stp_result result = json_check_object(
        root, json, "points volume range lights camera camera_file environment up name comment");
    if (result == STP_OK && points && json_has(json, "volume"))
        result =
            json_error(root, "volume", "stands beside points: a scene holds the one or the other");
    bool none = !points && (json_has(json, "volume") || json_has(json, "range"));
    if (result == STP_OK && !none && !cJSON_IsArray(points))
        result = json_error(root, "points", "an array of point files is needed");
    if (result == STP_OK)
        result = get_choice(root, json, "up", ups, &read);
    if (result != STP_OK)
        return result;
    *up = (enum stp_up)read;
    *entries = cJSON_GetArraySize(points);
    return STP_OK;
}

char *scene_json_join(const char *scene_path, const char *file)
{
    const char *slash = strrchr(scene_path, '/');
    size_t folder = file[0] == '/' || !slash ? 0 : (size_t)(slash + 1 - scene_path);
    char *joined = mem_alloc(folder + strlen(file) + 1, 1);
    if (joined) {
        memcpy(joined, scene_path, folder);
        strcpy(joined + folder, file);
    }
    return joined;
}

static enum stp_result get_positive(const struct json_at *at, const cJSON *object, const char *key,
                                    double *value)
{
    enum stp_result result = json_get_number(at, object, key, value);
    if (result == STP_OK && json_has(object, key) && !(*value > 0))
        return json_error(at, key, "must be positive");
    return result;
}

/* In [0, 1]; what the file says of 0 is the negative of the params. */
static enum stp_result get_opacity(const struct json_at *at, const cJSON *object, float *opacity)
{
    double value = 0;
    enum stp_result result = json_get_number(at, object, "opacity", &value);
    if (result != STP_OK || !json_has(object, "opacity"))
        return result;
    if (!(value >= 0 && value <= 1))
        return json_error(at, "opacity", "a number from 0 to 1 is needed");
    *opacity = (float)value > 0 ? (float)value : -1;
    return STP_OK;
}

static enum stp_result get_color(const struct json_at *at, const cJSON *object, const char *key,
                                 float color[3])
{
    double read[3] = { color[0], color[1], color[2] };
    enum stp_result result = json_get_numbers(at, object, key, 3, read);
    for (int i = 0; i < 3 && result == STP_OK; i++) {
        if (read[i] < 0 || !isfinite((float)read[i]))
            return json_error(at, key, "three numbers from 0 are needed");
        color[i] = (float)read[i];
    }
    return result;
}

enum stp_result scene_json_material(const struct json_at *at, const cJSON *item,
                                    struct stp_material *material)
{
    struct stp_material read = SCENE_DEFAULT_MATERIAL;
    const char *keys[4] = { "ambient", "diffuse", "specular", "shininess" };
    float *values[4] = { &read.ambient, &read.diffuse, &read.specular, &read.shininess };
    enum stp_result result = json_check_object(
        at, item, "ambient diffuse specular shininess albedo opacity " OPTICS_KEYS);
    for (int i = 0; i < 4 && result == STP_OK; i++) {
        result = json_get_float(at, item, keys[i], values[i]);
        if (result == STP_OK && *values[i] < 0)
            result = json_error(at, keys[i], "must not be negative");
    }
    if (result == STP_OK)
        result = get_color(at, item, "albedo", read.albedo);
    if (result == STP_OK)
        result = get_opacity(at, item, &read.opacity);
    if (result == STP_OK)
        *material = read;
    return result;
}

/* Rotation times one positive scale; the scale comes from the determinant. */
static enum stp_result get_transform(const struct json_at *at, const cJSON *item,
                                     struct scene_entry *entry)
{
    const char *key = "transform";
    double *m = entry->transform;
    enum stp_result result = json_get_numbers(at, item, key, 16, m);
    if (result != STP_OK || !json_has(item, key))
        return result;
    struct vec3 r[3] = { v3_load(m), v3_load(m + 4), v3_load(m + 8) };
    double scale = cbrt(v3_dot(r[0], v3_cross(r[1], r[2]))), worst = scale > 0 ? 0 : INFINITY;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            worst = fmax(worst, fabs(v3_dot(r[i], r[j]) / (scale * scale) - (i == j)));
    if (!(worst <= 1e-4) || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        return json_error(at, key,
                          "a rotation, one scale and a translation are needed (row-major, "
                          "last row 0 0 0 1; no shear or mirror)");
    entry->transformed = true;
    entry->scale = scale;
    return STP_OK;
}

static enum stp_result get_look(const struct json_at *at, const cJSON *item,
                                struct scene_entry *entry)
{
    const struct choice transfers[] = { { "auto", STP_TRANSFER_AUTO },
                                        { "srgb", STP_TRANSFER_SRGB },
                                        { "linear", STP_TRANSFER_LINEAR },
                                        { NULL, 0 } };
    struct stp_load_params *p = &entry->params;
    const struct stp_load_params given = *p;
    int transfer = STP_TRANSFER_AUTO;
    const cJSON *material = cJSON_GetObjectItemCaseSensitive(item, "material");
    enum stp_result result = STP_OK;
    if (material) {
        struct json_at below = json_below(at, "material", -1);
        result = scene_json_material(&below, material, &entry->material);
        if (result == STP_OK)
            result = optics_from_json(&below, material, &entry->optics);
    }
    if (result == STP_OK)
        result = get_positive(at, item, "epsilon", &p->epsilon);
    if (result == STP_OK)
        result = get_opacity(at, item, &p->opacity);
    if (result == STP_OK)
        result = json_get_string(at, item, "color_by", &p->color_by);
    if (result == STP_OK)
        result = get_choice(at, item, "transfer", transfers, &transfer);
    if (result != STP_OK)
        return result;
    p->material = given.material ? given.material : material ? &entry->material : NULL;
    entry->optics = optics_merge(&entry->optics, given.optics);
    p->optics = &entry->optics;
    p->epsilon = given.epsilon > 0 ? given.epsilon : p->epsilon;
    p->opacity = given.opacity != 0 ? given.opacity : p->opacity;
    p->color_by = given.color_by ? given.color_by : p->color_by;
    p->transfer = given.transfer ? given.transfer : (enum stp_transfer)transfer;
    return STP_OK;
}

enum stp_result scene_json_entry(const struct json_at *root, const cJSON *json, int index,
                                 const struct stp_load_params *params, struct scene_entry *entry)
{
    const cJSON *points = cJSON_GetObjectItemCaseSensitive(json, "points");
    const cJSON *item = cJSON_GetArrayItem(points, index);
    struct json_at at = json_below(root, "points", index);
    const char *file = NULL;
    *entry = (struct scene_entry){ .params = *params };
    if (cJSON_IsString(item)) {
        file = item->valuestring;
    } else {
        enum stp_result result = json_check_object(
            &at, item, "file material epsilon opacity color_by transfer transform name comment");
        if (result == STP_OK)
            result = json_get_string(&at, item, "file", &file);
        if (result == STP_OK)
            result = get_look(&at, item, entry);
        if (result == STP_OK)
            result = get_transform(&at, item, entry);
        if (result != STP_OK)
            return result;
    }
    if (!file || !file[0])
        return json_error(&at, "file", "the path of a point file is needed");
    entry->file = scene_json_join(root->path, file);
    return entry->file ? STP_OK : log_no_memory(root->env, strlen(file), root->path);
}

static enum stp_result get_light(const struct json_at *at, const cJSON *item,
                                 struct stp_light *light)
{
    bool directional = json_has(item, "direction"), positional = json_has(item, "position");
    struct stp_light read = { .color = { 1, 1, 1 }, .positional = positional };
    enum stp_result result = json_check_object(at, item, "at_eye direction position color");
    if (result == STP_OK)
        result = json_get_bool(at, item, "at_eye", &read.at_eye);
    if (result == STP_OK && read.at_eye + directional + positional != 1)
        result = json_error(at, "at_eye",
                            "exactly one of at_eye (true), direction and position is needed");
    if (result == STP_OK)
        result = json_get_numbers(at, item, "direction", 3, read.direction);
    if (result == STP_OK)
        result = json_get_numbers(at, item, "position", 3, read.position);
    if (result == STP_OK && directional && !(v3_length(v3_load(read.direction)) > 0))
        result = json_error(at, "direction", "must not be zero");
    if (result == STP_OK)
        result = get_color(at, item, "color", read.color);
    if (result == STP_OK)
        *light = read;
    return result;
}

enum stp_result scene_json_lights(const struct json_at *root, const cJSON *json,
                                  struct stp_scene *scene)
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(json, "lights"), *item;
    struct stp_light lights[STP_MAX_LIGHTS];
    unsigned count = 0;
    if (!array)
        return STP_OK;
    if (!cJSON_IsArray(array) || cJSON_GetArraySize(array) < 1 ||
        cJSON_GetArraySize(array) > STP_MAX_LIGHTS)
        return json_error(root, "lights", "an array of 1 to 8 lights is needed");
    cJSON_ArrayForEach(item, array)
    {
        struct json_at at = json_below(root, "lights", (int)count);
        enum stp_result result = get_light(&at, item, &lights[count]);
        if (result != STP_OK)
            return result;
        count++;
    }
    return stp_scene_set_lights(root->env, scene, lights, count);
}

static enum stp_result camera_of_file(const struct json_at *root, const char *file,
                                      struct camera_json *camera)
{
    cJSON *json = NULL;
    char *path = scene_json_join(root->path, file);
    if (!path)
        return log_no_memory(root->env, strlen(file), root->path);
    enum stp_result result = json_read(root->env, path, &json);
    if (result == STP_OK) {
        struct json_at at = json_root(root->env, path);
        /* Of a camera path, the first. */
        const cJSON *first = cJSON_IsArray(json) ? cJSON_GetArrayItem(json, 0) : json;
        result = camera_from_json(&at, first, camera);
    }
    cJSON_Delete(json);
    mem_free(path);
    return result;
}

enum stp_result scene_json_camera(const struct json_at *root, const cJSON *json,
                                  struct stp_scene *scene)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, "camera");
    struct camera_json camera;
    const char *file = NULL;
    enum stp_result result = json_get_string(root, json, "camera_file", &file);
    if (result != STP_OK || (!item && !file))
        return result;
    if (item && file)
        return json_error(root, "camera_file", "camera and camera_file exclude each other");
    if (file) {
        result = camera_of_file(root, file, &camera);
    } else {
        struct json_at at = json_below(root, "camera", -1);
        result = camera_from_json(&at, item, &camera);
    }
    if (result != STP_OK)
        return result;
    scene->has_camera = true;
    scene->camera = camera.camera;
    scene->camera_intrinsics = camera.intrinsics;
    return STP_OK;
}
