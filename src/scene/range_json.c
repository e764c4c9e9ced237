/* "range" of a scene .json: frames, their cameras, units and sensors. What a frame says wins over
 * what the whole says. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/range.h"
#include "scene/scene_json.h"

#define KEYS_OF_ALL "intrinsics intrinsics_file depth_scale disparity sensor margin"

/* What frames have in common. */
struct common {
    struct range_camera camera; /* fx 0: not said */
    struct range_units units;
    struct range_sensor sensor;
    bool has_sensor;
};

static enum stp_result get_above_zero(const struct json_at *at, const cJSON *item, const char *key,
                                      double *value)
{
    enum stp_result result = json_get_number(at, item, key, value);
    if (result == STP_OK && json_has(item, key) && !(*value > 0))
        return json_error(at, key, "must be positive");
    return result;
}

static enum stp_result load_text(const struct json_at *root, const char *file, double (**poses)[16],
                                 unsigned *count, struct common *common)
{
    char *path = scene_json_join(root->path, file);
    if (!path)
        return log_no_memory(root->env, strlen(file), root->path);
    enum stp_result result =
        poses ? range_load_poses(root->env, path, poses, count)
              : range_load_intrinsics(root->env, path, &common->camera, &common->units);
    mem_free(path);
    return result;
}

static enum stp_result get_intrinsics(const struct json_at *root, const struct json_at *at,
                                      const cJSON *item, struct common *common)
{
    const cJSON *own = cJSON_GetObjectItemCaseSensitive(item, "intrinsics");
    const char *file = NULL;
    enum stp_result result = json_get_string(at, item, "intrinsics_file", &file);
    if (result == STP_OK && file)
        result = load_text(root, file, NULL, NULL, common);
    if (result != STP_OK || !own)
        return result;
    struct json_at below = json_below(at, "intrinsics", -1);
    struct range_camera *c = &common->camera;
    result = json_check_object(&below, own, "fx fy cx cy");
    if (result == STP_OK &&
        !(json_has(own, "fx") && json_has(own, "fy") && json_has(own, "cx") && json_has(own, "cy")))
        return json_error(at, "intrinsics", "fx, fy, cx and cy are needed");
    if (result == STP_OK)
        result = get_above_zero(&below, own, "fx", &c->fx);
    if (result == STP_OK)
        result = get_above_zero(&below, own, "fy", &c->fy);
    if (result == STP_OK)
        result = json_get_number(&below, own, "cx", &c->cx);
    if (result == STP_OK)
        result = json_get_number(&below, own, "cy", &c->cy);
    return result;
}

static enum stp_result get_units(const struct json_at *at, const cJSON *item,
                                 struct range_units *units)
{
    const cJSON *disparity = cJSON_GetObjectItemCaseSensitive(item, "disparity");
    struct json_at below = json_below(at, "disparity", -1);
    enum stp_result result = get_above_zero(at, item, "depth_scale", &units->depth_scale);
    if (result == STP_OK)
        result = json_get_number(at, item, "margin", &units->margin);
    if (result == STP_OK && !(units->margin >= 0))
        return json_error(at, "margin", "must not be negative");
    if (result != STP_OK || !disparity)
        return result;
    result = json_check_object(&below, disparity, "baseline offset");
    if (result == STP_OK && !json_has(disparity, "baseline"))
        return json_error(&below, "baseline", "is needed");
    if (result == STP_OK)
        result = get_above_zero(&below, disparity, "baseline", &units->baseline);
    if (result == STP_OK)
        result = json_get_number(&below, disparity, "offset", &units->disparity_offset);
    return result;
}

static enum stp_result get_sensor_kind(const struct json_at *at, const cJSON *item,
                                       struct range_sensor *sensor)
{
    static const char *const names[] = { "structured-light", "stereo", "constant" };
    const char *name = names[RANGE_STRUCTURED_LIGHT];
    enum stp_result result = json_get_string(at, item, "type", &name);
    for (int i = 0; result == STP_OK && i < 3; i++)
        if (strcmp(name, names[i]) == 0) {
            sensor->kind = (enum range_sensor_kind)i;
            return STP_OK;
        }
    return result == STP_OK
               ? json_error(at, "type", "one of these is needed: structured-light stereo constant")
               : result;
}

/* One of its own, not a mixture with the one around it. Disparities come from stereo where nothing
 * else is said. */
