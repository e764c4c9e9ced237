/* What a splat shows, as its stored floats say. */
#ifndef STP_PREPARE_PHONG_FACE_H
#define STP_PREPARE_PHONG_FACE_H

#include <stdbool.h>

#include "base/vec.h"
#include "scene/splats.h"

/* c is relative to an origin. */
struct face {
    struct vec3 c, n, u, v;
    struct stp_phong_splat phong;
};

/* Eq. 1, and the height over the plane. */
struct on_face {
    double s, t, height;
};

static inline struct face face_of(const struct splats *splats, size_t at, const double origin[3])
{
    struct face f = { .c = v3_sub(v3_load(splats->position[at]), v3_load(origin)),
                      .n = v3_loadf(splats->normal[at]),
                      .u = v3_loadf(splats->phong[at].u),
                      .phong = splats->phong[at] };
    f.v = v3_cross(f.n, f.u);
    return f;
}

static inline struct on_face face_place(const struct face *f, struct vec3 p)
{
    struct vec3 d = v3_sub(p, f->c);
    return (struct on_face){ v3_dot(d, f->u) / (double)f->phong.radius[0],
                             v3_dot(d, f->v) / (double)f->phong.radius[1], v3_dot(d, f->n) };
}

/* Do its clip lines keep the place? */
static inline bool face_keeps(const struct face *f, struct on_face at)
{
    const struct stp_phong_splat *phong = &f->phong;
    unsigned kept = 0;
    for (unsigned i = 0; i < phong->clips; i++)
        kept += (double)phong->clip[i][0] * at.s + (double)phong->clip[i][1] * at.t +
                    (double)phong->clip[i][2] >=
                0;
    return phong->reflex ? kept > 0 : kept == phong->clips;
}

/* Eq. 2, unit; n where it vanishes. */
static inline struct vec3 face_normal(const struct face *f, struct on_face at)
{
    const float *field = f->phong.field;
    struct vec3 u = v3_scale(f->u, (double)field[0] + (double)field[1] * at.s);
    struct vec3 n =
        v3_add(v3_add(f->n, u), v3_scale(f->v, (double)field[2] + (double)field[3] * at.t));
    return v3_length(n) > 1e-6 ? v3_unit(n) : f->n;
}

#endif
