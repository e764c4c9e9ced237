/* Fitted scenes, and what their splats cover, by code of its own. */
#ifndef TESTS_PREPARE_FITTED_H
#define TESTS_PREPARE_FITTED_H

#include "clouds.h"

#include <stipple/fit.h>

#include "scene/phong.h"
#include "scene/scene.h"

static inline struct stp_scene *scene_of(const struct stp_env *env, const struct stp_points *points)
{
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(env, scene, points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(env, scene, NULL), STP_OK);
    return scene;
}

static inline struct stp_points points_of(const struct samples *s)
{
    return (struct stp_points){ .count = s->count,
                                .position = (const double(*)[3])s->position,
                                .normal = (const float(*)[3])s->normal };
}

static inline struct stp_scene *fitted_by(const struct stp_env *env, const struct samples *s,
                                          const struct stp_fit_params *params, struct stp_fit *fit)
{
    struct stp_points points = points_of(s);
    struct stp_scene *scene = scene_of(env, &points);
    assert_int_equal(stp_scene_fit(env, scene, params, fit), STP_OK);
    return scene;
}

static inline struct stp_scene *fitted(const struct samples *s, double tolerance,
                                       struct stp_fit *fit)
{
    struct stp_fit_params params = { .tolerance = tolerance };
    return fitted_by(NULL, s, &params, fit);
}

/* A sample in a splat's own coordinates. */
struct at_splat {
    double s, t, height, normal[3]; /* the field's, unit */
    bool covered;                   /* else there is nothing in it */
};

static inline double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline struct at_splat locate(const struct splats *splats, size_t i, const double p[3])
{
    struct stp_phong_splat disc;
    const struct stp_phong_splat *q = splats->phong ? &splats->phong[i] : &disc;
    double d[3], u[3], n[3], length, r = 1.01 * (double)splats->radius[i];
    struct at_splat at = { 0 };
    for (int k = 0; k < 3; k++) {
        d[k] = p[k] - splats->position[i][k];
        n[k] = (double)splats->normal[i][k];
    }
    at.height = dot3(d, n);
    if (dot3(d, d) - at.height * at.height > r * r) /* most are far off */
        return at;
    if (!splats->phong)
        disc = phong_of_disc(splats->normal[i], splats->radius[i]);
    for (int k = 0; k < 3; k++)
        u[k] = (double)q->u[k];
    double v[3] = { n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2],
                    n[0] * u[1] - n[1] * u[0] };
    at.s = dot3(d, u) / (double)q->radius[0];
    at.t = dot3(d, v) / (double)q->radius[1];
    unsigned kept = 0;
    for (unsigned c = 0; c < q->clips; c++)
        kept +=
            (double)q->clip[c][0] * at.s + (double)q->clip[c][1] * at.t + (double)q->clip[c][2] >=
            0;
    bool clipped = q->reflex ? kept == 0 : kept < q->clips;
    at.covered = at.s * at.s + at.t * at.t <= 1 && !clipped;
    for (int k = 0; k < 3; k++)
        at.normal[k] = n[k] + ((double)q->field[0] + (double)q->field[1] * at.s) * u[k] +
                       ((double)q->field[2] + (double)q->field[3] * at.t) * v[k];
    length = sqrt(dot3(at.normal, at.normal));
    for (int k = 0; k < 3; k++)
        at.normal[k] /= length;
    return at;
}

static inline bool shows(const struct at_splat *at, const double n[3], double away)
{
    return at->covered && fabs(at->height) <= away && dot3(at->normal, n) > 0;
}

/* Degrees between the i-th sample's normal and the mean, weighted by the kernel 1 - r^2, of the
 * fields of the splats that show it: cover it no more than `away` off their planes and look its
 * way. NaN: none does. */
static inline double angle_of_mean(const struct splats *splats, const struct samples *s, size_t i,
                                   double away)
{
    double mean[3] = { 0 };
    double n[3] = { (double)s->normal[i][0], (double)s->normal[i][1], (double)s->normal[i][2] };
    for (size_t j = 0; j < splats->count; j++) {
        struct at_splat at = locate(splats, j, s->position[i]);
        if (!shows(&at, n, away))
            continue;
        for (int k = 0; k < 3; k++)
            mean[k] += (1 - at.s * at.s - at.t * at.t) * at.normal[k];
    }
    double length = sqrt(dot3(mean, mean));
    return length > 0 ? acos(fmin(dot3(mean, n) / length, 1)) * 180 / PI : NAN;
}

/* Each sample lies within the tolerance of the plane of a splat that covers it and looks its way;
 * with `unsigned_normals`, whichever way. */
static inline void covers_all(const struct splats *splats, const struct samples *s,
                              double tolerance, bool unsigned_normals)
{
    for (size_t i = 0; i < s->count; i++) {
        bool found = false;
        double n[3] = { (double)s->normal[i][0], (double)s->normal[i][1], (double)s->normal[i][2] };
        for (size_t j = 0; j < splats->count && !found; j++) {
            double m[3] = { (double)splats->normal[j][0], (double)splats->normal[j][1],
                            (double)splats->normal[j][2] };
            struct at_splat at = locate(splats, j, s->position[i]);
            found =
                at.covered && fabs(at.height) <= tolerance && (unsigned_normals || dot3(m, n) > 0);
        }
        assert_true(found);
    }
}

#endif