static enum stp_result get_sensor(const struct json_at *at, const cJSON *item,
                                  struct common *common)
{
    const struct range_units *units = &common->units;
    const cJSON *own = cJSON_GetObjectItemCaseSensitive(item, "sensor");
    struct json_at below = json_below(at, "sensor", -1);
    struct range_sensor read = { .sigma = RANGE_KINECT_SIGMA,
                                 .sigma_disparity = RANGE_SIGMA_DISPARITY,
                                 .baseline = units->baseline };
    if (!own && common->has_sensor)
        return STP_OK;
    if (!own) {
        read.kind = units->baseline > 0 ? RANGE_STEREO : RANGE_STRUCTURED_LIGHT;
        common->sensor = read;
        return STP_OK;
    }
    enum stp_result result = json_check_object(&below, own, "type sigma sigma_disparity baseline");
    if (result == STP_OK)
        result = get_sensor_kind(&below, own, &read);
    if (result == STP_OK)
        result = get_above_zero(&below, own, "sigma", &read.sigma);
    if (result == STP_OK)
        result = get_above_zero(&below, own, "sigma_disparity", &read.sigma_disparity);
    if (result == STP_OK)
        result = get_above_zero(&below, own, "baseline", &read.baseline);
    if (result == STP_OK && read.kind == RANGE_CONSTANT && !json_has(own, "sigma"))
        return json_error(&below, "sigma", "is needed of a constant deviation");
    if (result != STP_OK)
        return result;
    common->sensor = read;
    common->has_sensor = true;
    return STP_OK;
}

static enum stp_result get_common(const struct json_at *root, const struct json_at *at,
                                  const cJSON *item, struct common *common)
{
    enum stp_result result = get_intrinsics(root, at, item, common);
    if (result == STP_OK)
        result = get_units(at, item, &common->units);
    if (result == STP_OK)
        result = get_sensor(at, item, common);
    return result;
}

static bool is_rigid(const double m[16])
{
    double worst = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            worst = fmax(worst, fabs(v3_dot(v3_load(m + 4 * i), v3_load(m + 4 * j)) - (i == j)));
    struct vec3 cross = v3_cross(v3_load(m), v3_load(m + 4));
    return worst <= 1e-4 && v3_dot(cross, v3_load(m + 8)) > 0 && m[12] == 0 && m[13] == 0 &&
           m[14] == 0 && m[15] == 1;
}

/* "pose", "camera_to_world", or the line of the poses' file; line NULL: there is none. */
static enum stp_result get_pose(const struct json_at *at, const cJSON *item, const double *line,
                                double to_world[16])
{
    double seven[7];
    if (json_has(item, "pose")) {
        enum stp_result result = json_get_numbers(at, item, "pose", 7, seven);
        if (result == STP_OK && !range_pose(seven, to_world))
            return json_error(at, "pose", "tx ty tz qx qy qz qw is needed, a unit quaternion");
        return result;
    }
    if (json_has(item, "camera_to_world")) {
        enum stp_result result = json_get_numbers(at, item, "camera_to_world", 16, to_world);
        if (result == STP_OK && !is_rigid(to_world))
            return json_error(at, "camera_to_world",
                              "a rotation and a translation are needed (row-major, last row "
                              "0 0 0 1)");
        return result;
    }
    if (!line)
        return json_error(at, "pose",
                          "a frame needs pose or camera_to_world, or a line of "
                          "poses_file");
    memcpy(to_world, line, 16 * sizeof *line);
    return STP_OK;
}

static enum stp_result read_pictures(const struct json_at *root, const struct json_at *at,
                                     const cJSON *item, const struct range_units *units,
                                     enum stp_transfer transfer, struct range_frame *frame)
{
    const char *depth = NULL, *color = NULL;
    enum stp_result result = json_get_string(at, item, "depth", &depth);
    if (result == STP_OK)
        result = json_get_string(at, item, "color", &color);
    if (result != STP_OK)
        return result;
    if (!depth || !color)
        return json_error(at, depth ? "color" : "depth", "the path of a picture is needed");
    char *deep = scene_json_join(root->path, depth), *colored = scene_json_join(root->path, color);
    if (deep && colored)
        result = range_frame_read(root->env, deep, colored, units, transfer, frame);
    else
        result = log_no_memory(root->env, strlen(root->path), root->path);
    mem_free(deep);
    mem_free(colored);
    return result;
}

