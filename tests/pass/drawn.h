/* What the axis method composites, as the reference's code knows it: a volume's kernels, a range
 * image's ellipsoids, or a surface's splats. Orders are the tests' own. */
#ifndef TEST_PASS_DRAWN_H
#define TEST_PASS_DRAWN_H

#include "device.h"
#include "prepare/axis_lists.h"
#include "reference/surface.h"
#include "volumes.h"

struct drawn {
    struct view view;
    size_t count;
    struct medium medium; /* of a surface unused */
    struct disc *disc;    /* of a surface; radius 0: never drawn */
    struct vec3 *light;
};

/* It must not move. params: of a surface, its floor, culling and lights. */
void drawn_make(const struct stp_scene *scene, const struct stp_camera *camera,
                const struct stp_render_params *params, struct drawn *d);
void drawn_release(struct drawn *d);

struct drawn_fragment {
    double alpha, own[5]; /* colour, 1, depth */
};
/* The splat's fragment on the ray of a place in the picture; false: none, or too faint. */
bool drawn_hit(const struct drawn *d, uint32_t id, double px, double py, struct drawn_fragment *f);
/* Places in the picture that hold every fragment: x0 x1 y0 y1; false: there is none. */
bool drawn_bounds(const struct drawn *d, uint32_t id, double bounds[4]);
/* One more fragment before what five sums hold: premultiplied colour, alpha, and depth by alpha. */
void drawn_over(const struct drawn_fragment *f, double sum[5]);
/* What is written of the sums, depth by the alpha that is written: opaque surfaces are divided by
 * what they cover (HM 5, step 3). */
void drawn_divide(const struct drawn *d, double sum[5]);

/* Eq. 1 on a pixel's ray: the lists, each composited from its far end, by their weights; divided.
 * False where a splat's fragment is there or not within `near` pixels: float32 may be wrong. */
bool drawn_merge(const struct drawn *d, const struct axis_lists *lists, uint32_t x, uint32_t y,
                 double near, double sum[5]);
/* R, G, B and A of a picture within `color` of the sums; depth, where alpha is above `seen`, within
 * `depth` of the larger of 1 and itself; it is finite where alpha is not 0. */
void drawn_expect(const double sum[5], const struct stp_image *image, uint32_t x, uint32_t y,
                  double color, double seen, double depth);

#endif
