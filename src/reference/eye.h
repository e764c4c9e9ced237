/* The camera of the reference: one frame, one kind of ray for both projections. */
#ifndef STP_REFERENCE_EYE_H
#define STP_REFERENCE_EYE_H

#include <stipple/view.h>

#include "base/vec.h"

struct eye {
    bool orthographic;
    double fx, fy, cx, cy;
    double near_depth, far_depth;
    double origin[3];
    double to_camera[16]; /* from positions relative to the origin */
};

/* Its point at eye depth t is start + t along. */
struct ray {
    struct vec3 start, along;
};

void eye_init(struct eye *eye, const struct stp_camera *camera, const double origin[3]);

/* World to camera frame, and back to the world relative to the origin. */
struct vec3 eye_point(const struct eye *eye, const double world[3]);
struct vec3 eye_direction(const struct eye *eye, struct vec3 world);
struct vec3 eye_point_to_world(const struct eye *eye, struct vec3 point);
struct vec3 eye_direction_to_world(const struct eye *eye, struct vec3 direction);

/* Through the picture position (px, py), y down. */
struct ray eye_ray(const struct eye *eye, double px, double py);

/* From the eye to a point of the camera frame, not unit; orthographic: along the axis. */
static inline struct vec3 eye_view(const struct eye *eye, struct vec3 point)
{
    return eye->orthographic ? v3(0, 0, -1) : point;
}

static inline struct vec3 ray_at(const struct ray *ray, double depth)
{
    return v3_add(ray->start, v3_scale(ray->along, depth));
}

#endif
