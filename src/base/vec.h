/* Double-precision vectors for the edges: files, cameras, the reference. */
#ifndef STP_BASE_VEC_H
#define STP_BASE_VEC_H

#include <math.h>

struct vec3 {
    double x, y, z;
};

static inline struct vec3 v3(double x, double y, double z)
{
    return (struct vec3){ x, y, z };
}
static inline struct vec3 v3_load(const double p[3])
{
    return v3(p[0], p[1], p[2]);
}
static inline struct vec3 v3_loadf(const float p[3])
{
    return v3(p[0], p[1], p[2]);
}
static inline void v3_store(struct vec3 v, double out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}
static inline void v3_storef(struct vec3 v, float out[3])
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}
static inline struct vec3 v3_add(struct vec3 a, struct vec3 b)
{
    return v3(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline struct vec3 v3_sub(struct vec3 a, struct vec3 b)
{
    return v3(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline struct vec3 v3_scale(struct vec3 a, double s)
{
    return v3(a.x * s, a.y * s, a.z * s);
}
static inline struct vec3 v3_product(struct vec3 a, struct vec3 b)
{
    return v3(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline double v3_dot(struct vec3 a, struct vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct vec3 v3_cross(struct vec3 a, struct vec3 b)
{
    return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double v3_length(struct vec3 a)
{
    return sqrt(v3_dot(a, a));
}
/* The zero vector stays zero. */
static inline struct vec3 v3_unit(struct vec3 a)
{
    double l = v3_length(a);
    return l > 0 ? v3_scale(a, 1 / l) : a;
}
/* Row-major 4x4 times a point, and its rotation part times a direction. */
static inline struct vec3 m4_point(const double m[16], struct vec3 p)
{
    return v3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
              m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
              m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}
static inline struct vec3 m4_direction(const double m[16], struct vec3 d)
{
    return v3(m[0] * d.x + m[1] * d.y + m[2] * d.z, m[4] * d.x + m[5] * d.y + m[6] * d.z,
              m[8] * d.x + m[9] * d.y + m[10] * d.z);
}

#endif
