/* Interfaces of surfaces with the environment (docs/glass.md). */
#include "reference/environment.h"
#include "reference/surface.h"

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

/* Channel k's share; `inside`: the eye looks at the interface from within. */
static double reflected(const struct stp_optics *o, int k, double cosine, bool inside)
{
    bool mirror = o->reflectance[0] > 0 || o->reflectance[1] > 0 || o->reflectance[2] > 0;
    double face_on = (double)o->reflectance[k], n = (double)o->ior[k];
    if (mirror)
        return face_on + (1 - face_on) * pow(1 - cosine, 5);
    return dielectric(inside ? 1 / n : n, cosine);
}

static double mix(double a, double b, double t)
{
    return a * (1 - t) + b * t;
}

struct vec3 surface_mirror(const struct view *view, const struct surface *surface,
                           const struct stp_optics *o, struct vec3 own)
{
    struct vec3 d = v3_unit(eye_view(&view->eye, surface->point)), n = surface->normal;
    double dot = v3_dot(d, n), cosine = fmin(fabs(dot), 1);
    struct vec3 r = v3_unit(v3_sub(d, v3_scale(n, 2 * dot)));
    struct vec3 light = environment_light(view, r, (double)o->roughness);
    return v3(mix(own.x, light.x, reflected(o, 0, cosine, false)),
              mix(own.y, light.y, reflected(o, 1, cosine, false)),
              mix(own.z, light.z, reflected(o, 2, cosine, false)));
}
