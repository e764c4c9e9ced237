/* What float arithmetic adds to a method's error. Roundings are too small to be seen in a sample:
 * one moves a colour by 1e-7, and puts one pixel in a million on the other side of an outline or of
 * an epsilon's end. Both grow with the rounding, the first in size, the second in number. So
 * fragments are moved by many times what float may be off, and as small a part of the growth of the
 * error is expected: by more where fewer of the picture's pixels are seen; where all are, by so
 * little that only those pixels change sides that are near enough to. */
#include "plan/probe.h"

#include <math.h>

#include "base/mix.h"

#define AMPLIFY 16.0    /* where all parts of the picture are seen */
#define MOST    1024.0  /* beyond, growth would no longer be proportional */
#define UNIT    0x1p-24 /* half a float's last bit */
#define GRAZING 0.01    /* the least cosine: such discs are thinner than a pixel */
/* Of a depth, as large as it is: two roundings, of the centre's and of the sum. Evenly to both
 * sides this is as much in the mean as they are at most. */
#define DEPTHS (4.0 / 3)
/* Of what is measured on the splat's plane, over the cosine: its normal is rotated; two products
 * and a quotient of each follow. */
#define PLANE   16
#define NORMAL  4
#define CERTAIN 3 /* standard deviations of how many pixels change sides */
#define SELDOM  0.01
#define MANY    100 /* a count of so many is even about its mean */

/* Evenly in [-1, 1]. */
static double toss(uint32_t *state)
{
    *state += 0x9e3779b9u;
    return mix_bits(*state) / 2147483647.5 - 1;
}

double probe_amplify(const struct probe_sample *sample, unsigned parts)
{
    return sample->alone ? fmin(AMPLIFY * parts, MOST) : AMPLIFY;
}

/* In the picture, whichever part of it the probe is. */
static uint32_t place_of(const struct probe *probe, uint32_t pixel)
{
    const uint32_t side = PROBE_CELL, *corner = probe->corner[pixel / (side * side)];
    uint32_t x = corner[0] + pixel % side, y = corner[1] + pixel / side % side;
    return y * probe->view.width + x;
}

/* False: the disc misses the pixel. */
static bool move(const struct probe *probe, struct probe_fragment *f)
{
    const struct view *view = &probe->view;
    struct vec3 along = v3_unit(probe->ray[f->pixel].along);
    double slant = fmax(fabs(v3_dot(f->normal, along)), GRAZING), step = probe->amplify * UNIT;
    double radius = (double)view->scene->splats.radius[f->splat];
    uint32_t state = mix_bits(mix_bits(f->splat + 0x9e3779b9u) + place_of(probe, f->pixel));
    f->depth += step * (DEPTHS * fabs(f->depth) + PLANE * radius / slant) * toss(&state);
    f->rho2 = fabs(f->rho2 * (1 + step * PLANE / slant * toss(&state)));
    f->weight = view->kernel == STP_KERNEL_GAUSS ? exp(-2 * f->rho2) : fmax(0, 1 - f->rho2);
    f->normal.x += step * NORMAL * toss(&state);
    f->normal.y += step * NORMAL * toss(&state);
    f->normal.z += step * NORMAL * toss(&state);
    return f->rho2 <= 1;
}

size_t probe_perturb(const struct probe *probe, struct probe_fragment *fragment, size_t count)
{
    size_t left = 0;
    for (size_t i = 0; i < count; i++)
        if (move(probe, &fragment[i]))
            fragment[left++] = fragment[i];
    return left;
}

/* Of N pixels, so few change sides that chance decides how many: of independent ones with a change
 * d each, the variance of the mean is at most the sum of p d^2, over N^2. */
double probe_rounding(const struct probe_tally *t)
{
    if (!(t->n > 0) || !(t->cells > 0))
        return 0;
    double pixels = t->n * t->all_cells / t->cells;
    return fmax(t->growth, 0) / t->n + CERTAIN * sqrt(t->growth2 / (t->n * pixels));
}

/* The least number that as many independent rare events exceed more seldom than that. */
static double most_of(double expected)
{
    if (expected > MANY)
        return expected + CERTAIN * sqrt(expected);
    double exactly = exp(-expected), more = 1 - exactly, most = 0;
    while (more > SELDOM) {
        exactly *= expected / ++most;
        more -= exactly;
    }
    return most;
}

/* A pixel that changes sides takes one colour of the picture for another, or what is behind. */
double probe_flips(const struct probe_tally *t)
{
    if (!(t->tossed > 0) || !(t->cells < t->all_cells))
        return 0;
    double pixels = t->n * t->all_cells / t->cells;
    double most = most_of(PROBE_UNSEEN * (pixels - t->n) / t->tossed);
    return most * (t->bright[0] + t->bright[1] + t->bright[2]) / (3 * pixels);
}
