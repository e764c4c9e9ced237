/* What Eq. 1 leaves of a sample's fragments, and its light. */
#ifndef STP_REFERENCE_SURFACE_H
#define STP_REFERENCE_SURFACE_H

#include "reference/disc.h"

/* The nearest fragment's splat, which names epsilon and material. */
struct nearest {
    double depth; /* INFINITY: none */
    uint32_t id;
    struct vec3 normal; /* camera frame, turned */
};

/* Weighted sums over the fragments within epsilon of the nearest. */
struct sums {
    double weight, depth, opacity;
    struct vec3 normal, albedo, shaded; /* shaded: where each fragment is lit by itself */
    uint32_t count;
};

struct surface {
    double depth, weight, opacity;
    struct vec3 normal, point; /* camera frame */
    struct vec3 albedo;
    uint32_t count, id;
    uint32_t layers; /* of the ray, this one the nearest */
};

double splat_epsilon(const struct view *view, uint32_t id);
struct vec3 splat_albedo(const struct view *view, uint32_t id);
double splat_opacity(const struct view *view, uint32_t id);
/* The light that one splat sends by itself. */
struct vec3 splat_shade(const struct view *view, uint32_t id, struct vec3 normal,
                        const struct ray *ray, double depth);

void nearest_take(struct nearest *nearest, uint32_t id, const struct disc *disc,
                  const struct fragment *fragment);
void sums_add(const struct view *view, struct sums *sums, uint32_t id, const struct disc *disc,
              const struct fragment *fragment, const struct ray *ray);
/* The surface's light: that of its normal, or the average of what its fragments send alone. */
struct vec3 surface_color(const struct view *view, const struct surface *surface,
                          const struct sums *sums);
struct surface surface_resolve(const struct view *view, const struct nearest *nearest,
                               const struct sums *sums, const struct ray *ray);

/* optics.c: what the environment adds to a surface that sends `own` light by itself. */
struct vec3 surface_mirror(const struct view *view, const struct surface *surface,
                           const struct stp_optics *o, struct vec3 own);

/* Whether this nearest layer of a ray is transparent and meets the environment. */
bool surface_is_glass(const struct view *view, const struct surface *first);
/* What such a layer does to light, with that many layers to see the environment through. */
struct glass {
    struct vec3 passed, mirrored; /* the share of what comes through; light that it mirrors */
    struct vec3 seen;             /* of the environment */
};
struct glass surface_interface(const struct view *view, const struct surface *first, double layers);
/* What the eye sees by such a layer: own, the layers' light, premultiplied; through, what they all
 * let pass. */
struct vec3 surface_glass(const struct view *view, const struct surface *first, struct vec3 own,
                          struct vec3 through);
/* `tint` behind the ray's layer number `layer` (from 1) as well. */
struct vec3 surface_absorb(const struct view *view, const struct surface *surface, uint32_t layer,
                           struct vec3 tint);

/* light.c: the shading model, linear. */
struct vec3 surface_shade(const struct view *view, const struct surface *surface);

#endif
