/* Elliptical splats with linear normal fields and clip lines: BSK 3 and 4. */
#include "reference/disc.h"

#define LEAST 1e-6 /* length of the field's vector below which the splat's normal stands in */

bool ellipse_setup(const struct view *view, size_t id, struct disc *disc)
{
    const struct stp_phong_splat *p = view->scene->splats.phong;
    struct ellipse *e = &disc->ellipse;
    *e = (struct ellipse){ .normal = disc->normal, .turned = 1 };
    if (!p)
        return false;
    p += id;
    e->u = v3_unit(eye_direction(&view->eye, v3_loadf(p->u)));
    if (v3_length(e->u) == 0) /* of a normal that is not known: a disc */
        return false;
    e->v = v3_cross(e->normal, e->u);
    for (int i = 0; i < 2; i++)
        e->radius[i] = p->radius[i];
    for (int i = 0; i < 4; i++)
        e->field[i] = view->shade == STP_SHADE_FLAT ? 0 : p->field[i];
    e->clips = p->clips;
    e->reflex = p->reflex;
    for (int i = 0; i < 6; i++)
        e->clip[i / 3][i % 3] = p->clip[i / 3][i % 3];
    return true;
}

/* N.(eye - q) with q = c + r0 s u + r1 t v is linear in (s, t) but for -f1 r0 s^2 - f3 r1 t^2. */
bool ellipse_faces(const struct ellipse *e, struct vec3 towards, bool orthographic)
{
    const double *f = e->field;
    double a = v3_dot(e->u, towards), b = v3_dot(e->v, towards);
    double r = orthographic ? 0 : e->radius[0], q = orthographic ? 0 : e->radius[1];
    double most = v3_dot(e->normal, towards) + f[0] * a + f[2] * b;
    most += hypot(f[1] * a - f[0] * r, f[3] * b - f[2] * q);
    return most + fmax(0, fmax(-f[1] * r, -f[3] * q)) > 0;
}

void ellipse_place(const struct ellipse *e, struct vec3 from_centre, struct fragment *fragment)
{
    fragment->s = v3_dot(from_centre, e->u) / e->radius[0];
    fragment->t = v3_dot(from_centre, e->v) / e->radius[1];
    fragment->rho2 = fragment->s * fragment->s + fragment->t * fragment->t;
}

bool ellipse_keeps(const struct ellipse *e, const struct fragment *fragment)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < e->clips; i++)
        kept += e->clip[i][0] * fragment->s + e->clip[i][1] * fragment->t + e->clip[i][2] >= 0;
    return e->reflex ? kept > 0 : kept == e->clips;
}

struct vec3 fragment_normal(const struct disc *disc, const struct fragment *fragment)
{
    const struct ellipse *e = &disc->ellipse;
    if (!disc->is_ellipse)
        return disc->normal;
    struct vec3 n = v3_add(e->normal, v3_scale(e->u, e->field[0] + e->field[1] * fragment->s));
    n = v3_add(n, v3_scale(e->v, e->field[2] + e->field[3] * fragment->t));
    return v3_length(n) >= LEAST ? v3_scale(v3_unit(n), e->turned) : disc->normal;
}
