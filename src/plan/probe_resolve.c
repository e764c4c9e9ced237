/* A probe's pixels, resolved as the reference does: Eq. 1, or layer by layer. */
#include "plan/probe.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "reference/environment.h"

static const struct nearest none = { .depth = INFINITY };

static void take(struct nearest *nearest, const struct probe_fragment *f)
{
    if (f->depth < nearest->depth)
        *nearest = (struct nearest){ f->depth, f->splat, f->normal };
}

/* In floats, as in glsl/lib/terms.glsl: a half goes the same way. */
static double in_steps(double c, float steps)
{
    return (double)floorf((float)c * steps + 0.5f) / (double)steps;
}

static struct vec3 albedo_of(const struct view *view, uint32_t splat, float steps)
{
    struct vec3 c = splat_albedo(view, splat);
    if (steps == 0)
        return c;
    return v3(in_steps(c.x, steps), in_steps(c.y, steps), in_steps(c.z, steps));
}

static void sum(const struct view *view, const struct ray *ray, struct sums *sums,
                const struct probe_fragment *f, float color_steps)
{
    struct vec3 albedo = albedo_of(view, f->splat, color_steps);
    if (view->shade == STP_SHADE_SPLAT)
        sums->shaded =
            v3_add(sums->shaded,
                   v3_scale(splat_shade(view, f->splat, f->normal, ray, f->depth), f->weight));
    sums->weight += f->weight;
    sums->depth += f->weight * f->depth;
    sums->opacity += f->weight * splat_opacity(view, f->splat);
    sums->normal = v3_add(sums->normal, v3_scale(f->normal, f->weight));
    sums->albedo = v3_add(sums->albedo, v3_scale(albedo, f->weight));
    sums->count++;
}

/* ZP Eq. 1 over the kept fragments, and its light, computed where --shade says. */
static bool one_surface(const struct view *view, const struct ray *ray,
                        const struct probe_pixel *pixel, struct vec3 *color)
{
    struct nearest nearest = none;
    struct sums sums = { 0 };
    for (size_t i = 0; i < pixel->count; i++)
        if (pixel->fragment[i].kept)
            take(&nearest, &pixel->fragment[i]);
    if (nearest.depth == INFINITY)
        return false;
    double last = nearest.depth + splat_epsilon(view, nearest.id) + pixel->slack;
    for (size_t i = 0; i < pixel->count; i++) {
        const struct probe_fragment *f = &pixel->fragment[i];
        bool alone = view->shade == STP_SHADE_FLAT && f->splat != nearest.id;
        if (f->kept && !alone && !(f->depth > last))
            sum(view, ray, &sums, f, pixel->color_steps);
    }
    struct surface surface = surface_resolve(view, &nearest, &sums, ray);
    *color = surface_color(view, &surface, &sums);
    return true;
}

/* A ray through layers, as in reference/layers.c. */
struct passage {
    struct nearest next, opaque; /* of the layer after those done; of the opaque splats */
    struct surface first;        /* .layers counts those done */
    struct vec3 color, tint;
    double transmittance;
};

static void begin(const struct view *view, const struct probe_pixel *pixel, struct passage *p)
{
    *p = (struct passage){ .next = none, .opaque = none, .tint = { 1, 1, 1 }, .transmittance = 1 };
    for (size_t i = 0; i < pixel->count; i++) {
        const struct probe_fragment *f = &pixel->fragment[i];
        if (f->kept)
            take(splat_opacity(view, f->splat) == 1 ? &p->opaque : &p->next, f);
    }
}

