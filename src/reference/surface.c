/* ZP Eq. 1 at one sample (docs/numerics.md, "Opaque pixel"). */
#include "reference/surface.h"

#define LEAST 1e-6 /* of the sum of weights, and of the length of the sum of normals */

static const struct scene_object *object_of(const struct view *view, uint32_t id)
{
    const uint16_t *object = view->scene->splats.object;
    return &view->scene->objects[object ? object[id] : 0];
}

double splat_epsilon(const struct view *view, uint32_t id)
{
    return view->epsilon > 0 ? view->epsilon : object_of(view, id)->epsilon;
}

struct vec3 splat_albedo(const struct view *view, uint32_t id)
{
    const struct splats *splats = &view->scene->splats;
    return v3_loadf(splats->color ? splats->color[id] : object_of(view, id)->material.albedo);
}

double splat_opacity(const struct view *view, uint32_t id)
{
    const float *opacity = view->scene->splats.opacity;
    return opacity ? opacity[id] : 1;
}

static double kernel(const struct view *view, double rho2)
{
    return view->kernel == STP_KERNEL_GAUSS ? exp(-2 * rho2) : 1 - rho2;
}

/* Ties go to the splat that comes first: ids arrive in ascending order. */
void nearest_take(struct nearest *nearest, uint32_t id, const struct disc *disc,
                  const struct fragment *fragment)
{
    if (fragment->depth < nearest->depth)
        *nearest = (struct nearest){ fragment->depth, id, fragment_normal(disc, fragment) };
}

struct vec3 splat_shade(const struct view *view, uint32_t id, struct vec3 normal,
                        const struct ray *ray, double depth)
{
    struct surface s = { .depth = depth,
                         .opacity = 1,
                         .normal = normal,
                         .point = ray_at(ray, depth),
                         .albedo = splat_albedo(view, id),
                         .id = id };
    return surface_shade(view, &s);
}

void sums_add(const struct view *view, struct sums *sums, uint32_t id, const struct disc *disc,
              const struct fragment *fragment, const struct ray *ray)
{
    double weight = view->shade == STP_SHADE_FLAT ? 1 : kernel(view, fragment->rho2);
    struct vec3 normal = fragment_normal(disc, fragment);
    sums->weight += weight;
    sums->depth += weight * fragment->depth;
    sums->opacity += weight * splat_opacity(view, id);
    sums->normal = v3_add(sums->normal, v3_scale(normal, weight));
    sums->albedo = v3_add(sums->albedo, v3_scale(splat_albedo(view, id), weight));
    if (view->shade == STP_SHADE_SPLAT)
        sums->shaded = v3_add(
            sums->shaded, v3_scale(splat_shade(view, id, normal, ray, fragment->depth), weight));
    sums->count++;
}

struct surface surface_resolve(const struct view *view, const struct nearest *nearest,
                               const struct sums *sums, const struct ray *ray)
{
    struct surface s = {
        .weight = sums->weight, .count = sums->count, .id = nearest->id, .layers = 1
    };
    bool weighs = sums->weight >= LEAST;
    s.opacity = weighs ? sums->opacity / sums->weight : splat_opacity(view, nearest->id);
    s.depth = weighs ? sums->depth / sums->weight : nearest->depth;
    if (weighs && v3_length(sums->normal) >= LEAST) {
        s.normal = v3_unit(sums->normal);
        s.albedo = v3_scale(sums->albedo, 1 / sums->weight);
    } else {
        s.normal = nearest->normal;
        s.albedo = splat_albedo(view, nearest->id);
    }
    s.point = ray_at(ray, s.depth);
    return s;
}

struct vec3 surface_color(const struct view *view, const struct surface *surface,
                          const struct sums *sums)
{
    if (view->shade != STP_SHADE_SPLAT || !(sums->weight >= LEAST))
        return surface_shade(view, surface);
    return v3_scale(sums->shaded, 1 / sums->weight);
}
