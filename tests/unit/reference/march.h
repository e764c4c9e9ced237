/* A volume by code of its own, from the definitions of docs/axis.md alone: rays are marched through
 * the sum of its Gaussians, emitting and absorbing; and their Gaussians are composited one by one,
 * sorted along each ray. Nothing of the library but its vectors and cameras is used. */
#ifndef TEST_REFERENCE_MARCH_H
#define TEST_REFERENCE_MARCH_H

#include "volumes.h"

#define MARCH_SIDE_MOST 24
#define MARCH_RIM       5e-4 /* of m^2; tests/pass/marched.h: floats know it to that */

struct march {
    uint32_t dims[3];
    double spacing[3], origin[3];
    float value[MARCH_SIDE_MOST * MARCH_SIDE_MOST * MARCH_SIDE_MOST];
};

/* What two points of a transfer function make of a value from 0 to 1. */
static const double march_low[4] = { 1, 0.1, 0.5, 0.03 }, march_high[4] = { 0, 1, 0.4, 0.15 };

static inline struct transfer_function march_function(void)
{
    struct transfer_function f = { .count = 2, .point = { { .value = 0 }, { .value = 1 } } };
    for (int n = 0; n < 3; n++) {
        f.point[0].color[n] = (float)march_low[n];
        f.point[1].color[n] = (float)march_high[n];
    }
    f.point[0].opacity = (float)march_low[3];
    f.point[1].opacity = (float)march_high[3];
    return f;
}

/* Slow waves, about 0. */
static inline void march_fill(struct march *m, const uint32_t dims[3], const double spacing[3])
{
    size_t i = 0;
    for (int a = 0; a < 3; a++) {
        m->dims[a] = dims[a];
        m->spacing[a] = spacing[a];
        m->origin[a] = -0.5 * (dims[a] - 1) * spacing[a];
    }
    for (uint32_t z = 0; z < dims[2]; z++)
        for (uint32_t y = 0; y < dims[1]; y++)
            for (uint32_t x = 0; x < dims[0]; x++)
                m->value[i++] = (float)(0.5 + 0.16 * (sin(0.31 * x) + cos(0.27 * y + 1) +
                                                      sin(0.4 * z * (spacing[2] > 2 ? 2 : 1))));
}

static inline struct stp_scene *march_scene(const struct march *m)
{
    struct transfer_function function = march_function();
    struct stp_volume volume = { .value = m->value };
    for (int a = 0; a < 3; a++) {
        volume.dims[a] = m->dims[a];
        volume.spacing[a] = m->spacing[a];
        volume.origin[a] = m->origin[a];
    }
    return volume_scene(&volume, &function);
}

/* One Gaussian on a ray of unit speed: tau a exp(-(m2 + b (t - at)^2) / 2). */
struct march_kernel {
    double tau_a, m2, b, at, color[3];
    double place[3]; /* of its centre, in the world */
    double key;      /* of an order: the least is the nearest; of equal ones the first voxel is */
    size_t voxel;
};

/* Start and unit direction of a pixel's ray; *depth: eye depth a unit of it. */
static inline void march_aim(const struct stp_camera *c, double px, double py, double from[3],
                             double along[3], double *depth)
{
    const double *m = c->world_to_camera;
    double x = (px - c->cx) / c->fx, y = -(py - c->cy) / c->fy, length = 1;
    double at[3] = { c->orthographic ? x : 0, c->orthographic ? y : 0, 0 };
    double d[3] = { c->orthographic ? 0 : x, c->orthographic ? 0 : y, -1 };
    length = sqrt(d[0] * d[0] + d[1] * d[1] + 1);
    for (int a = 0; a < 3; a++) {
        from[a] = along[a] = 0;
        for (int row = 0; row < 3; row++) {
            from[a] += m[4 * row + a] * (at[row] - m[4 * row + 3]);
            along[a] += m[4 * row + a] * d[row] / length;
        }
    }
    *depth = 1 / length;
}

/* Optical depth of the whole ray. */
static inline double march_depth(const struct march_kernel *k)
{
    return k->tau_a * exp(-0.5 * k->m2) * sqrt(2 * M_PI / k->b);
}

/* Those whose least deviation from the ray is at most 3. *rim: optical depth of those for which
 * floats may decide that otherwise. */
