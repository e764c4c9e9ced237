#include "prepare/phong_make.h"

#include <math.h>
#include <string.h>

#include "prepare/phong_clip.h"
#include "prepare/phong_ellipse.h"
#include "scene/phong.h"

/* Of the mean spacing of a splat's sites: how far its axes reach beyond them, so that the surface
 * between the sites of neighbouring splats is covered too. Splats of few sites overlap less. */
#define GAP     0.5
#define GAP_FEW 0.7 /* over the root of the count */

void splat_frame(const float normal[3], const float u[3], struct patch_frame *frame)
{
    frame->n = v3_loadf(normal);
    frame->u = v3_loadf(u);
    frame->v = v3_cross(frame->n, frame->u);
}

static void store(float out[3], struct vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* Never below x. */
static float round_up(double x)
{
    float f = (float)x;
    return (double)f < x ? nextafterf(f, INFINITY) : f;
}

/* Where members are in the frame's plane, and the feet of those near an edge; returns how many. */
static size_t project(const struct splat_maker *m, const struct patch *p,
                      const struct patch_frame *f, const struct clip_lines *lines, double gap,
                      double (*point)[2])
{
    size_t count = p->count;
    for (uint32_t k = 0; k < p->count; k++) {
        struct vec3 d = v3_sub(v3_load(m->cloud->site[p->member[k]].p), f->c);
        point[k][0] = v3_dot(d, f->u);
        point[k][1] = v3_dot(d, f->v);
    }
    for (uint32_t k = 0; lines->count > 0 && k < p->count; k++)
        count += clip_feet(lines, point[k][0], point[k][1], 4 * gap, point + count);
    return count;
}

/* From the plane's x and y to the ellipse's s and t. Lines that do not meet the ellipse are left.
 */
static void store_lines(const struct clip_lines *lines, const double center[2],
                        struct stp_phong_splat *phong)
{
    for (unsigned i = 0; i < lines->count; i++) {
        const double *l = lines->line[i];
        double a = l[0] * (double)phong->radius[0], b = l[1] * (double)phong->radius[1];
        double c = l[0] * center[0] + l[1] * center[1] + l[2];
        bool meets = fabs(c) < hypot(a, b);
        if (!meets && lines->reflex && c > 0) { /* either may keep it, and this one keeps all */
            phong->clips = 0;
            return;
        }
        if (!meets)
            continue; /* keeps all where both must, or nothing where either may */
        phong->clip[phong->clips][0] = (float)a;
        phong->clip[phong->clips][1] = (float)b;
        phong->clip[phong->clips++][2] = (float)c;
    }
    phong->reflex = lines->reflex && phong->clips == 2;
}

/* Samples whose discs do not touch are no one surface: there a gap is no wider than their discs. */
static double mean_spacing(const struct fit_cloud *cloud, const struct patch *p)
{
    double sum = 0;
    for (uint32_t k = 0; k < p->count; k++) {
        uint32_t sample = cloud->first[p->member[k]];
        sum += fmin((double)cloud->site[p->member[k]].spacing,
                    2 * (double)cloud->samples->radius[sample]);
    }
    return sum / p->count;
}

/* Eq. 2-4: normals in the frame, with the third coordinate 1. They are tangents of the tilt: a
 * weight of its cosine to the fourth makes their squared differences those of angles, and keeps the
 * few that are tilted far from ruling the rest. */
static void fit_field(const struct splat_maker *m, const struct patch *p,
                      const struct patch_frame *f, const double center[2],
                      struct stp_phong_splat *phong)
{
    size_t count = 0;
    double field[4];
    for (uint32_t k = 0; k < p->count; k++) {
        struct vec3 n = site_normal(m->cloud, p->member[k], f->n);
        double z = v3_dot(n, f->n);
        if (z <= 0.1) /* 84 degrees: it tells the side no more */
            continue;
        m->sample[count++] =
            (struct field_sample){ (m->point[k][0] - center[0]) / (double)phong->radius[0],
                                   (m->point[k][1] - center[1]) / (double)phong->radius[1],
                                   v3_dot(n, f->u) / z, v3_dot(n, f->v) / z, z * z * z * z };
    }
    field_fit(m->sample, count, m->flat, field);
    for (int i = 0; i < 4; i++)
        phong->field[i] = (float)field[i];
}

static void mean_color(const struct splat_maker *m, const struct patch *p, size_t at)
{
    const struct splats *s = m->cloud->samples;
    double sum[3] = { 0 }, n = 0;
    for (uint32_t k = 0; k < p->count; k++)
        for (uint32_t i = m->cloud->first[p->member[k]]; i < m->cloud->first[p->member[k] + 1];
             i++) {
            n += 1;
            for (int c = 0; c < 3; c++)
                sum[c] += (double)s->color[i][c];
        }
    for (int c = 0; c < 3; c++)
        m->splats->color[at][c] = (float)(sum[c] / n);
}

/* What the splat takes over from one sample. */
static void inherit(const struct splat_maker *m, uint32_t sample, size_t at)
{
    const struct splats *s = m->cloud->samples;
    struct splats *out = m->splats;
    out->input[at] = s->input[sample];
    if (out->object)
        out->object[at] = s->object[sample];
    if (out->opacity)
        out->opacity[at] = s->opacity[sample];
    if (out->color)
        memcpy(out->color[at], s->color[sample], sizeof out->color[at]);
}

void splat_single(const struct splat_maker *m, uint32_t sample, const float n[3], size_t at)
{
    const struct splats *s = m->cloud->samples;
    memcpy(m->splats->position[at], s->position[sample], sizeof s->position[sample]);
    memcpy(m->splats->normal[at], n, sizeof m->splats->normal[at]);
    m->splats->radius[at] = s->radius[sample];
    m->splats->phong[at] = phong_of_disc(n, s->radius[sample]);
    inherit(m, sample, at);
}

/* The ellipse about the seed, of the shape that the patch grew in. */
static void grown_ellipse(const struct splat_maker *m, const struct patch *p,
                          const struct patch_frame *f, size_t count, double center[2],
                          double radius[2])
{
    struct vec3 d = v3_sub(v3_load(m->cloud->site[p->seed].p), f->c);
    double most = 0, ratio = sqrt(p->shape);
    center[0] = v3_dot(d, f->u);
    center[1] = v3_dot(d, f->v);
    for (size_t k = 0; k < count; k++)
        most = fmax(most, hypot((m->point[k][0] - center[0]) / ratio,
                                (m->point[k][1] - center[1]) * ratio));
    radius[0] = most * ratio * (1 + 1e-12);
    radius[1] = most / ratio * (1 + 1e-12);
}

/* The minimum enclosing ellipse; of a patch that edges cut off, the better of two, for the ends of
 * a strip between edges stick out of the one and the far side of a patch that grew from its border
 * out of the other: what the lines leave is to be least. */
static void fit_ellipse(const struct splat_maker *m, const struct patch *p,
                        const struct patch_frame *f, const struct clip_lines *lines, size_t count,
                        double gap, double center[2], double radius[2])
{
    double other[2], axes[2];
    ellipse_enclose((const double(*)[2])m->point, count, 0.1 * gap, center, radius);
    if (lines->count == 0)
        return;
    grown_ellipse(m, p, f, count, other, axes);
    if (clip_area(lines, other, axes) >= clip_area(lines, center, radius))
        return;
    memcpy(center, other, sizeof other);
    memcpy(radius, axes, sizeof axes);
}

void splat_make(const struct splat_maker *m, size_t at)
{
    const struct patch *p = &m->set->patch[at];
    const struct fit_cloud *cloud = m->cloud;
    struct splats *out = m->splats;
    struct stp_phong_splat phong = { 0 };
    struct patch_frame f = p->frame;
    struct clip_lines lines;
    double center[2], radius[2], share = GAP + GAP_FEW / sqrt(p->count);
    double gap = share * mean_spacing(cloud, p);
    if (p->count == 1 && cloud->first[p->seed + 1] - cloud->first[p->seed] == 1) {
        splat_single(m, cloud->first[p->seed], cloud->site[p->seed].n, at);
        return;
    }
    gap = gap > 0 ? gap : share * (double)cloud->samples->radius[cloud->first[p->seed]];
    inherit(m, cloud->first[p->seed], at);
    store(out->normal[at], f.n);
    store(phong.u, f.u);
    splat_frame(out->normal[at], phong.u, &f);
    patch_clips(cloud, p, &f, m->tolerance, &lines);
    size_t count = project(m, p, &f, &lines, gap, m->point);
    fit_ellipse(m, p, &f, &lines, count, gap, center, radius);
    struct vec3 c = v3_add(f.c, v3_add(v3_scale(f.u, center[0]), v3_scale(f.v, center[1])));
    out->position[at][0] = cloud->origin[0] + c.x;
    out->position[at][1] = cloud->origin[1] + c.y;
    out->position[at][2] = cloud->origin[2] + c.z;
    for (int i = 0; i < 2; i++)
        phong.radius[i] = round_up(radius[i] + gap);
    store_lines(&lines, center, &phong);
    fit_field(m, p, &f, center, &phong);
    out->radius[at] = fmaxf(phong.radius[0], phong.radius[1]);
    out->phong[at] = phong;
    if (out->color)
        mean_color(m, p, at);
}
