#include "prepare/phong_make.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "prepare/phong_outline.h"
#include "scene/phong.h"

/* What of a splat is stored as floats, read back: everything else is computed from that. */
static void splat_frame(const float normal[3], const float u[3], struct patch_frame *frame)
{
    frame->n = v3_loadf(normal);
    frame->u = v3_loadf(u);
    frame->v = v3_cross(frame->n, frame->u);
}

/* Never below x. */
static float round_up(double x)
{
    float f = (float)x;
    return (double)f < x ? nextafterf(f, INFINITY) : f;
}

/* From the plane's x and y to the ellipse's s and t, outwards by what rounding may move a line.
 * Lines that do not meet the ellipse are left. */
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
        phong->clip[phong->clips++][2] = round_up(c + FLT_EPSILON * (fabs(a) + fabs(b)));
    }
    phong->reflex = lines->reflex && phong->clips == 2;
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

void splat_make(const struct splat_maker *m, size_t at)
{
    const struct patch *p = &m->set->patch[at];
    const struct fit_cloud *cloud = m->cloud;
    struct splats *out = m->splats;
    struct stp_phong_splat phong = { 0 };
    struct patch_frame f = p->frame;
    struct outline o;
    bool at_edge = cloud->crease && cloud->crease_of[p->seed] != NO_SITE;
    if (p->count == 1 && cloud->first[p->seed + 1] - cloud->first[p->seed] == 1 && !at_edge) {
        splat_single(m, cloud->first[p->seed], cloud->site[p->seed].n, at);
        return;
    }
    inherit(m, cloud->first[p->seed], at);
    v3_storef(f.n, out->normal[at]);
    v3_storef(f.u, phong.u);
    splat_frame(out->normal[at], phong.u, &f);
    patch_outline(cloud, p, &f, m->tolerance, m->point, &o);
    struct vec3 c = v3_add(f.c, v3_add(v3_scale(f.u, o.center[0]), v3_scale(f.v, o.center[1])));
    out->position[at][0] = cloud->origin[0] + c.x;
    out->position[at][1] = cloud->origin[1] + c.y;
    out->position[at][2] = cloud->origin[2] + c.z;
    for (int i = 0; i < 2; i++)
        phong.radius[i] = round_up(o.radius[i] + o.gap);
    store_lines(&o.lines, o.center, &phong);
    fit_field(m, p, &f, o.center, &phong);
    out->radius[at] = fmaxf(phong.radius[0], phong.radius[1]);
    out->phong[at] = phong;
    if (out->color)
        mean_color(m, p, at);
}
