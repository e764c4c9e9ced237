/* The screen-space floor of docs/numerics.md: no axis of a projected splat below F pixels. */
#include "reference/disc.h"

#define EDGE_ON 1e-7 /* |n.view| / |view| below which the plane has no depth gradient */

/* The disc around its centre, to first order: steps of the hit point for a pixel right and down. */
struct affine {
    struct vec3 along;   /* of the centre's ray */
    struct vec3 step[2]; /* of the ray at the centre's depth */
    double across[2];    /* n.step */
    double facing;       /* n.along */
    double zx, zy;       /* depth gradient; 0 edge-on */
    bool edge_on;
};

static struct affine affine_of(const struct eye *eye, const struct disc *disc)
{
    double z = -disc->centre.z, scale = eye->orthographic ? 1 : z;
    struct vec3 view = eye_view(eye, disc->centre);
    struct affine f = { .along = eye->orthographic ? view : v3_scale(disc->centre, 1 / z),
                        .step = { v3(scale / eye->fx, 0, 0), v3(0, -scale / eye->fy, 0) } };
    f.across[0] = v3_dot(disc->normal, f.step[0]);
    f.across[1] = v3_dot(disc->normal, f.step[1]);
    f.facing = v3_dot(disc->normal, f.along);
    f.zx = -f.across[0] / f.facing;
    f.zy = -f.across[1] / f.facing;
    f.edge_on = fabs(v3_dot(disc->normal, view)) <= EDGE_ON * v3_length(view) || !isfinite(f.zx) ||
                !isfinite(f.zy);
    if (f.edge_on)
        f.zx = f.zy = 0;
    return f;
}

/* Eigenvalues of E, large and small, and the unit eigenvector (*vx, *vy) of the large one. */
static void ellipse_of(const struct affine *f, double radius, double *large, double *small,
                       double *vx, double *vy)
{
    struct vec3 dx = v3_add(f->step[0], v3_scale(f->along, f->zx));
    struct vec3 dy = v3_add(f->step[1], v3_scale(f->along, f->zy));
    double r2 = radius * radius, a = v3_dot(dx, dx) / r2, b = v3_dot(dx, dy) / r2,
           c = v3_dot(dy, dy) / r2;
    double angle = 0.5 * atan2(2 * b, a - c);
    *vx = cos(angle);
    *vy = sin(angle);
    *large = 0.5 * (a + c) + hypot(0.5 * (a - c), b);
    /* sqrt(det E) = |dx x dy| / r^2, and dx x dy is parallel to n: no cancellation this way. */
    double area = v3_dot(f->along, v3_cross(f->step[0], f->step[1])) / f->facing / r2;
    *small = area * area / *large;
}

/* Of an ellipse: what a step of the hit point is in its own axes, in radii. */
static void image_of(const struct ellipse *e, struct vec3 step, double image[2])
{
    image[0] = v3_dot(step, e->u) / e->radius[0];
    image[1] = v3_dot(step, e->v) / e->radius[1];
}

/* The same of an ellipse; columns: (s, t) of a pixel right and of one down. Edge-on the larger is
 * infinite, and the columns stay unset. */
static void ellipse_spread(const struct affine *f, const struct ellipse *e, double columns[2][2],
                           double *large, double *small, double *vx, double *vy)
{
    double across[2], length = hypot(f->across[0], f->across[1]);
    double area =
        v3_dot(f->along, v3_cross(f->step[0], f->step[1])) / (e->radius[0] * e->radius[1]);
    if (f->edge_on) {
        image_of(e, v3_scale(f->along, length), across);
        *vx = f->across[0] / length;
        *vy = f->across[1] / length;
        *large = INFINITY;
        *small = area * area / (across[0] * across[0] + across[1] * across[1]);
        return;
    }
    image_of(e, v3_add(f->step[0], v3_scale(f->along, f->zx)), columns[0]);
    image_of(e, v3_add(f->step[1], v3_scale(f->along, f->zy)), columns[1]);
    const double *x = columns[0], *y = columns[1];
    double a = x[0] * x[0] + x[1] * x[1], b = x[0] * y[0] + x[1] * y[1];
    double c = y[0] * y[0] + y[1] * y[1], angle = 0.5 * atan2(2 * b, a - c);
    *vx = cos(angle);
    *vy = sin(angle);
    *large = 0.5 * (a + c) + hypot(0.5 * (a - c), b);
    *small = area / f->facing * (area / f->facing) / *large;
}

/* (s, t) on the floored ellipse: E' by the directions of E. Edge-on the side that faces the eye
 * says which way they go. */
static void floored_map(const struct affine *f, const struct ellipse *e, double columns[2][2],
                        const double spread[2], double vx, double vy, struct floored *out)
{
    double right[2], turn = -e->turned;
    if (f->edge_on) {
        image_of(e, f->along, right);
    } else {
        for (int i = 0; i < 2; i++)
            right[i] = columns[0][i] * vx + columns[1][i] * vy;
        turn = columns[0][0] * columns[1][1] - columns[0][1] * columns[1][0] < 0 ? -1 : 1;
    }
    double length = hypot(right[0], right[1]), p = sqrt(spread[0]) / length,
           q = sqrt(spread[1]) * turn / length;
    out->s[0] = p * right[0] * vx + q * right[1] * vy;
    out->s[1] = p * right[0] * vy - q * right[1] * vx;
    out->t[0] = p * right[1] * vx - q * right[0] * vy;
    out->t[1] = p * right[1] * vy + q * right[0] * vx;
}

/* The limit as n.view goes to 0: a line across the plane's trace. */
static void segment_of(const struct affine *f, double radius, double *large, double *small,
                       double *vx, double *vy)
{
    double length = hypot(f->across[0], f->across[1]);
    *vx = f->across[0] / length;
    *vy = f->across[1] / length;
    struct vec3 d = v3_add(v3_scale(f->step[0], -*vy), v3_scale(f->step[1], *vx));
    struct vec3 off = v3_cross(d, v3_unit(f->along)); /* as long as d is across the ray */
    *large = INFINITY;
    *small = v3_dot(off, off) / (radius * radius);
}

bool floor_ellipse(const struct eye *eye, const struct disc *disc, double least,
                   struct floored *floored, double *reach)
{
    struct affine f = affine_of(eye, disc);
    double large, small, vx, vy, columns[2][2] = { { 0 } }, bound = 4 / (least * least);
    if (disc->is_ellipse)
        ellipse_spread(&f, &disc->ellipse, columns, &large, &small, &vx, &vy);
    else
        (f.edge_on ? segment_of : ellipse_of)(&f, disc->radius, &large, &small, &vx, &vy);
    if (!(large > bound))
        return false;
    small = fmin(small, bound);
    double scale = eye->orthographic ? 1 : -1 / disc->centre.z;
    *floored = (struct floored){ .px = eye->cx + eye->fx * disc->centre.x * scale,
                                 .py = eye->cy - eye->fy * disc->centre.y * scale,
                                 .a = bound * vx * vx + small * vy * vy,
                                 .b = (bound - small) * vx * vy,
                                 .c = bound * vy * vy + small * vx * vx,
                                 .zx = f.zx,
                                 .zy = f.zy };
    *reach = 1 / sqrt(small);
    if (disc->is_ellipse)
        floored_map(&f, &disc->ellipse, columns, (double[]){ bound, small }, vx, vy, floored);
    return true;
}
