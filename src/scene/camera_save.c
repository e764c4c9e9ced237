/* Camera files written so that stp_camera_load gives the same bits. */
#include <math.h>

#include "base/file.h"
#include "base/json.h"
#include "base/log.h"
#include "scene/camera_json.h"

#define PI 3.14159265358979323846

static void put(FILE *out, const char *before, double value, const char *after)
{
    char text[JSON_NUMBER_SIZE];
    fprintf(out, "%s%s%s", before, json_number_text(value, text), after);
}

/* The field of view (degrees) or height that loads as exactly this camera; 0: there is none, and
 * intrinsics must be written. */
static double exact_lens(const struct stp_camera *c)
{
    if (c->fx != c->fy || c->cx != c->width / 2.0 || c->cy != c->height / 2.0)
        return 0;
    double lens = c->orthographic ? c->height / c->fy : atan(c->height / 2.0 / c->fy) * 360 / PI;
    double up = lens, down = lens;
    for (int ulps = 0; ulps < 8; ulps++) {
        if (camera_focal(c->orthographic, up, c->height) == c->fy)
            return up;
        if (camera_focal(c->orthographic, down, c->height) == c->fy)
            return down;
        up = nextafter(up, INFINITY);
        down = nextafter(down, 0);
    }
    return 0;
}

static void put_lens(FILE *out, const struct stp_camera *c)
{
    double lens = exact_lens(c);
    if (lens > 0) {
        put(out, c->orthographic ? "  \"ortho_height\": " : "  \"fov_y_deg\": ", lens, ",\n");
        return;
    }
    if (c->orthographic)
        fputs("  \"orthographic\": true,\n", out);
    put(out, "  \"intrinsics\": { \"fx\": ", c->fx, ", ");
    put(out, "\"fy\": ", c->fy, ", ");
    put(out, "\"cx\": ", c->cx, ", ");
    put(out, "\"cy\": ", c->cy, " },\n");
}

static void put_camera(FILE *out, const struct stp_camera *c)
{
    fputs("{\n  \"world_to_camera\": [\n", out);
    for (int i = 0; i < 16; i++)
        put(out, i % 4 == 0 ? "    [" : "", c->world_to_camera[i],
            i == 15      ? "]\n"
            : i % 4 == 3 ? "],\n"
                         : ", ");
    fputs("  ],\n  \"convention\": \"opengl\",\n", out);
    put_lens(out, c);
    fprintf(out, "  \"width\": %u,\n  \"height\": %u,\n", c->width, c->height);
    put(out, "  \"near\": ", c->near_depth, ",\n");
    if (isinf(c->far_depth))
        fputs("  \"far\": null\n}\n", out);
    else
        put(out, "  \"far\": ", c->far_depth, "\n}\n");
}

static bool sound(const struct stp_camera *c)
{
    bool finite = isfinite(c->fx) && isfinite(c->fy) && isfinite(c->cx) && isfinite(c->cy) &&
                  isfinite(c->near_depth) && !isnan(c->far_depth);
    for (int i = 0; i < 16; i++)
        finite = finite && isfinite(c->world_to_camera[i]);
    return finite && c->width && c->height && c->fx > 0 && c->fy > 0;
}

enum stp_result stp_camera_save(const struct stp_env *env, const char *path,
                                const struct stp_camera *camera)
{
    struct file_output out = { 0 };
    if (!sound(camera))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "%s: the camera has no size, or a number that is "
                         "not finite",
                         path);
    enum stp_result result = file_begin(env, path, &out);
    if (result != STP_OK)
        return result;
    put_camera(out.stream, camera);
    return file_commit(env, &out);
}
