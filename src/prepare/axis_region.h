/* Where on the picture a walk has a weight: rays are linear in the pixel, so that it is the inside
 * of four straight lines. */
#ifndef STP_PREPARE_AXIS_REGION_H
#define STP_PREPARE_AXIS_REGION_H

#include "base/vec.h"
#include "prepare/axis_disc.h"
#include "prepare/axis_lists.h"
#include "prepare/range.h"

/* f(px, py) = x px + y py + c */
struct axis_line {
    double x, y, c;
};

/* A weight is where every line is above 0. */
struct axis_region {
    struct axis_line line[5];
    unsigned count;
};

/* Pixels [x0, x1] x [y0, y1], both included. */
struct axis_rectangle {
    int64_t x0, x1, y0, y1;
};

/* The picture's rays: world direction = x px + y py + c, by components. */
struct axis_rays {
    struct axis_line component[3];
};
struct axis_rays axis_rays(const struct stp_camera *camera);
struct vec3 axis_ray(const struct axis_rays *rays, double px, double py);

struct axis_region axis_region(const struct axis_rays *rays, const struct axis_lists *lists,
                               const struct axis_walk *walk);
/* False where no pixel of the rectangle can be in the region. */
bool axis_region_reaches(const struct axis_region *region, const struct axis_rectangle *rectangle);
bool axis_region_holds(const struct axis_region *region, double px, double py);

/* What a list is of. */
enum axis_shape {
    AXIS_VOXELS,     /* Gaussians of one shape, on a grid */
    AXIS_ELLIPSOIDS, /* of range images, each with its own */
    AXIS_DISCS,      /* surface splats: flat ones */
};
enum axis_shape axis_shape(const struct stp_scene *scene);
size_t axis_kernels(const struct stp_scene *scene);

/* What sees the kernels: the eye in the world, and their shape. */
struct axis_view {
    const struct stp_camera *camera;
    const struct stp_scene *scene;
    const struct volume *volume; /* NULL: discs */
    enum axis_shape shape;
    struct axis_look disc_look;
    struct axis_rays rays, starts; /* starts: of the rays, orthographic too */
    double half[3];                /* of the box around a kernel's reach, camera frame */
    double white[3][3];            /* world to where the kernel is the unit Gaussian, rows */
    double amplitude;
    double least_peak;      /* of a voxel of tau 1: no more than its greatest optical depth */
    double reach[3][3];     /* ellipsoid, disc: its axes' components in the camera frame, times the
                               reach */
    struct range_view look; /* ellipsoids: weighs them */
};
struct axis_view axis_view(const struct stp_scene *scene, const struct stp_camera *camera);

/* A kernel of any shape: `view` is the caller's, or of an ellipsoid or disc its own. */
struct axis_kernel {
    const struct axis_view *view;
    double centre[3]; /* world */
    struct axis_view own;
    struct axis_disc disc;
};
/* False: it has no fragment anywhere. */
bool axis_kernel(const struct axis_view *view, uint32_t index, struct axis_kernel *kernel);
void axis_centre(const struct axis_view *view, uint32_t index, double world[3]);
double axis_tau(const struct axis_view *view, uint32_t index); /* of a disc 0 */
/* Pixels of the picture whose centres lie within the kernel's box; false: none. */
bool axis_pixels(const struct axis_kernel *kernel, struct axis_rectangle *rectangle);
/* Has the kernel a fragment at that place of the picture? As docs/axis.md defines it. tau: of a
 * disc unused. */
bool axis_hits(const struct axis_kernel *kernel, double tau, double px, double py);

#endif
