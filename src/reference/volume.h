/* Volumes in exact order: every kernel whose visible part a pixel's ray meets, sorted along that
 * ray, composited in float64 (docs/axis.md, "The reference"). */
#ifndef STP_REFERENCE_VOLUME_H
#define STP_REFERENCE_VOLUME_H

#include "reference/planes.h"
#include "scene/volume.h"

#define VOLUME_TILE 16 /* pixels a side: a tile's fragments are held all at once */

/* A view of a volume; nothing in it changes while the picture is made. */
struct medium {
    const struct view *view;
    const struct volume *volume;
    struct vec3 axis[3]; /* the grid's, in the camera frame, over a kernel's deviation */
    struct vec3 half;    /* half the sides of the box around a kernel's reach, camera frame */
    double amplitude;    /* of the Gaussian */
    double least_alpha;  /* LEAST_ALPHA, but where a test asks what dropping costs */
    double (*shaded)[3]; /* a kernel: lit once, at its centre */
    double *tau; /* of ellipsoids: as the view weights them; NULL: of a grid, the kernels' own */
};

struct medium_fragment {
    double depth; /* eye depth of the greatest density on the visible part of the ray */
    double alpha;
    uint32_t kernel;
};

/* Fails for lack of memory only. */
enum stp_result medium_init(const struct stp_env *env, const struct view *view,
                            struct medium *medium);
void medium_release(struct medium *medium);

struct vec3 medium_centre(const struct medium *medium, uint32_t kernel); /* camera frame */
/* What the kernel around `centre` adds to the ray; false: nothing, or too little. */
bool medium_hit(const struct medium *medium, struct vec3 centre, double tau, const struct ray *ray,
                struct medium_fragment *fragment);
/* The same of a kernel of any shape. */
bool medium_hit_kernel(const struct medium *medium, uint32_t kernel, struct vec3 centre,
                       const struct ray *ray, struct medium_fragment *fragment);
/* Picture positions that hold every fragment: x0 x1 y0 y1. False: it has none. */
bool medium_bounds(const struct medium *medium, uint32_t kernel, struct vec3 centre,
                   double bounds[4]);

/* volume_bins.c: kernels by tile, ascending within each. */
struct medium_bins {
    uint32_t across, down;
    size_t *first; /* across * down + 1 */
    uint32_t *kernel;
};
enum stp_result medium_bins_build(const struct stp_env *env, const struct medium *medium,
                                  struct medium_bins *bins);
void medium_bins_release(struct medium_bins *bins);

/* The whole picture; planes are those of an empty picture. */
enum stp_result medium_render(const struct stp_env *env, const struct view *view,
                              const struct planes *planes, const struct stp_render_params *params,
                              double least_alpha);

#endif
