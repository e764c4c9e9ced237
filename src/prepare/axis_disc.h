/* A surface splat as axis lists see it: the truncated Gaussian exp(-2 rho^2) on its disc or ellipse
 * (docs/axis.md, "A surface's splat"), where its fragments are. In double. */
#ifndef STP_PREPARE_AXIS_DISC_H
#define STP_PREPARE_AXIS_DISC_H

#include "prepare/axis_lists.h"

/* Camera frame: x right, y up, looking down -z. */
struct axis_disc {
    const struct stp_camera *camera;
    struct vec3 centre, normal, axis[2]; /* unit */
    double radius[2], opacity;
    const struct stp_phong_splat *clipped; /* NULL: no clip lines */
    bool floored;                          /* drawn by its ellipse on the screen */
    double at[2];                          /* then: the centre's place on the picture, */
    double map[2][2];                      /* pixels from there to (s, t), */
    double reach[2];                       /* how far the outline is, */
    double slope[2];                       /* and what a pixel adds to the depth */
};

/* Of splat `id`; False: it has no fragment in any picture of this view. */
bool axis_disc_make(const struct stp_scene *scene, const struct stp_camera *camera,
                    const struct axis_look *look, size_t id, struct axis_disc *disc);
/* Has it a fragment at that place of the picture? */
bool axis_disc_hits(const struct axis_disc *disc, double px, double py);

#endif
