#include "reference/disc.h"

/* Rounding is bounded by far less than these: relative to the distance, and in pixels. */
#define SLACK_RADIUS 1e-9
#define SLACK_PIXELS 1e-6

/* Picture interval of all points with x in [lo, hi] and eye depth in [near, far], near > 0. */
static void axis_bound(const struct eye *eye, double focal, double centre, double lo, double hi,
                       double near, double far, double *min, double *max)
{
    if (!eye->orthographic) {
        lo /= lo < 0 ? near : far;
        hi /= hi > 0 ? near : far;
    }
    lo = centre + focal * lo;
    hi = centre + focal * hi;
    *min = lo - SLACK_PIXELS - SLACK_RADIUS * fabs(lo);
    *max = hi + SLACK_PIXELS + SLACK_RADIUS * fabs(hi);
}

/* The box around the disc's sphere, cut at near and far: holds across the eye plane too. */
static bool sphere_bound(const struct eye *eye, struct disc *disc)
{
    struct vec3 p = disc->centre;
    double r = disc->radius + SLACK_RADIUS * (disc->radius + v3_length(p));
    double near = fmax(-p.z - r, eye->near_depth), far = fmin(-p.z + r, eye->far_depth);
    if (!(near <= far))
        return false;
    axis_bound(eye, eye->fx, eye->cx, p.x - r, p.x + r, near, far, &disc->x_min, &disc->x_max);
    axis_bound(eye, eye->fy, eye->cy, -p.y - r, -p.y + r, near, far, &disc->y_min, &disc->y_max);
    return true;
}

static void floored_bound(struct disc *disc, double reach)
{
    double pad = reach * (1 + SLACK_RADIUS) + SLACK_PIXELS;
    disc->x_min = disc->floored.px - pad;
    disc->x_max = disc->floored.px + pad;
    disc->y_min = disc->floored.py - pad;
    disc->y_max = disc->floored.py + pad;
}

/* False when culled. Turns the normal to the eye. */
static bool orient(const struct view *view, struct vec3 eye_to_centre, struct disc *disc)
{
    if (v3_dot(disc->normal, disc->normal) == 0)
        disc->normal = v3_unit(v3_scale(eye_to_centre, -1));
    struct vec3 towards = v3_scale(eye_to_centre, -1);
    double facing = v3_dot(disc->normal, towards);
    if (view->cull_back && !(facing > 0) &&
        !(disc->is_ellipse && ellipse_faces(&disc->ellipse, towards, view->eye.orthographic)))
        return false;
    if (view->two_sided && facing < 0) {
        disc->normal = v3_scale(disc->normal, -1);
        disc->ellipse.turned = -1;
    }
    return true;
}

bool disc_setup(const struct view *view, size_t id, struct disc *disc)
{
    const struct splats *splats = &view->scene->splats;
    const struct eye *eye = &view->eye;
    disc->centre = eye_point(eye, splats->position[id]);
    disc->normal = v3_unit(eye_direction(eye, v3_loadf(splats->normal[id])));
    disc->radius = splats->radius[id];
    if (splats->opacity && splats->opacity[id] == 0)
        return false;
    disc->is_ellipse = ellipse_setup(view, id, disc);
    if (!(disc->radius > 0) || !orient(view, eye_view(eye, disc->centre), disc))
        return false;
    double reach = 0;
    disc->is_floored = view->min_splat > 0 && -disc->centre.z >= eye->near_depth &&
                       floor_ellipse(eye, disc, view->min_splat, &disc->floored, &reach);
    if (!sphere_bound(eye, disc))
        return false;
    if (disc->is_floored)
        floored_bound(disc, reach);
    return true;
}

static bool hit_floored(const struct disc *disc, double px, double py, struct fragment *fragment)
{
    const struct floored *f = &disc->floored;
    double dx = px - f->px, dy = py - f->py, z = -disc->centre.z;
    fragment->rho2 = f->a * dx * dx + 2 * f->b * dx * dy + f->c * dy * dy;
    fragment->depth = fmin(fmax(z + f->zx * dx + f->zy * dy, z - disc->radius), z + disc->radius);
    fragment->s = f->s[0] * dx + f->s[1] * dy;
    fragment->t = f->t[0] * dx + f->t[1] * dy;
    return fragment->rho2 <= 1;
}

/* BSK Eq. 6: the plane at the ray, then the distance within the plane. */
static bool hit_disc(const struct disc *disc, const struct ray *ray, struct fragment *fragment)
{
    double depth =
        v3_dot(disc->normal, v3_sub(disc->centre, ray->start)) / v3_dot(disc->normal, ray->along);
    struct vec3 from_centre = v3_sub(ray_at(ray, depth), disc->centre);
    fragment->depth = depth;
    fragment->rho2 = v3_dot(from_centre, from_centre) / (disc->radius * disc->radius);
    if (disc->is_ellipse)
        ellipse_place(&disc->ellipse, from_centre, fragment);
    return fragment->rho2 <= 1; /* false for the NaN of a ray within the plane */
}

bool disc_hit(const struct disc *disc, const struct eye *eye, const struct ray *ray, double px,
              double py, struct fragment *fragment)
{
    bool hit =
        disc->is_floored ? hit_floored(disc, px, py, fragment) : hit_disc(disc, ray, fragment);
    if (hit && disc->is_ellipse && !ellipse_keeps(&disc->ellipse, fragment))
        return false;
    return hit && fragment->depth >= eye->near_depth && fragment->depth <= eye->far_depth;
}
