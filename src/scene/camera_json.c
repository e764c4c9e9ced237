#include "scene/camera_json.h"

#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"
#include "base/vec.h"

#define PI       3.14159265358979323846
#define MAX_SIDE (1u << 20)
/* |R R^T - I|: beyond the first it is an error; within the second it is left bit for bit. */
#define RIGID_TOLERANCE 1e-4
#define RIGID_EXACT     1e-12

static struct vec3 row(const double m[16], int i)
{
    return v3_load(m + 4 * i);
}

static double rigid_error(const double m[16])
{
    double worst = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            worst = fmax(worst, fabs(v3_dot(row(m, i), row(m, j)) - (i == j)));
    return worst;
}

static double determinant(const double m[16])
{
    return v3_dot(row(m, 0), v3_cross(row(m, 1), row(m, 2)));
}

/* One Newton step to the nearest rotation: R <- (R + R^-T) / 2. */
static void polish(double m[16])
{
    double d = determinant(m);
    struct vec3 r[3] = { row(m, 0), row(m, 1), row(m, 2) };
    for (int i = 0; i < 3; i++) {
        struct vec3 cofactor = v3_cross(r[(i + 1) % 3], r[(i + 2) % 3]);
        struct vec3 mean = v3_scale(v3_add(r[i], v3_scale(cofactor, 1 / d)), 0.5);
        m[4 * i] = mean.x;
        m[4 * i + 1] = mean.y;
        m[4 * i + 2] = mean.z;
    }
}

/* The rotation becomes the nearest exact one, about the same eye. */
static void make_rigid(double m[16])
{
    double d = determinant(m);
    struct vec3 t = v3(m[3], m[7], m[11]), r[3] = { row(m, 0), row(m, 1), row(m, 2) };
    struct vec3 eye = v3(0, 0, 0);
    double translation[3] = { t.x, t.y, t.z };
    for (int i = 0; i < 3; i++)
        eye = v3_add(eye, v3_scale(v3_cross(r[(i + 1) % 3], r[(i + 2) % 3]), -translation[i] / d));
    for (int step = 0; step < 4; step++)
        polish(m);
    struct vec3 moved = m4_direction(m, eye);
    m[3] = -moved.x;
    m[7] = -moved.y;
    m[11] = -moved.z;
}

static enum stp_result get_matrix(const struct json_at *at, const cJSON *object, double m[16])
{
    const char *convention = "opengl", *key = "world_to_camera";
    if (!json_has(object, key))
        return json_error(at, key, "missing");
    enum stp_result result = json_get_numbers(at, object, key, 16, m);
    if (result == STP_OK)
        result = json_get_string(at, object, "convention", &convention);
    if (result != STP_OK)
        return result;
    if (strcmp(convention, "opengl") != 0 && strcmp(convention, "opencv") != 0)
        return json_error(at, "convention", "opengl or opencv is needed");
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        return json_error(at, key, "the last row must be 0 0 0 1 (the matrix is row-major)");
    if (rigid_error(m) > RIGID_TOLERANCE || determinant(m) < 0) {
        char what[160];
        snprintf(what, sizeof what,
                 "not a rotation and a translation: row lengths %.6g %.6g %.6g, determinant %.6g "
                 "(no scale, shear or mirror)",
                 v3_length(row(m, 0)), v3_length(row(m, 1)), v3_length(row(m, 2)), determinant(m));
        return json_error(at, key, what);
    }
    if (rigid_error(m) > RIGID_EXACT)
        make_rigid(m);
    /* opencv: y down, z forward. 0 - x, so that no zero turns negative. */
    for (int i = 4; i < 12 && convention[4] == 'c'; i++)
        m[i] = 0 - m[i];
    return STP_OK;
}

static enum stp_result get_side(const struct json_at *at, const cJSON *object, const char *key,
                                uint32_t *side)
{
    double value = *side;
    enum stp_result result = json_get_number(at, object, key, &value);
    if (result != STP_OK)
        return result;
    if (value < 1 || value > MAX_SIDE || value != floor(value))
        return json_error(at, key, "a whole number from 1 to 1048576 is needed");
    *side = (uint32_t)value;
    return STP_OK;
}

static enum stp_result get_size(const struct json_at *at, const cJSON *object,
                                struct camera_json *out)
{
    out->camera.width = 1280;
    out->camera.height = 720;
    out->sized = json_has(object, "width") && json_has(object, "height");
    if (json_has(object, "width") != json_has(object, "height"))
        return json_error(at, "width", "width and height go together");
    enum stp_result result = get_side(at, object, "width", &out->camera.width);
    return result == STP_OK ? get_side(at, object, "height", &out->camera.height) : result;
}

static enum stp_result get_intrinsics(const struct json_at *at, const cJSON *object,
                                      struct camera_json *out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, "intrinsics");
    struct json_at below = json_below(at, "intrinsics", -1);
    struct stp_camera *c = &out->camera;
    enum stp_result result = json_check_object(&below, item, "fx fy cx cy");
    double *value[4] = { &c->fx, &c->fy, &c->cx, &c->cy };
    const char *key[4] = { "fx", "fy", "cx", "cy" };
    for (int i = 0; i < 4 && result == STP_OK; i++) {
        result = json_get_number(&below, item, key[i], value[i]);
        if (result == STP_OK && !json_has(item, key[i]))
            result = json_error(&below, key[i], "missing");
        if (result == STP_OK && i < 2 && *value[i] <= 0)
            result = json_error(&below, key[i], "must be positive");
    }
    if (result == STP_OK && !out->sized)
        result = json_error(at, "width", "intrinsics need width and height");
    out->intrinsics = true;
    return result;
}

