#include "scene/environment.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/axes.h"
#include "scene/scene_json.h"

#define MOST_INTENSITY 1e6f

enum stp_result environment_check_params(const struct stp_env *env,
                                         const struct stp_environment_params *params)
{
    if (params && !isfinite(params->rotation))
        return log_error(env, STP_ERROR_ARGUMENT, "the environment's rotation is not finite");
    if (params && !(params->intensity >= 0 && params->intensity <= MOST_INTENSITY))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the environment's intensity is %g; it must be in [0, %g]",
                         (double)params->intensity, (double)MOST_INTENSITY);
    return STP_OK;
}

struct environment_frame environment_frame(enum stp_up up, double rotation)
{
    struct scene_axes axes = scene_axes(up);
    struct vec3 ahead = v3_scale(axes.viewer, -1);
    double c = cos(rotation), s = sin(rotation);
    return (struct environment_frame){
        .right = v3_add(v3_scale(axes.right, c), v3_scale(ahead, s)),
        .up = axes.up,
        .centre = v3_sub(v3_scale(ahead, c), v3_scale(axes.right, s)),
    };
}

static enum stp_result get_params(const struct json_at *at, const cJSON *item,
                                  struct stp_environment_params *params)
{
    double degrees = 0;
    enum stp_result result = json_check_object(at, item, "file rotation intensity name comment");
    if (result == STP_OK)
        result = json_get_number(at, item, "rotation", &degrees);
    if (result == STP_OK)
        result = json_get_float(at, item, "intensity", &params->intensity);
    if (result == STP_OK && json_has(item, "intensity") &&
        !(params->intensity > 0 && params->intensity <= MOST_INTENSITY))
        result = json_error(at, "intensity", "more than 0 and at most 1e6 is needed");
    params->rotation = degrees * (3.14159265358979323846 / 180);
    return result;
}

enum stp_result environment_from_json(const struct json_at *root, const cJSON *json,
                                      struct scene_environment *environment)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, "environment");
    struct json_at at = json_below(root, "environment", -1);
    struct scene_environment read = { 0 };
    const char *file = NULL;
    if (!item)
        return STP_OK;
    enum stp_result result = get_params(&at, item, &read.params);
    if (result == STP_OK)
        result = json_get_string(&at, item, "file", &file);
    if (result == STP_OK && (!file || !file[0]))
        result = json_error(&at, "file", "the path of an environment map is needed");
    if (result != STP_OK)
        return result;
    char *path = scene_json_join(root->path, file);
    if (!path)
        return log_no_memory(root->env, strlen(file), root->path);
    result = environment_read(root->env, path, &read.map);
    mem_free(path);
    if (result == STP_OK)
        *environment = read;
    return result;
}
