#include "scene/phong.h"

#include <limits.h>
#include <string.h>

#include "base/vec.h"

#define FLOATS    15   /* u, radius, field and clip: what comes before the bytes */
#define UNIT      5e-7 /* within this, a float vector is unit, and two are at right angles */
#define LEAST_SIN 1e-3 /* of the angle between u and the normal */
#define MOST_BITS 50   /* squares of what is below 2^50 stay within floats */

_Static_assert(offsetof(struct stp_phong_splat, clips) == FLOATS * sizeof(float), "no padding");

bool phong_is_disc(const struct stp_phong_splat *phong)
{
    return phong->u[0] == 0 && phong->u[1] == 0 && phong->u[2] == 0;
}

struct stp_phong_splat phong_of_disc(const float normal[3], float radius)
{
    struct stp_phong_splat made = { .radius = { radius, radius } };
    struct vec3 n = v3_loadf(normal);
    struct vec3 across = fabs(n.x) < 0.7 ? v3(1, 0, 0) : v3(0, 1, 0);
    v3_storef(v3_unit(v3_cross(n, across)), made.u);
    return made;
}

bool phong_is_plain(const struct stp_phong_splat *phong)
{
    bool constant = true;
    for (int i = 0; i < 4; i++)
        constant = constant && phong->field[i] == 0;
    return phong->clips == 0 && constant && phong->radius[0] == phong->radius[1];
}

static bool all_finite(const float *value, unsigned count)
{
    bool finite = true;
    for (unsigned i = 0; i < count; i++)
        finite = finite && isfinite(value[i]);
    return finite;
}

static bool straighten(float u[3], const float normal[3])
{
    struct vec3 n = v3_loadf(normal), given = v3_loadf(u);
    double length = v3_length(given), along = v3_dot(given, n);
    if (fabs(length - 1) < UNIT && fabs(along) < UNIT)
        return true;
    struct vec3 across = v3_sub(given, v3_scale(n, along));
    if (!(v3_length(across) > LEAST_SIN * length))
        return false;
    v3_storef(v3_unit(across), u);
    return true;
}

/* The least power of two above all of them. */
static int bits_of(const float *value, unsigned count)
{
    int most = INT_MIN;
    for (unsigned i = 0; i < count; i++) {
        int bits = INT_MIN;
        if (value[i] != 0)
            frexpf(value[i], &bits);
        most = bits > most ? bits : most;
    }
    return most;
}

static void shift(float *value, unsigned count, int bits)
{
    for (unsigned i = 0; i < count; i++)
        value[i] = ldexpf(value[i], bits);
}

/* A line says the same at any scale. A field of 2^50 leaves nothing of n in a float, so that a
 * larger one has the same directions. */
static void scale_extremes(struct stp_phong_splat *phong)
{
    int bits = bits_of(phong->field, 4);
    if (bits > MOST_BITS)
        shift(phong->field, 4, MOST_BITS - bits);
    for (unsigned line = 0; line < phong->clips; line++) {
        bits = bits_of(phong->clip[line], 3);
        if (bits > MOST_BITS || (bits < -MOST_BITS && bits != INT_MIN))
            shift(phong->clip[line], 3, -bits);
    }
}

bool phong_clean(struct stp_phong_splat *phong, const float normal[3])
{
    if (phong->clips > 2 || (normal[0] == 0 && normal[1] == 0 && normal[2] == 0))
        return false;
    for (unsigned line = phong->clips; line < 2; line++)
        memset(phong->clip[line], 0, sizeof phong->clip[line]);
    phong->reflex = phong->clips == 2 && phong->reflex;
    if (!all_finite(phong->u, 3) || !all_finite(phong->radius, 2) || !(phong->radius[0] > 0) ||
        !(phong->radius[1] > 0) || !all_finite(phong->field, 4) || !all_finite(phong->clip[0], 6))
        return false;
    scale_extremes(phong);
    return straighten(phong->u, normal);
}

void phong_transform(struct stp_phong_splat *phong, const double m[16], double scale)
{
    v3_storef(v3_scale(m4_direction(m, v3_loadf(phong->u)), 1 / scale), phong->u);
    for (int i = 0; i < 2; i++)
        phong->radius[i] = (float)(phong->radius[i] * scale);
}

/* Both lines or either, with room for the rounding of a point that lies on one. */
static bool keeps(const struct stp_phong_splat *p, double s, double t)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < p->clips; i++) {
        const float *l = p->clip[i];
        double slack = 1e-9 * (fabs((double)l[0]) + fabs((double)l[1]) + fabs((double)l[2]));
        kept += l[0] * s + l[1] * t + l[2] >= -slack;
    }
    return p->reflex ? kept > 0 : kept == p->clips;
}

static void try_point(const struct stp_phong_splat *p, double a, double b, double s, double t,
                      double *most)
{
    if (s * s + t * t <= 1 + 1e-9 && keeps(p, s, t))
        *most = fmax(*most, a * s + b * t);
}

/* A linear function is largest where the outline faces it, or at a corner: where lines end on the
 * outline, or meet. */
double phong_support(const struct stp_phong_splat *p, double a, double b)
{
    double most = -INFINITY, length = hypot(a, b);
    try_point(p, a, b, length > 0 ? a / length : 0, length > 0 ? b / length : 0, &most);
    for (unsigned i = 0; i < p->clips; i++) {
        double x = p->clip[i][0], y = p->clip[i][1], c = p->clip[i][2], square = x * x + y * y;
        double half = sqrt(fmax(0, square - c * c)) / square;
        try_point(p, a, b, -c * x / square - y * half, -c * y / square + x * half, &most);
        try_point(p, a, b, -c * x / square + y * half, -c * y / square - x * half, &most);
    }
    if (p->clips == 2) {
        const float *k = p->clip[0], *l = p->clip[1];
        double d = (double)k[0] * l[1] - (double)k[1] * l[0];
        try_point(p, a, b, ((double)k[1] * l[2] - (double)k[2] * l[1]) / d,
                  ((double)k[2] * l[0] - (double)k[0] * l[2]) / d, &most);
    }
    return most;
}

bool phong_equal(const struct stp_phong_splat *a, const struct stp_phong_splat *b)
{
    return memcmp(a, b, FLOATS * sizeof(float)) == 0 && a->clips == b->clips &&
           a->reflex == b->reflex;
}

void phong_word(const struct stp_phong_splat *phong, unsigned word, uint32_t half[2])
{
    const char *at = (const char *)phong + word * 2 * sizeof *half;
    memcpy(half, at, word + 1 < PHONG_WORDS ? 2 * sizeof *half : sizeof *half);
    if (word + 1 == PHONG_WORDS)
        half[1] = phong->clips | (uint32_t)phong->reflex << 8;
}
