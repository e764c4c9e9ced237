/* Small splat clouds for the tests of grouping. */
#ifndef TESTS_OVERLAP_CLOUDS_H
#define TESTS_OVERLAP_CLOUDS_H

#include "scene/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct dice {
    uint64_t state;
};

static inline uint64_t roll(struct dice *d)
{
    d->state ^= d->state << 13;
    d->state ^= d->state >> 7;
    d->state ^= d->state << 17;
    return d->state * 0x2545f4914f6cdd1dULL;
}

/* In [0, 1). */
static inline double uniform(struct dice *d)
{
    return (double)(roll(d) >> 11) * 0x1p-53;
}

static inline struct splats cloud_make(size_t count)
{
    struct splats s = { .count = count };
    s.position = calloc(count, sizeof *s.position);
    s.normal = calloc(count, sizeof *s.normal);
    s.radius = calloc(count, sizeof *s.radius);
    s.color = calloc(count, sizeof *s.color);
    s.opacity = calloc(count, sizeof *s.opacity);
    s.object = calloc(count, sizeof *s.object);
    for (size_t i = 0; i < count; i++) {
        s.radius[i] = 1;
        s.opacity[i] = 1;
    }
    return s;
}

static inline void cloud_free(struct splats *s)
{
    free(s->position);
    free(s->normal);
    free(s->radius);
    free(s->color);
    free(s->opacity);
    free(s->object);
    free(s->input);
    *s = (struct splats){ 0 };
}

static inline void random_normal(struct dice *d, float n[3])
{
    double z = 2 * uniform(d) - 1, a = 2 * M_PI * uniform(d), r = sqrt(1 - z * z);
    n[0] = (float)(r * cos(a));
    n[1] = (float)(r * sin(a));
    n[2] = (float)z;
}

enum cloud_kind {
    CLOUD_UNIFORM,
    CLOUD_RADII,      /* 1000:1, log-uniform */
    CLOUD_CLUSTERS,   /* three tight heaps and a thin rest */
    CLOUD_COINCIDENT, /* one place, different normals */
    CLOUD_LINE,
    CLOUD_LATTICE, /* distances exactly at the limit */
    CLOUD_FAR,     /* detail of 1e-3 at 6e6 */
    CLOUD_PLANE,   /* nearly coplanar, few colours, two objects */
    CLOUD_KINDS
};

static inline void place(enum cloud_kind kind, struct dice *d, struct splats *s, size_t i)
{
    double *p = s->position[i], side = cbrt((double)s->count) * 1.5;
    for (int a = 0; a < 3; a++)
        p[a] = side * uniform(d);
    if (kind == CLOUD_RADII)
        s->radius[i] = (float)(3e-3 * side * pow(1000, uniform(d)) / 10);
    if (kind == CLOUD_CLUSTERS && i % 4)
        for (int a = 0; a < 3; a++)
            p[a] = side * (double)(i % 4) / 4 + (uniform(d) - 0.5);
    if (kind == CLOUD_COINCIDENT)
        p[0] = p[1] = p[2] = 7;
    if (kind == CLOUD_LINE)
        p[1] = p[2] = p[0] * 0.5;
    if (kind == CLOUD_LATTICE)
        for (int a = 0; a < 3; a++)
            p[a] = floor(p[a]);
    if (kind == CLOUD_FAR) {
        s->radius[i] = 1e-3f;
        for (int a = 0; a < 3; a++)
            p[a] = 6e6 + 1e-3 * p[a];
    }
}

static inline struct splats cloud_random(enum cloud_kind kind, size_t count, uint64_t seed)
{
    struct dice d = { seed * 0x9e3779b97f4a7c15ULL + 1 };
    struct splats s = cloud_make(count);
    for (size_t i = 0; i < count; i++) {
        place(kind, &d, &s, i);
        random_normal(&d, s.normal[i]);
        if (i % 11 == 5)
            memset(s.normal[i], 0, sizeof s.normal[i]);
        if (kind == CLOUD_PLANE) {
            double tilt = 0.02 * uniform(&d);
            s.position[i][0] *= 2;
            s.position[i][1] *= 2;
            s.position[i][2] = 0.06 * uniform(&d);
            s.normal[i][0] = (float)sin(tilt);
            s.normal[i][1] = 0;
            s.normal[i][2] = i % 7 ? (float)cos(tilt) : -(float)cos(tilt);
            s.color[i][1] = (float)(roll(&d) % 2) * 0.5f;
            s.object[i] = roll(&d) % 5 == 0;
        }
    }
    return s;
}

#endif
