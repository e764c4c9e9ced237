/* Interfaces of surfaces with the environment (docs/glass.md). */
#include "reference/environment.h"
#include "reference/surface.h"
#include "scene/optics.h"

/* Reflected share of unpolarised light at a dielectric: n is inside over outside. */
static double dielectric(double n, double cosine)
{
    double sine = sqrt(fmax(0, 1 - cosine * cosine)) / n;
    if (sine >= 1)
        return 1;
    double inside = sqrt(1 - sine * sine);
    double s = (cosine - n * inside) / (cosine + n * inside);
    double p = (n * cosine - inside) / (n * cosine + inside);
    return (s * s + p * p) / 2;
}

/* The shares of each channel that an interface reflects, and those that pass it. */
struct shares {
    double back[3], on[3];
};

/* `inside`: the eye looks at the interface from within. */
static struct shares shares_of(const struct stp_optics *o, double cosine, bool inside)
{
    struct shares s;
    double most = 0;
    for (int k = 0; k < 3; k++) {
        double face_on = (double)o->reflectance[k], n = (double)o->ior[k];
        s.back[k] = dielectric(inside ? 1 / n : n, cosine);
        s.on[k] = 1 - s.back[k];
        most = fmax(most, face_on);
    }
    if (most == 0)
        return s;
    for (int k = 0; k < 3; k++) {
        double face_on = (double)o->reflectance[k], grazing = pow(1 - cosine, 5);
        s.back[k] = face_on + (1 - face_on) * grazing;
        /* A mirror's colour leaves no other behind. */
        s.on[k] = 1 - (most + (1 - most) * grazing);
    }
    return s;
}

static struct vec3 divide(const struct shares *s, struct vec3 mirrored, struct vec3 behind)
{
    return v3(s->back[0] * mirrored.x + s->on[0] * behind.x,
              s->back[1] * mirrored.y + s->on[1] * behind.y,
              s->back[2] * mirrored.z + s->on[2] * behind.z);
}

struct vec3 surface_mirror(const struct view *view, const struct surface *surface,
                           const struct stp_optics *o, struct vec3 own)
{
    struct vec3 d = v3_unit(eye_view(&view->eye, surface->point)), n = surface->normal;
    double dot = v3_dot(d, n);
    struct vec3 r = v3_unit(v3_sub(d, v3_scale(n, 2 * dot)));
    struct shares shares = shares_of(o, fmin(fabs(dot), 1), false);
    return divide(&shares, environment_light(view, r, (double)o->roughness), own);
}

static const struct stp_optics *optics_of(const struct view *view, const struct surface *surface)
{
    const uint16_t *object = view->scene->splats.object;
    return &view->scene->objects[object ? object[surface->id] : 0].optics;
}

bool surface_is_glass(const struct view *view, const struct surface *first)
{
    return view->scene->environment.map.width && first->opacity < 1 &&
           optics_matter(optics_of(view, first));
}

/* ZP Eq. 12: sin theta_T = eta^l sin theta_I, at most 1: beyond that the ray leaves along the
 * surface. `facing` is the normal on the eye's side, eta outside over inside. */
static struct vec3 bend(struct vec3 d, struct vec3 facing, double eta, double layers)
{
    struct vec3 along = v3_add(d, v3_scale(facing, -v3_dot(d, facing)));
    double sine = v3_length(along);
    if (sine == 0)
        return d;
    double bent = fmin(pow(eta, layers) * sine, 1);
    return v3_add(v3_scale(along, bent / sine), v3_scale(facing, -sqrt(1 - bent * bent)));
}

struct glass surface_interface(const struct view *view, const struct surface *first, double layers)
{
    const struct stp_optics *o = optics_of(view, first);
    struct vec3 d = v3_unit(eye_view(&view->eye, first->point)), n = first->normal;
    double dot = v3_dot(d, n), roughness = (double)o->roughness;
    bool inside = dot > 0;
    struct vec3 facing = inside ? v3_scale(n, -1) : n, seen[3];
    struct vec3 mirror = environment_light(view, v3_sub(d, v3_scale(n, 2 * dot)), roughness);
    struct shares shares = shares_of(o, fmin(fabs(dot), 1), inside);
    for (int k = 0; k < 3; k++) {
        double eta = inside ? (double)o->ior[k] : 1 / (double)o->ior[k];
        seen[k] = environment_light(view, bend(d, facing, eta, layers), roughness);
    }
    return (struct glass){ v3(shares.on[0], shares.on[1], shares.on[2]),
                           v3_product(v3(shares.back[0], shares.back[1], shares.back[2]), mirror),
                           v3(seen[0].x, seen[1].y, seen[2].z) };
}

struct vec3 surface_glass(const struct view *view, const struct surface *first, struct vec3 own,
                          struct vec3 through)
{
    struct glass g = surface_interface(view, first, view->single_layer ? 1 : first->layers);
    struct vec3 behind = v3_add(own, v3_product(through, g.seen));
    return v3_add(v3_product(g.passed, behind), g.mirrored);
}

struct vec3 surface_absorb(const struct view *view, const struct surface *surface, uint32_t layer,
                           struct vec3 tint)
{
    const struct stp_optics *o = optics_of(view, surface);
    double t = (double)o->thickness;
    if (!view->scene->environment.map.width || (view->single_layer && layer > 1))
        return tint;
    return v3(tint.x * exp(-(double)o->absorption[0] * t),
              tint.y * exp(-(double)o->absorption[1] * t),
              tint.z * exp(-(double)o->absorption[2] * t));
}