/* The fragments of the layer that starts at `start`; finds where the next one does. */
static struct sums cut(const struct view *view, const struct ray *ray,
                       const struct probe_pixel *pixel, const struct nearest *start, bool solid,
                       struct passage *p)
{
    struct sums sums = { 0 };
    double last = start->depth + splat_epsilon(view, start->id) + pixel->slack;
    p->next = none;
    for (size_t i = 0; i < pixel->count; i++) {
        const struct probe_fragment *f = &pixel->fragment[i];
        bool ours = f->kept && (splat_opacity(view, f->splat) == 1) == solid;
        if (!ours || f->depth < start->depth || (!solid && f->depth >= p->opaque.depth))
            continue;
        if (f->depth <= last)
            sum(view, ray, &sums, f, pixel->color_steps);
        else if (!solid)
            take(&p->next, f);
    }
    return sums;
}

static void composite(const struct view *view, struct passage *p, const struct surface *s)
{
    uint32_t layers = p->first.layers + 1;
    if (layers == 1)
        p->first = *s;
    p->first.layers = layers;
    struct vec3 light = v3_product(surface_shade(view, s), p->tint);
    p->color = v3_add(p->color, v3_scale(light, p->transmittance * s->opacity));
    p->transmittance *= 1 - s->opacity;
    p->tint = surface_absorb(view, s, layers, p->tint);
}

static void pass_through(const struct view *view, const struct ray *ray,
                         const struct probe_pixel *pixel, struct passage *p)
{
    begin(view, pixel, p);
    while (p->first.layers < pixel->most_layers &&
           (isfinite(p->next.depth) || isfinite(p->opaque.depth))) {
        bool solid = !(p->next.depth < p->opaque.depth);
        struct nearest start = solid ? p->opaque : p->next;
        struct sums sums = cut(view, ray, pixel, &start, solid, p);
        struct surface surface = surface_resolve(view, &start, &sums, ray);
        composite(view, p, &surface);
        if (solid)
            p->opaque = p->next = none;
    }
}

/* What is behind the pixel shines through what its layers let pass. */
static struct vec3 over(const struct probe *probe, const struct ray *ray, struct vec3 color,
                        double through)
{
    const float *b = probe->background;
    if (through <= 0)
        return color;
    if (probe->environment_behind)
        return v3_add(color,
                      v3_scale(environment_light(&probe->view, v3_unit(ray->along), 0), through));
    return v3_add(color, v3_scale(v3_loadf(b), through * (double)b[3]));
}

unsigned probe_resolve(const struct probe *probe, size_t at, const struct probe_pixel *pixel,
                       double color[3])
{
    const struct view *view = &probe->view;
    const struct ray *ray = &probe->ray[at];
    struct passage p = { .transmittance = 1 };
    struct vec3 c = v3(0, 0, 0);
    if (!view->transparent && one_surface(view, ray, pixel, &c))
        p = (struct passage){ .first.layers = 1 };
    else if (view->transparent)
        pass_through(view, ray, pixel, &p), c = p.color;
    if (view->transparent && p.first.layers && surface_is_glass(view, &p.first)) {
        c = surface_glass(view, &p.first, c, v3_scale(p.tint, p.transmittance));
        p.transmittance = 0;
    }
    c = over(probe, ray, c, p.transmittance);
    memcpy(color, (double[3]){ c.x, c.y, c.z }, 3 * sizeof(double));
    return p.first.layers;
}

enum stp_result probe_truth(const struct stp_env *env, struct probe *probe)
{
    uint64_t layers = 0;
    probe->truth = mem_alloc(probe->pixels ? probe->pixels : 1, 3 * sizeof(double));
    if (!probe->truth)
        return log_no_memory(env, probe->pixels * 3 * sizeof(double), "the probe's truth");
    for (size_t i = 0; i < probe->pixels; i++) {
        const struct probe_pixel pixel = { &probe->fragment[probe->first[i]],
                                           probe->first[i + 1] - probe->first[i], UINT32_MAX, 0,
                                           0 };
        layers += probe_resolve(probe, i, &pixel, &probe->truth[3 * i]);
    }
    probe->layers = probe->pixels ? (double)layers / (double)probe->pixels : 0;
    return STP_OK;
}
