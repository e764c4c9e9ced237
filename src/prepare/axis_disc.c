#include "prepare/axis_disc.h"

#include <math.h>

#include "scene/phong.h"

#define EDGE_ON 1e-7 /* |n.view| / |view| below which a plane has no slope (docs/numerics.md) */

/* The ray of a place of the picture: start + t along, t the eye depth. */
static void ray_at(const struct stp_camera *c, double px, double py, struct vec3 *start,
                   struct vec3 *along)
{
    double x = (px - c->cx) / c->fx, y = -(py - c->cy) / c->fy;
    *start = c->orthographic ? v3(x, y, 0) : v3(0, 0, 0);
    *along = c->orthographic ? v3(0, 0, -1) : v3(x, y, -1);
}

/* From the eye to the centre; orthographic: along the sight. */
static struct vec3 sight(const struct axis_disc *d)
{
    return d->camera->orthographic ? v3(0, 0, -1) : d->centre;
}

static struct vec3 any_across(struct vec3 n)
{
    return v3_unit(v3_cross(n, fabs(n.x) < 0.7 ? v3(1, 0, 0) : v3(0, 1, 0)));
}

/* A splat's normal, as given, and the axes of its ellipse; of a disc any. */
static void set_frame(const struct splats *splats, size_t id, struct axis_disc *d)
{
    const double *m = d->camera->world_to_camera;
    d->normal = v3_unit(m4_direction(m, v3_loadf(splats->normal[id])));
    if (v3_length(d->normal) == 0)
        d->normal = v3_unit(v3_scale(sight(d), -1));
    d->axis[0] = any_across(d->normal);
    d->radius[0] = d->radius[1] = (double)splats->radius[id];
    d->clipped = NULL;
    if (splats->phong && !phong_is_disc(&splats->phong[id])) {
        const struct stp_phong_splat *p = &splats->phong[id];
        d->axis[0] = v3_unit(m4_direction(m, v3_loadf(p->u)));
        d->radius[0] = (double)p->radius[0];
        d->radius[1] = (double)p->radius[1];
        d->clipped = p->clips ? p : NULL;
    }
    d->axis[1] = v3_cross(d->normal, d->axis[0]);
}

/* Does any normal of the field face the eye? As --cull back asks (docs/phong.md). */
static bool field_faces(const struct splats *splats, size_t id, const struct axis_disc *d)
{
    if (!splats->phong || phong_is_disc(&splats->phong[id]))
        return false;
    const float *f = splats->phong[id].field;
    struct vec3 to = v3_scale(sight(d), -1);
    double a = v3_dot(d->axis[0], to), b = v3_dot(d->axis[1], to);
    bool flat = d->camera->orthographic;
    double r = flat ? 0 : d->radius[0], q = flat ? 0 : d->radius[1];
    double f0 = (double)f[0], f1 = (double)f[1], f2 = (double)f[2], f3 = (double)f[3];
    double middle = v3_dot(d->normal, to) + f0 * a + f2 * b;
    double more = hypot(f1 * a - f0 * r, f3 * b - f2 * q);
    return middle + more + fmax(0, fmax(-f1 * r, -f3 * q)) > 0;
}

/* What a pixel right and down is on the plane around the centre, to first order. */
struct first_order {
    struct vec3 along, step[2]; /* the centre's ray; its steps at the centre's depth */
    double across[2], facing;   /* their components along the normal */
    bool edge_on;
};

static struct first_order first_order(const struct axis_disc *d)
{
    const struct stp_camera *c = d->camera;
    double z = c->orthographic ? 1 : -d->centre.z;
    struct first_order f = { .step = { v3(z / c->fx, 0, 0), v3(0, -z / c->fy, 0) } };
    f.along = c->orthographic ? v3(0, 0, -1) : v3_scale(d->centre, -1 / d->centre.z);
    f.across[0] = v3_dot(d->normal, f.step[0]);
    f.across[1] = v3_dot(d->normal, f.step[1]);
    f.facing = v3_dot(d->normal, f.along);
    struct vec3 view = sight(d);
    f.edge_on = fabs(v3_dot(d->normal, view)) <= EDGE_ON * v3_length(view) ||
                !isfinite(f.across[0] / f.facing) || !isfinite(f.across[1] / f.facing);
    return f;
}

static void on_axes(const struct axis_disc *d, struct vec3 v, double out[2])
{
    out[0] = v3_dot(v, d->axis[0]) / d->radius[0];
    out[1] = v3_dot(v, d->axis[1]) / d->radius[1];
}

/* The map's singular values, squared, the direction of the larger on the screen and of its image;
 * turn: the sign of its determinant. Edge-on the larger is infinite. */
struct spread {
    double large, small, v[2], image[2], turn;
};

