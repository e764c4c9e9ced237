/* march.h's volumes as a device may draw them: merges of orders along axes, in floats. */
#ifndef TEST_PASS_MARCHED_H
#define TEST_PASS_MARCHED_H

#include "march.h"

/* The kernels in the order along an axis, or, axis 3, of their distance from the eye. */
static inline void march_order(struct march_ray *r, bool orthographic, unsigned axis)
{
    for (size_t i = 0; i < r->count; i++) {
        double squared = 0, ahead = 0;
        for (int a = 0; a < 3; a++) {
            double d = r->found[i].place[a] - r->from[a];
            squared += d * d;
            ahead += d * r->along[a];
        }
        double apart = orthographic ? ahead : squared;
        r->found[i].key =
            axis < 3 ? r->found[i].place[axis] * (r->along[axis] < 0 ? -1 : 1) : apart;
    }
}

static inline unsigned march_dominant(const double v[3])
{
    unsigned most = 0;
    for (unsigned a = 1; a < 3; a++)
        most = fabs(v[a]) > fabs(v[most]) ? a : most;
    return most;
}

/* How far off the ray 32-bit floats (u: half a unit in the last place of 1) may put a kernel's
 * centre, at most. Of the world's place, the matrix and their products a unit each, two of their
 * sums and one more with the translation, which has one itself: 6 and 2. Of a ray's direction
 * three, its product with the depth one; that product is the centre's own place, but for what the
 * kernel reaches. */
static inline double march_place_error(const struct march_ray *r, const struct stp_camera *camera,
                                       const struct march_kernel *k)
{
    const double u = ldexp(1, -24), reach = 3 * 0.55 * r->coarsest;
    double slope = camera->orthographic ? 0 : sqrt(1 / (r->depth * r->depth) - 1), off[3];
    for (int row = 2; row >= 0; row--) {
        const double *m = camera->world_to_camera + 4 * row;
        double at = m[3], terms = 0;
        for (int a = 0; a < 3; a++) {
            at += m[a] * k->place[a];
            terms += fabs(m[a] * k->place[a]);
        }
        off[row] = u * (6 * terms + 2 * fabs(m[3]));
        if (row < 2)
            off[row] += slope * off[2] + u * (4 * (fabs(at) + reach) + reach);
    }
    return hypot(off[0], off[1]);
}

/* Relative, of an optical depth: logarithms and powers as Vulkan has them, 2^-21 or three units of
 * the former's result, 3 + 2 |x| units of the latter's. By compute they are of the whole exponent
 * of 2; by the rasteriser of tau's, and of exp(-m^2 / 2) with ten units for what it is times. */
static inline double march_power_error(const struct march_kernel *k)
{
    const double u = ldexp(1, -24), amplitude = 1 / (pow(2 * M_PI, 1.5) * pow(0.55, 3));
    double tau = fabs(log2(k->tau_a / amplitude)), whole = fabs(log2(march_depth(k) / M_LN2));
    double e = 0.5 * k->m2 / M_LN2, scale = whole + e + tau;
    double log_tau = fmax(ldexp(1, -21), 6 * u * tau);
    double logs = log_tau + fmax(ldexp(1, -21), 6 * u * scale) + u * (scale + tau + whole);
    double compute = M_LN2 * logs + (3 + 2 * whole) * 2 * u;
    double raster = M_LN2 * log_tau + (3 + 2 * tau + 3 + k->m2 + 10) * 2 * u;
    return fmax(compute, raster);
}

/* What floats may make of a kernel's optical depth and then of its opacity, at most. A centre that
 * is off the ray by `place` changes m by place / sigma; m^2 / 2 itself is known to 12 u m^2 times
 * how long a kernel is for its width. Both decide within MARCH_RIM what the cut leaves out. */
static inline double march_float_error(const struct march_ray *r, const struct stp_camera *camera,
                                       const struct march_kernel *k)
{
    const double u = ldexp(1, -24);
    double exponent = sqrt(k->m2) * march_place_error(r, camera, k) / (0.55 * r->finest) +
                      12 * u * k->m2 * r->coarsest / r->finest;
    assert_true(2 * exponent <= MARCH_RIM);
    double relative = exponent + march_power_error(k);
    double x = march_depth(k);
    bool thin = x < 0.0155; /* by a series, within 1e-7 of itself */
    return x * relative * exp(-x) + (thin ? 3e-7 * x : (3 + 2 * x / M_LN2) * 2 * u * exp(-x) + u);
}

/* Of kernels in the order of their keys, composited in floats: what colours and alpha are off by.
 * An opacity that is off changes its own share of a colour and the light of all behind it. */
static inline void march_floats(const struct march_ray *r, const struct stp_camera *camera,
                                double off[2])
{
    const double u = ldexp(1, -24);
    double left = 1, off_left = 0, color = 0; /* off_left: relative to what is left */
    off[0] = off[1] = 0;
    for (size_t i = 0; i < r->count; i++) {
        double kept = exp(-march_depth(&r->found[i])), share = left * (1 - kept);
        double error = march_float_error(r, camera, &r->found[i]);
        color += share;
        off[0] += left * error + share * (off_left + 2 * u) + u * color;
        off_left += error / kept + 2 * u;
        left *= kept;
    }
    off[1] = left * expm1(off_left) + 4 * u;
    off[0] += 4 * u;
}

/* The light that comes through, whatever the order. */
static inline double march_left(const struct march_ray *r)
{
    double depth = 0;
    for (size_t i = 0; i < r->count; i++)
        depth += march_depth(&r->found[i]);
    return exp(-depth);
}

/* march_exchanges and march_floats of a merge, h = 0.85: of each order as much as HM Eq. 1 takes of
 * it, its share. What the cut may add or leave out changes alpha only by what comes through all
 * else. */
static inline void march_merge(struct march_ray *r, const struct stp_camera *camera,
                               enum stp_axis_merge merge, double most[4], double off[2],
                               double share[4])
{
    const double *m = camera->world_to_camera, forward[3] = { -m[8], -m[9], -m[10] };
    double weight[4] = { 0 }, total = 0;
    double size = fabs(r->along[march_dominant(r->along)]);
    if (merge == STP_AXIS_SORT)
        weight[3] = 1;
    else if (merge != STP_AXIS_BLEND)
        weight[march_dominant(merge == STP_AXIS_CLIP ? r->along : forward)] = 1;
    for (unsigned a = 0; a < 3 && merge == STP_AXIS_BLEND; a++)
        weight[a] = pow(fmax(0, (fabs(r->along[a]) / size - 0.85) / 0.15), 2);
    memset(most, 0, 4 * sizeof *most);
    memset(off, 0, 2 * sizeof *off);
    for (unsigned a = 0; a < 4; a++) {
        double one[4], floats[2];
        if (weight[a] == 0)
            continue;
        march_order(r, camera->orthographic, a);
        march_exchanges(r->found, r->count, r->depth, one);
        march_floats(r, camera, floats);
        for (int n = 0; n < 4; n++)
            most[n] += weight[a] * one[n];
        for (int n = 0; n < 2; n++)
            off[n] += weight[a] * floats[n];
        total += weight[a];
    }
    for (int n = 0; n < 4; n++) {
        most[n] /= total;
        share[n] = weight[n] / total;
    }
    off[0] = off[0] / total + r->rim;
    off[1] = off[1] / total + march_left(r) * r->rim;
}

#endif