static inline size_t march_find(const struct march *m, const double from[3], const double along[3],
                                struct march_kernel *found, double *rim)
{
    const double sigma = 0.55;
    double amplitude = 1 / (pow(2 * M_PI, 1.5) * pow(sigma, 3) * (1 - exp(-4.5))),
           finest = INFINITY;
    size_t count = 0, i = 0;
    for (int a = 0; a < 3; a++)
        finest = fmin(finest, m->spacing[a]);
    for (uint32_t z = 0; z < m->dims[2]; z++)
        for (uint32_t y = 0; y < m->dims[1]; y++)
            for (uint32_t x = 0; x < m->dims[0]; x++, i++) {
                const uint32_t at[3] = { x, y, z };
                double b = 0, e = 0, ee = 0, v = (double)m->value[i];
                struct march_kernel k;
                for (int a = 0; a < 3; a++) {
                    double s = sigma * m->spacing[a], u = along[a] / s;
                    double d = (from[a] - m->origin[a] - at[a] * m->spacing[a]) / s;
                    b += u * u;
                    e += u * d;
                    ee += d * d;
                }
                k.b = b;
                k.at = -e / b;
                k.m2 = ee - e * e / b;
                k.tau_a = -log(1 - (march_low[3] + v * (march_high[3] - march_low[3]))) / finest *
                          amplitude;
                for (int n = 0; n < 3; n++) {
                    k.color[n] = march_low[n] + v * (march_high[n] - march_low[n]);
                    k.place[n] = m->origin[n] + at[n] * m->spacing[n];
                }
                k.voxel = i;
                k.key = k.at;
                *rim += fabs(k.m2 - 9) <= MARCH_RIM ? march_depth(&k) : 0;
                if (k.m2 <= 9)
                    found[count++] = k;
            }
    return count;
}

static inline int march_nearer(const void *a, const void *b)
{
    const struct march_kernel *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->voxel > y->voxel) - (x->voxel < y->voxel);
}

/* sum: premultiplied colour, alpha, and depth by alpha. Emission and absorption of their sum, by
 * the midpoint rule, which knows smooth integrands of nothing but Gaussians to all digits. */
static inline void march_through(const struct march_kernel *k, size_t count, double depth,
                                 double sum[5])
{
    double first = INFINITY, last = -INFINITY, widest = 0, left = 1;
    memset(sum, 0, 5 * sizeof *sum);
    for (size_t i = 0; i < count; i++) {
        double reach = 6 / sqrt(k[i].b);
        first = fmin(first, k[i].at - reach);
        last = fmax(last, k[i].at + reach);
        widest = fmax(widest, k[i].b);
    }
    double step = 0.1 / sqrt(widest);
    for (double t = first + 0.5 * step; count > 0 && t < last; t += step) {
        double density = 0, glow[3] = { 0 };
        for (size_t i = 0; i < count; i++) {
            double own =
                k[i].tau_a * exp(-0.5 * (k[i].m2 + k[i].b * (t - k[i].at) * (t - k[i].at)));
            density += own;
            for (int n = 0; n < 3; n++)
                glow[n] += own * k[i].color[n];
        }
        if (density == 0)
            continue;
        double taken = left * -expm1(-density * step);
        for (int n = 0; n < 3; n++)
            sum[n] += taken * glow[n] / density;
        sum[3] += taken;
        sum[4] += taken * t * depth;
        left -= taken;
    }
}

/* A ray cut into cells of half a deviation, and what of a kernel's layers lies before each. All
 * kernels of a ray have one deviation. */
struct march_cells {
    double first, width, sigma;
    size_t count;
    double *before;        /* of kernel i and cell g at i * count + g: the share of i's layers */
    double *ahead;         /* of a cell: optical depth of what lies before it for certain */
    double *light, *apart; /* of a pair's exchange in a cell: light left, and that times how far */
};

static inline struct march_cells march_cut(const struct march_kernel *k, size_t count)
{
    struct march_cells c = { .sigma = 1 / sqrt(k[0].b), .first = INFINITY };
    double last = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        c.first = fmin(c.first, k[i].at - 7 * c.sigma); /* beyond are 2e-12 */
        last = fmax(last, k[i].at + 7 * c.sigma);
    }
    c.width = 0.5 * c.sigma;
    c.count = (size_t)((last - c.first) / c.width) + 2;
    c.before = calloc((count + 3) * c.count, sizeof *c.before);
    assert_non_null(c.before);
    c.ahead = c.before + count * c.count;
    c.light = c.ahead + c.count;
    c.apart = c.light + c.count;
    for (size_t i = 0; i < count; i++)
        for (size_t g = 0; g < c.count; g++) {
            double u = (c.first + (double)g * c.width - k[i].at) / c.sigma;
            c.before[i * c.count + g] = u > 7 ? 1 : u < -7 ? 0 : 0.5 * erfc(-u / M_SQRT2);
        }
    return c;
}

/* Of kernel i, the nearer one of a pair in the kernels' order. */
static inline void march_light(struct march_cells *c, const struct march_kernel *k, size_t i)
{
    double x = march_depth(&k[i]);
    for (size_t g = 0; g < c->count; g++) {
        double u = (c->first + (double)g * c->width - k[i].at) / c->sigma;
        double before = c->before[i * c->count + g];
        c->ahead[g] += x * before;
        double left = exp(-c->ahead[g]);
        c->light[g] = left * (1 - before);
        c->apart[g] = left * c->sigma * (exp(-0.5 * u * u) / sqrt(2 * M_PI) - u * (1 - before));
    }
}