static void center(struct stp_camera *c, double f)
{
    c->fx = c->fy = f;
    c->cx = c->width / 2.0;
    c->cy = c->height / 2.0;
}

double camera_focal(bool orthographic, double lens, uint32_t height)
{
    return orthographic ? height / lens : height / 2.0 / tan(lens * PI / 360);
}

static enum stp_result get_lens(const struct json_at *at, const cJSON *object,
                                struct camera_json *out)
{
    double fov = 0, height = 0;
    bool has_fov = json_has(object, "fov_y_deg"), has_height = json_has(object, "ortho_height");
    bool has_intrinsics = json_has(object, "intrinsics");
    if (has_fov + has_height + has_intrinsics != 1)
        return json_error(at, "fov_y_deg",
                          "exactly one of fov_y_deg, ortho_height and intrinsics is needed");
    out->camera.orthographic = has_height;
    enum stp_result result = json_get_number(at, object, "fov_y_deg", &fov);
    if (result == STP_OK)
        result = json_get_number(at, object, "ortho_height", &height);
    if (result == STP_OK)
        result = json_get_bool(at, object, "orthographic", &out->camera.orthographic);
    if (result != STP_OK)
        return result;
    if (!has_intrinsics && out->camera.orthographic != has_height)
        return json_error(at, "orthographic", "contradicts fov_y_deg or ortho_height");
    if (has_fov && !(fov > 0 && fov < 180))
        return json_error(at, "fov_y_deg", "degrees between 0 and 180 are needed");
    if (has_height && !(height > 0))
        return json_error(at, "ortho_height", "must be positive");
    if (has_intrinsics)
        return get_intrinsics(at, object, out);
    center(&out->camera, camera_focal(has_height, has_fov ? fov : height, out->camera.height));
    return STP_OK;
}

static enum stp_result get_range(const struct json_at *at, const cJSON *object,
                                 struct stp_camera *camera)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, "far");
    camera->near_depth = STP_DEFAULT_NEAR;
    camera->far_depth = INFINITY;
    enum stp_result result = json_get_number(at, object, "near", &camera->near_depth);
    if (result == STP_OK && !cJSON_IsNull(item))
        result = json_get_number(at, object, "far", &camera->far_depth);
    if (result != STP_OK)
        return result;
    if (!camera->orthographic && camera->near_depth <= 0)
        return json_error(at, "near", "must be positive");
    if (camera->far_depth <= camera->near_depth)
        return json_error(at, "far", "must be beyond near (null: infinite)");
    return STP_OK;
}

enum stp_result camera_from_json(const struct json_at *at, const cJSON *object,
                                 struct camera_json *camera)
{
    struct camera_json read = { 0 };
    enum stp_result result = json_check_object(
        at, object,
        "world_to_camera convention fov_y_deg ortho_height intrinsics orthographic width height "
        "near far");
    if (result == STP_OK)
        result = get_matrix(at, object, read.camera.world_to_camera);
    if (result == STP_OK)
        result = get_size(at, object, &read);
    if (result == STP_OK)
        result = get_lens(at, object, &read);
    if (result == STP_OK)
        result = get_range(at, object, &read.camera);
    if (result == STP_OK)
        *camera = read;
    return result;
}

void camera_resize(struct stp_camera *camera, bool intrinsics, uint32_t width, uint32_t height)
{
    double across = width ? (double)width / camera->width : 1;
    double down = height ? (double)height / camera->height : 1;
    camera->width = width ? width : camera->width;
    camera->height = height ? height : camera->height;
    if (!intrinsics) {
        center(camera, camera->fy * down);
        return;
    }
    camera->fx *= across;
    camera->cx *= across;
    camera->fy *= down;
    camera->cy *= down;
}

static enum stp_result pick_frame(const struct json_at *root, const cJSON *json, uint32_t index,
                                  struct camera_json *camera, uint32_t *count)
{
    if (!cJSON_IsArray(json)) {
        *count = 1;
    } else {
        *count = (uint32_t)cJSON_GetArraySize(json);
        if (*count == 0)
            return log_error(root->env, STP_ERROR_FORMAT, "%s: an empty camera path", root->path);
    }
    if (index >= *count)
        return log_error(root->env, STP_ERROR_ARGUMENT, "%s: no frame %u: it has %u camera%s",
                         root->path, index, *count, *count == 1 ? "" : "s");
    if (!cJSON_IsArray(json))
        return camera_from_json(root, json, camera);
    struct json_at at = json_below(root, "", (int)index);
    return camera_from_json(&at, cJSON_GetArrayItem(json, (int)index), camera);
}

enum stp_result stp_camera_load(const struct stp_env *env, const char *path, uint32_t index,
                                uint32_t width, uint32_t height, struct stp_camera *camera,
                                uint32_t *count)
{
    cJSON *json = NULL;
    struct camera_json read;
    uint32_t frames = 0;
    enum stp_result result = json_read(env, path, &json);
    if (result != STP_OK)
        return result;
    struct json_at root = json_root(env, path);
    result = pick_frame(&root, json, index, &read, &frames);
    cJSON_Delete(json);
    if (result != STP_OK)
        return result;
    if (width || height)
        camera_resize(&read.camera, read.intrinsics, width, height);
    *camera = read.camera;
    if (count)
        *count = frames;
    return STP_OK;
}
