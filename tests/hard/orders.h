/* Volumes and surfaces composited in float64 in the orders that the lists of HM stand for. The
 * orders are found by sorting all splats anew: nothing is shared with the lists of src/prepare. */
#ifndef TEST_HARD_ORDERS_H
#define TEST_HARD_ORDERS_H

#include "drawn.h"
#include "hard.h"

/* Rays along +x, -x, +y, -y, +z, -z; by distance from the eye. */
#define ORDERS       7
#define ORDER_SORTED 6

struct orders {
    size_t pixels;
    double (*sum)[ORDERS][5]; /* premultiplied colour, alpha, depth by alpha */
    struct vec3 *ray;         /* directions in the world */
    struct vec3 forward;      /* the view's */
    bool *fragile;            /* a fragment appears or goes within 2e-4 pixels of the centre */
    double *slope;            /* of a surface, whose splats may be as steep as they like: what
                                 2e-5 pixels aside is other; of a volume 0 */
};
struct orders orders_make(const struct stp_scene *scene, const struct stp_camera *camera,
                          const struct stp_render_params *params);
void orders_release(struct orders *orders);

/* How far the picture is from what the merge has to give, at most, over the slope: of colours and
 * alpha as they are, of depth times alpha over the larger of 1 and itself. Where axes are equal to
 * 1e-5 any of them may be the dominant one: of a ray (clip), of the picture (single). */
double orders_error(const struct orders *orders, const struct stp_image *image,
                    enum stp_axis_merge merge, double h);

#endif
