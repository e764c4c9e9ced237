#include "scene/camera.h"

#include <math.h>

#include "base/log.h"

static bool finite_all(const double *value, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(value[i]))
            return false;
    return true;
}

enum stp_result camera_check(const struct stp_env *env, const struct stp_camera *c)
{
    const double center[] = { c->cx, c->cy };
    if (c->width == 0 || c->height == 0)
        return log_error(env, STP_ERROR_ARGUMENT, "camera: the picture is %ux%u", c->width,
                         c->height);
    if (!finite_all(c->world_to_camera, 16) || !finite_all(center, 2))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "camera: a matrix element or the centre is not finite");
    if (!(c->fx > 0 && c->fx < INFINITY && c->fy > 0 && c->fy < INFINITY))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "camera: focal lengths %g, %g are not positive and finite", c->fx, c->fy);
    if (!isfinite(c->near_depth) || !(c->near_depth < c->far_depth) ||
        (!c->orthographic && !(c->near_depth > 0)))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "camera: near %g and far %g: 0 < near < far is needed, of an orthographic "
                         "one near < far",
                         c->near_depth, c->far_depth);
    return STP_OK;
}
