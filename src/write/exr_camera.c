#include "write/exr_camera.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

void exr_world_to_camera(const struct stp_camera *camera, const double origin[3], double m[16])
{
    const double *v = camera->world_to_camera;
    struct vec3 moved = m4_point(v, v3_load(origin));
    double translation[3] = { moved.x, moved.y, moved.z };
    for (int axis = 0; axis < 3; axis++) {
        double sign = axis == 2 ? -1 : 1;
        for (int row = 0; row < 3; row++)
            m[4 * row + axis] = sign * v[4 * axis + row];
        m[12 + axis] = sign * translation[axis];
    }
    m[3] = m[7] = m[11] = 0;
    m[15] = 1;
}

static void multiply(const double a[16], const double b[16], double product[16])
{
    for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++) {
            double sum = 0;
            for (int k = 0; k < 4; k++)
                sum += a[4 * row + k] * b[4 * k + column];
            product[4 * row + column] = sum;
        }
}

static void perspective(const struct stp_camera *c, double p[16])
{
    double range = isinf(c->far_depth) ? 1 : c->far_depth / (c->far_depth - c->near_depth);
    memset(p, 0, 16 * sizeof *p);
    p[0] = c->fx / c->width;
    p[5] = -c->fy / c->height;
    p[8] = c->cx / c->width;
    p[9] = c->cy / c->height;
    p[10] = range;
    p[11] = 1;
    p[14] = -c->near_depth * range;
}

static void orthographic(const struct stp_camera *c, double p[16])
{
    double range = isinf(c->far_depth) ? 1 : 1 / (c->far_depth - c->near_depth);
    memset(p, 0, 16 * sizeof *p);
    p[0] = c->fx / c->width;
    p[5] = -c->fy / c->height;
    p[10] = range;
    p[12] = c->cx / c->width;
    p[13] = c->cy / c->height;
    p[14] = -c->near_depth * range;
    p[15] = 1;
}

void exr_world_to_ndc(const struct stp_camera *camera, const double origin[3], double m[16])
{
    double view[16], projection[16];
    exr_world_to_camera(camera, origin, view);
    if (camera->orthographic)
        orthographic(camera, projection);
    else
        perspective(camera, projection);
    multiply(view, projection, m);
}

struct exr_screen exr_screen_window(const struct stp_camera *camera)
{
    return (struct exr_screen){
        .width = camera->width / camera->fx,
        .center = { (camera->width / 2.0 - camera->cx) / camera->fx,
                    (camera->cy - camera->height / 2.0) / camera->fy },
        .pixel_aspect = camera->fy / camera->fx,
    };
}