/* What kernels one by one, in the order of their keys, may be off the medium at most: three
 * colours, and depth by alpha. The medium is thin layers, each of one kernel, in the order of their
 * depths; the kernels are the same layers in another order. To exchange two neighbouring layers of
 * optical depths x and y changes a colour by T x y times the difference of theirs, T the light that
 * is left there; and it takes one exchange of each pair that stands the other way round, no other.
 * So what is before both layers in both orders is before them when they are exchanged: for a layer
 * of i at t, one of j at t' < t, and i before j, the layers before t' of i and of all kernels
 * before it. T is at most what these leave: taken, with the share of i's layers beyond t' and how
 * far they are, at the beginning of the cell of t', since all three decrease. A kernel's own
 * layers, taken to be where it is greatest, are half of what it takes to reverse them,
 * x^2 / 4 E|t - t'|. */
static inline void march_exchanges(struct march_kernel *k, size_t count, double depth,
                                   double most[4])
{
    memset(most, 0, 4 * sizeof *most);
    if (count == 0)
        return;
    qsort(k, count, sizeof *k, march_nearer);
    struct march_cells c = march_cut(k, count);
    for (size_t i = 0; i < count; i++) {
        double x = march_depth(&k[i]);
        most[3] += x * x / 2 / sqrt(M_PI * k[i].b) * depth;
        march_light(&c, k, i);
        for (size_t j = i + 1; j < count; j++) {
            if (k[j].at - k[i].at > 14 * c.sigma)
                continue;
            const double *before = c.before + j * c.count;
            double pair = x * march_depth(&k[j]), share = 0, apart = 0;
            size_t begin = (size_t)((k[j].at - 7 * c.sigma - c.first) / c.width);
            for (size_t g = begin; g + 1 < c.count && g < begin + 30; g++) {
                share += (before[g + 1] - before[g]) * c.light[g];
                apart += (before[g + 1] - before[g]) * c.apart[g];
            }
            for (int n = 0; n < 3; n++)
                most[n] += pair * share * fabs(k[i].color[n] - k[j].color[n]);
            most[3] += pair * apart * depth;
        }
    }
    free(c.before);
}

/* One by one, the nearest first. */
static inline void march_sorted(struct march_kernel *k, size_t count, double depth, double sum[5])
{
    double left = 1;
    memset(sum, 0, 5 * sizeof *sum);
    qsort(k, count, sizeof *k, march_nearer);
    for (size_t i = 0; i < count; i++) {
        double taken = left * -expm1(-march_depth(&k[i]));
        for (int n = 0; n < 3; n++)
            sum[n] += taken * k[i].color[n];
        sum[3] += taken;
        sum[4] += taken * k[i].at * depth;
        left -= taken;
    }
}

/* A pixel's ray and what it meets. */
struct march_ray {
    double from[3], along[3], depth;
    double rim, finest, coarsest; /* finest, coarsest: spacings */
    size_t count;
    struct march_kernel found[MARCH_SIDE_MOST * MARCH_SIDE_MOST * MARCH_SIDE_MOST];
};

static inline void march_pixel(const struct march *m, const struct stp_camera *camera, uint32_t x,
                               uint32_t y, struct march_ray *r)
{
    march_aim(camera, x + 0.5, y + 0.5, r->from, r->along, &r->depth);
    r->rim = 0;
    r->finest = fmin(fmin(m->spacing[0], m->spacing[1]), m->spacing[2]);
    r->coarsest = fmax(fmax(m->spacing[0], m->spacing[1]), m->spacing[2]);
    r->count = march_find(m, r->from, r->along, r->found, &r->rim);
}

/* Views from outside, some by perspective: spacing 1 : 1 : 1, then 1 : 1 : 10. */
#define MARCH_VIEWS 6
static inline struct stp_camera march_view(struct march *m, int index, uint32_t width,
                                           uint32_t height)
{
    static const struct vec3 towards[] = { { 0.2137, 0.0911, 1 },
                                           { 1, 0.8231, 0.9107 },
                                           { -0.7119, 1, 0.0533 } };
    bool flat = index % 2, tall = index >= MARCH_VIEWS / 2;
    struct stp_camera camera = flat ? flat_camera(width, height, height / 26.0)
                                    : plain_camera(width, height, 2.2 * height);
    march_fill(m, tall ? (uint32_t[]){ 22, 20, 3 } : (uint32_t[]){ 16, 15, 17 },
               tall ? (double[]){ 1, 1, 10 } : (double[]){ 1, 1, 1 });
    look_at(&camera, v3_scale(v3_unit(towards[index % 3]), 70), v3(0, 0, 0));
    return camera;
}

#endif