static enum stp_result get_frame(const struct json_at *root, const struct json_at *at,
                                 const cJSON *item, struct common common, const double *line,
                                 const struct stp_load_params *params, struct range_frame *frame)
{
    enum stp_result result =
        json_check_object(at, item, "depth color pose camera_to_world name comment " KEYS_OF_ALL);
    if (result == STP_OK)
        result = get_common(root, at, item, &common);
    if (result == STP_OK && !(common.camera.fx > 0))
        return json_error(at, "intrinsics", "are needed, of the frame or of the whole");
    if (result == STP_OK && common.sensor.kind == RANGE_STEREO && !(common.sensor.baseline > 0))
        return json_error(at, "sensor", "stereo needs a baseline");
    if (result == STP_OK)
        result = get_pose(at, item, line, common.camera.to_world);
    frame->camera = common.camera;
    frame->sensor = common.sensor;
    return result == STP_OK ? read_pictures(root, at, item, &common.units, params->transfer, frame)
                            : result;
}

static enum stp_result get_frames(const struct json_at *root, const struct json_at *at,
                                  const cJSON *item, const struct common *common,
                                  const struct stp_load_params *params, struct range *range)
{
    const cJSON *frames = cJSON_GetObjectItemCaseSensitive(item, "frames");
    const char *file = NULL;
    double(*poses)[16] = NULL;
    unsigned pose_count = 0, count = (unsigned)cJSON_GetArraySize(frames);
    if (!cJSON_IsArray(frames) || count < 1 || count > RANGE_MOST_FRAMES)
        return json_error(at, "frames", "an array of 1 to 1024 frames is needed");
    enum stp_result result = json_get_string(at, item, "poses_file", &file);
    if (result == STP_OK && file)
        result = load_text(root, file, &poses, &pose_count, NULL);
    if (result == STP_OK && !(range->frame = mem_zalloc(count, sizeof *range->frame)))
        result = log_no_memory(root->env, count * sizeof *range->frame, root->path);
    if (result == STP_OK)
        range->count = count;
    for (unsigned i = 0; i < count && result == STP_OK; i++) {
        struct json_at below = json_below(at, "frames", (int)i);
        result = get_frame(root, &below, cJSON_GetArrayItem(frames, (int)i), *common,
                           i < pose_count ? poses[i] : NULL, params, &range->frame[i]);
        log_progress(root->env, "load", (double)(i + 1) / count);
    }
    mem_free(poses);
    return result;
}

static enum stp_result get_splats(const struct json_at *at, const cJSON *item,
                                  enum stp_range_splats asked, enum stp_range_splats *splats)
{
    const char *name = "ellipsoids";
    enum stp_result result = json_get_string(at, item, "splats", &name);
    if (result != STP_OK)
        return result;
    if (strcmp(name, "ellipsoids") != 0 && strcmp(name, "discs") != 0)
        return json_error(at, "splats", "one of these is needed: ellipsoids discs");
    *splats = asked ? asked : strcmp(name, "discs") == 0 ? STP_RANGE_DISCS : STP_RANGE_ELLIPSOIDS;
    return STP_OK;
}

static enum stp_result get_all(const struct json_at *root, const struct json_at *at,
                               const cJSON *item, const struct stp_load_params *params,
                               struct range *range, enum stp_range_splats *splats)
{
    struct common common = { .units = { .depth_scale = 1 } };
    enum stp_result result = json_check_object(
        at, item, "frames poses_file uncertainty splats name comment " KEYS_OF_ALL);
    range->uncertainty = 1;
    if (result == STP_OK)
        result = json_get_number(at, item, "uncertainty", &range->uncertainty);
    if (result == STP_OK && !(range->uncertainty >= 0))
        return json_error(at, "uncertainty", "must not be negative");
    if (params->range.uncertainty != 0)
        range->uncertainty = fmax(params->range.uncertainty, 0);
    if (result == STP_OK)
        result = get_splats(at, item, params->range.splats, splats);
    if (result == STP_OK)
        result = get_common(root, at, item, &common);
    return result == STP_OK ? get_frames(root, at, item, &common, params, range) : result;
}

enum stp_result range_from_json(const struct json_at *root, const cJSON *json,
                                const struct stp_load_params *params, struct range *range,
                                enum stp_range_splats *splats)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, "range");
    struct json_at at = json_below(root, "range", -1);
    struct range made = { 0 };
    if (cJSON_IsString(item)) {
        char *path = scene_json_join(root->path, item->valuestring);
        if (!path)
            return log_no_memory(root->env, strlen(item->valuestring), root->path);
        enum stp_result result = range_from_folder(root->env, path, params, &made);
        mem_free(path);
        *splats = params->range.splats ? params->range.splats : STP_RANGE_ELLIPSOIDS;
        if (result == STP_OK)
            *range = made;
        return result;
    }
    enum stp_result result = get_all(root, &at, item, params, &made, splats);
    if (result == STP_OK)
        *range = made;
    else
        range_release(&made);
    return result;
}
