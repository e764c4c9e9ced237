/* Small analytic clouds for tests, and a random number generator that is the same everywhere. */
#ifndef TESTS_PREPARE_CLOUDS_H
#define TESTS_PREPARE_CLOUDS_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <stipple/scene.h>

#define PI 3.14159265358979323846

static inline uint64_t random_bits(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
static inline double random_unit(uint64_t *state)
{
    return (double)(random_bits(state) >> 11) * 0x1p-53;
}

/* A surface: position and outward unit normal of two parameters in [0, 1), even in area. */
typedef void (*surface_fn)(double u, double v, double p[3], double n[3]);

static inline void on_sphere(double u, double v, double p[3], double n[3])
{
    double z = 2 * u - 1, r = sqrt(1 - z * z);
    n[0] = r * cos(2 * PI * v);
    n[1] = r * sin(2 * PI * v);
    n[2] = z;
    for (int axis = 0; axis < 3; axis++)
        p[axis] = n[axis];
}
/* Radii 1 and 0.4; u is bent so that the area is even (a few Newton steps). */
static inline void on_torus(double u, double v, double p[3], double n[3])
{
    double a = 2 * PI * u, b = 2 * PI * v;
    for (int i = 0; i < 8; i++)
        a -= (a + 0.4 * sin(a) - 2 * PI * u) / (1 + 0.4 * cos(a));
    n[0] = cos(a) * cos(b);
    n[1] = cos(a) * sin(b);
    n[2] = sin(a);
    p[0] = (1 + 0.4 * cos(a)) * cos(b);
    p[1] = (1 + 0.4 * cos(a)) * sin(b);
    p[2] = 0.4 * sin(a);
}
static inline void on_plane(double u, double v, double p[3], double n[3])
{
    p[0] = u;
    p[1] = 0.25;
    p[2] = v;
    n[0] = n[2] = 0;
    n[1] = 1;
}
/* Two level squares, 0.2 apart. */
static inline void on_sheets(double u, double v, double p[3], double n[3])
{
    on_plane(u < 0.5 ? 2 * u : 2 * u - 1, v, p, n);
    p[1] = u < 0.5 ? 0 : 0.2;
}

struct samples {
    size_t count;
    double (*position)[3];
    float (*normal)[3];
};
static inline struct samples sample_surface(surface_fn surface, size_t count, uint64_t seed)
{
    struct samples s = { count, calloc(count, sizeof *s.position),
                         calloc(count, sizeof *s.normal) };
    for (size_t i = 0; i < count; i++) {
        double n[3], u = random_unit(&seed), v = random_unit(&seed);
        surface(u, v, s.position[i], n);
        for (int axis = 0; axis < 3; axis++)
            s.normal[i][axis] = (float)n[axis];
    }
    return s;
}
static inline void samples_release(struct samples *s)
{
    free(s->position);
    free(s->normal);
}

static inline void silent(void *user, enum stp_log_level level, const char *line)
{
    (void)level;
    if (user)
        strncat(user, line, 255);
}

#endif
