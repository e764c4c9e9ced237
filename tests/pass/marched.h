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

/* What 32-bit floats (u: half a unit in the last place of 1) may make of a kernel's optical depth
 * and then of its opacity, at most. Its centre is a sum of products, six roundings, and a ray's
 * direction d four, so it is off the ray by no more than `place`, which is m place / sigma of its
 * depth; m^2 / 2 itself is known to 12 u m^2 times how long a kernel is for its width; logarithms
 * and powers of 2 as Vulkan has them: 2^-21 for each of the two, 3 + 2 |x| units of up to 14. */
static inline double march_float_error(const struct march_ray *r, const struct stp_camera *camera,
                                       const struct march_kernel *k)
{
    const double u = ldexp(1, -24), *c = camera->world_to_camera;
    double size =
        sqrt(k->place[0] * k->place[0] + k->place[1] * k->place[1] + k->place[2] * k->place[2]);
    double aside = size + hypot(c[3], c[7]), deep = size + fabs(c[11]), m = sqrt(k->m2);
    double slope = camera->orthographic ? 0 : sqrt(1 / (r->depth * r->depth) - 1);
    double place = M_SQRT2 * u * (12 * aside + 10 * slope * deep);
    double relative = m * place / (0.55 * r->finest) + 12 * u * k->m2 * r->coarsest / r->finest +
                      M_LN2 * 2 * ldexp(1, -21) + 2 * 14 * u + (3 + 2 * 14) * 2 * u;
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

/* march_exchanges and march_floats of a merge, h = 0.85: of each order as much as HM Eq. 1 takes of
 * it. */
static inline void march_merge(struct march_ray *r, const struct stp_camera *camera,
                               enum stp_axis_merge merge, double most[4], double off[2])
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
    for (int n = 0; n < 4; n++)
        most[n] /= total;
    for (int n = 0; n < 2; n++)
        off[n] = off[n] / total + r->rim;
}

#endif
