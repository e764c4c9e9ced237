/* What a picture of one point a pixel can know (MKC 3.1): of the points that fall into a pixel the
 * nearest is left, and with it its disc. In double, by code that no renderer shares. */
#ifndef TEST_PASS_WINNERS_H
#define TEST_PASS_WINNERS_H

#include "device.h"

/* At each pixel's centre, row by row: the nearest disc of the points that are left, and as far as
 * it hides: its radius behind that. INFINITY: none covers it. Discs are smaller than they
 * are by what a texel's halves round: a thousandth of their radius and of a pixel. */
struct winners {
    uint32_t width, height;
    double *depth, *reach;
};
/* Without a screen-space floor, whatever the parameters say. Release with winners_release. */
struct winners winners_find(const struct stp_scene *scene, const struct stp_camera *camera,
                            const struct stp_render_params *params);
/* The same of all points, whether or not they won: all that a picture can show. */
struct winners winners_of_all(const struct stp_scene *scene, const struct stp_camera *camera,
                              const struct stp_render_params *params);
void winners_release(struct winners *winners);

#endif
