/* Prepared points to fewer, elliptical splats with linear normal fields: docs/phong.md. */
#ifndef STIPPLE_FIT_H
#define STIPPLE_FIT_H

#include <stipple/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How splats may replace points. */
struct stp_fit_params {
    double tolerance; /* scene units: the farthest that a point may lie from the plane of its splat;
                         0: every point stays a splat of its own */
    size_t count;     /* 0: `tolerance` counts; else the tolerance is found that leaves at most so
                         many splats, and `tolerance` is not looked at */
    double color;     /* the largest difference of a component within a splat; 0:
                         STP_DEFAULT_FIT_COLOR; splats carry the mean */
    bool flat;        /* constant normals instead of linear fields: what BSK compare with */
    bool alone;       /* each splat's field is fitted by itself, as the paper does; else all fields
                         together, for their mean to follow the points' normals where they overlap */
    bool smooth;      /* sharp edges are not looked for, and nothing is clipped */
};
#define STP_DEFAULT_FIT_COLOR 0.1

/* What came out. */
struct stp_fit {
    size_t points, splats;
    double tolerance; /* that was used */
    double deviation; /* of any point from the plane of the nearest splat that holds it */
    size_t single;    /* splats of one point */
    size_t clipped;   /* splats with clip lines */
    bool signs;       /* the points' normals agreed in sign; else the splats were turned outward */
    double milliseconds;
};

/* BSK 3: an optimised subset of elliptical splats that cover all points within the tolerance, each
 * with the least-squares plane, the minimum enclosing ellipse and the least-squares normal field of
 * the points that it covers. After stp_scene_prepare, before grouping; the splats take the points'
 * place. Deterministic. fit may be NULL. On failure the scene is as it was. */
STP_API enum stp_result stp_scene_fit(const struct stp_env *env, struct stp_scene *scene,
                                      const struct stp_fit_params *params, struct stp_fit *fit);

#ifdef __cplusplus
}
#endif
#endif