static struct spread spread_of(const struct axis_disc *d, const struct first_order *f, bool turned)
{
    struct spread s;
    double det = v3_dot(f->along, v3_cross(f->step[0], f->step[1])) / (d->radius[0] * d->radius[1]);
    if (f->edge_on) {
        double length = hypot(f->across[0], f->across[1]);
        s.v[0] = f->across[0] / length;
        s.v[1] = f->across[1] / length;
        on_axes(d, f->along, s.image);
        double image = hypot(s.image[0], s.image[1]);
        s.large = INFINITY;
        s.small = det / (length * image) * (det / (length * image));
        s.turn = turned ? 1 : -1;
        return s;
    }
    double x[2], y[2];
    on_axes(d, v3_sub(f->step[0], v3_scale(f->along, f->across[0] / f->facing)), x);
    on_axes(d, v3_sub(f->step[1], v3_scale(f->along, f->across[1] / f->facing)), y);
    double a = x[0] * x[0] + x[1] * x[1], b = x[0] * y[0] + x[1] * y[1];
    double c = y[0] * y[0] + y[1] * y[1], angle = 0.5 * atan2(2 * b, a - c);
    s.v[0] = cos(angle);
    s.v[1] = sin(angle);
    s.large = 0.5 * (a + c) + hypot(0.5 * (a - c), b);
    s.small = det / f->facing * (det / f->facing) / s.large;
    s.image[0] = x[0] * s.v[0] + y[0] * s.v[1];
    s.image[1] = x[1] * s.v[0] + y[1] * s.v[1];
    s.turn = x[0] * y[1] - x[1] * y[0] < 0 ? -1 : 1;
    return s;
}

/* The screen-space floor: the map with its singular values lowered to 2 / least. */
static void apply_floor(double least, bool turned, struct axis_disc *d)
{
    const struct stp_camera *c = d->camera;
    struct first_order f = first_order(d);
    struct spread s = spread_of(d, &f, turned);
    double bound = 4 / (least * least), scale = c->orthographic ? 1 : -1 / d->centre.z;
    d->floored = s.large > bound;
    if (!d->floored)
        return;
    double length = hypot(s.image[0], s.image[1]), small = sqrt(fmin(s.small, bound));
    const double u[2] = { s.image[0] / length, s.image[1] / length };
    const double beside[2] = { -s.turn * u[1], s.turn * u[0] };
    for (int i = 0; i < 2; i++) {
        d->map[i][0] = sqrt(bound) * u[i] * s.v[0] - small * beside[i] * s.v[1];
        d->map[i][1] = sqrt(bound) * u[i] * s.v[1] + small * beside[i] * s.v[0];
        d->slope[i] = f.edge_on ? 0 : -f.across[i] / f.facing;
        d->reach[i] = hypot(s.v[i] / sqrt(bound), s.v[1 - i] / small);
    }
    d->at[0] = c->cx + c->fx * d->centre.x * scale;
    d->at[1] = c->cy - c->fy * d->centre.y * scale;
}

bool axis_disc_make(const struct stp_scene *scene, const struct stp_camera *camera,
                    const struct axis_look *look, size_t id, struct axis_disc *d)
{
    const struct splats *splats = &scene->splats;
    *d = (struct axis_disc){ .camera = camera };
    d->opacity = splats->opacity ? (double)splats->opacity[id] : 1;
    d->centre = m4_point(camera->world_to_camera, v3_load(splats->position[id]));
    set_frame(splats, id, d);
    double facing = -v3_dot(d->normal, sight(d)), r = (double)splats->radius[id];
    if (!(d->opacity > 0) || !(r > 0) || -d->centre.z + r < camera->near_depth ||
        -d->centre.z - r > camera->far_depth)
        return false;
    if (look->cull_back && !(facing > 0) && !field_faces(splats, id, d))
        return false;
    if (look->floor > 0 && -d->centre.z >= camera->near_depth)
        apply_floor(look->floor, scene->facts.two_sided && facing < 0, d);
    return true;
}

static bool keeps(const struct stp_phong_splat *p, const double st[2])
{
    unsigned kept = 0;
    for (unsigned i = 0; p && i < p->clips; i++)
        kept +=
            (double)p->clip[i][0] * st[0] + (double)p->clip[i][1] * st[1] + (double)p->clip[i][2] >=
            0;
    return !p || (p->reflex ? kept > 0 : kept == p->clips);
}

bool axis_disc_hits(const struct axis_disc *d, double px, double py)
{
    double depth, st[2], r = fmax(d->radius[0], d->radius[1]);
    if (d->floored) {
        double x = px - d->at[0], y = py - d->at[1], rise = d->slope[0] * x + d->slope[1] * y;
        st[0] = d->map[0][0] * x + d->map[0][1] * y;
        st[1] = d->map[1][0] * x + d->map[1][1] * y;
        depth = -d->centre.z + fmin(fmax(rise, -r), r);
    } else {
        struct vec3 start, along;
        ray_at(d->camera, px, py, &start, &along);
        depth = v3_dot(d->normal, v3_sub(d->centre, start)) / v3_dot(d->normal, along);
        on_axes(d, v3_sub(v3_add(start, v3_scale(along, depth)), d->centre), st);
    }
    double rho2 = st[0] * st[0] + st[1] * st[1];
    return rho2 <= 1 && depth >= d->camera->near_depth && depth <= d->camera->far_depth &&
           keeps(d->clipped, st) && d->opacity * exp(-2 * rho2) >= LEAST_ALPHA;
}
