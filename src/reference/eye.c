#include "reference/eye.h"

#include <string.h>

void eye_init(struct eye *eye, const struct stp_camera *camera, const double origin[3])
{
    *eye = (struct eye){ .orthographic = camera->orthographic,
                         .fx = camera->fx,
                         .fy = camera->fy,
                         .cx = camera->cx,
                         .cy = camera->cy,
                         .near_depth = camera->near_depth,
                         .far_depth = camera->far_depth };
    memcpy(eye->origin, origin, sizeof eye->origin);
    memcpy(eye->to_camera, camera->world_to_camera, sizeof eye->to_camera);
    /* Composed once: at coordinates near 6e6 every splat then shares one rounding. */
    struct vec3 t = m4_point(camera->world_to_camera, v3_load(origin));
    eye->to_camera[3] = t.x;
    eye->to_camera[7] = t.y;
    eye->to_camera[11] = t.z;
}

struct vec3 eye_point(const struct eye *eye, const double world[3])
{
    return m4_point(eye->to_camera, v3_sub(v3_load(world), v3_load(eye->origin)));
}

struct vec3 eye_direction(const struct eye *eye, struct vec3 world)
{
    return m4_direction(eye->to_camera, world);
}

struct vec3 eye_direction_to_world(const struct eye *eye, struct vec3 d)
{
    const double *m = eye->to_camera; /* rigid: the transpose is the inverse */
    return v3(m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
              m[2] * d.x + m[6] * d.y + m[10] * d.z);
}

struct vec3 eye_point_to_world(const struct eye *eye, struct vec3 point)
{
    const double *m = eye->to_camera;
    return eye_direction_to_world(eye, v3_sub(point, v3(m[3], m[7], m[11])));
}

struct ray eye_ray(const struct eye *eye, double px, double py)
{
    double x = (px - eye->cx) / eye->fx, y = -(py - eye->cy) / eye->fy;
    if (eye->orthographic)
        return (struct ray){ v3(x, y, 0), v3(0, 0, -1) };
    return (struct ray){ v3(0, 0, 0), v3(x, y, -1) };
}
