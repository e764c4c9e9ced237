/* BSK 3: the plane that fits a patch's samples best, and the axes that its linear normal field
 * wants: Eq. 2 has no mixed term, so u and v are the directions of principal curvature. */
#include <math.h>

#include "prepare/eigen.h"
#include "prepare/phong_fit.h"

#define PLANAR 1e-10 /* of the largest variance: below, the members lie on a line */

struct vec3 site_normal(const struct fit_cloud *cloud, uint32_t i, struct vec3 n)
{
    struct vec3 own = v3_loadf(cloud->site[i].n);
    double side = v3_dot(own, n);
    if (v3_dot(own, own) == 0)
        return n;
    return side < 0 && !cloud->signs ? v3_scale(own, -1) : own;
}

/* Some unit vector at right angles to n. */
static struct vec3 any_tangent(struct vec3 n)
{
    struct vec3 axis = fabs(n.x) < 0.6 ? v3(1, 0, 0) : v3(0, 1, 0);
    return v3_unit(v3_cross(n, axis));
}

static void set_axes(struct patch_frame *frame, struct vec3 u)
{
    u = v3_sub(u, v3_scale(frame->n, v3_dot(u, frame->n)));
    frame->u = v3_length(u) > 1e-6 ? v3_unit(u) : any_tangent(frame->n);
    frame->v = v3_cross(frame->n, frame->u);
}

void plane_sums_add(struct plane_sums *sums, struct vec3 d, struct vec3 n)
{
    sums->count += 1;
    sums->d = v3_add(sums->d, d);
    sums->n = v3_add(sums->n, n);
    sums->dd[0] += d.x * d.x;
    sums->dd[1] += d.x * d.y;
    sums->dd[2] += d.x * d.z;
    sums->dd[3] += d.y * d.y;
    sums->dd[4] += d.y * d.z;
    sums->dd[5] += d.z * d.z;
}

void plane_of_sums(const struct plane_sums *sums, struct vec3 at, struct vec3 hint,
                   struct patch_frame *frame)
{
    double s[6], value[3], vector[3][3], n = 1 / sums->count;
    struct vec3 m = v3_scale(sums->d, n);
    double mean[6] = { m.x * m.x, m.x * m.y, m.x * m.z, m.y * m.y, m.y * m.z, m.z * m.z };
    for (int i = 0; i < 6; i++)
        s[i] = sums->dd[i] * n - mean[i];
    eigen_symmetric(s, value, vector);
    frame->c = v3_add(at, m);
    struct vec3 normals = v3_length(sums->n) > 1e-3 * sums->count ? v3_unit(sums->n) : hint;
    struct vec3 plane = v3_load(vector[0]);
    double side = v3_dot(plane, normals);
    bool open = sums->count < 3 || !(value[1] > PLANAR * value[2]);
    if (open) { /* the plane that holds the line and is nearest to the normals */
        struct vec3 line = v3_load(vector[2]);
        plane = v3_sub(normals, v3_scale(line, sums->count > 1 ? v3_dot(normals, line) : 0));
        plane = v3_length(plane) > 0.1 ? v3_unit(plane) : normals;
    } else if (fabs(side) < 0.5) {
        plane = normals; /* as long across as it is wide: a cluster, not a sheet */
    } else if (side < 0) {
        plane = v3_scale(plane, -1);
    }
    frame->n = plane;
    set_axes(frame, v3_load(vector[2]));
    frame->bend[0] = frame->bend[1] = 0;
}

void patch_plane(const struct fit_cloud *cloud, const uint32_t *member, size_t count,
                 struct vec3 hint, struct patch_frame *frame)
{
    struct vec3 at = v3_load(cloud->site[member[0]].p);
    struct plane_sums sums = { 0 };
    for (size_t k = 0; k < count; k++)
        plane_sums_add(&sums, v3_sub(v3_load(cloud->site[member[k]].p), at),
                       site_normal(cloud, member[k], hint));
    plane_of_sums(&sums, at, hint, frame);
}

/* Sums of the least-squares fit of x and y, each linear in s and t. */
struct field_sums {
    double one, s, t, ss, st, tt, x, xs, xt, y, ys, yt;
};

static void add_to_sums(struct field_sums *f, double s, double t, double x, double y, double w)
{
    f->one += w;
    f->s += w * s;
    f->t += w * t;
    f->ss += w * s * s;
    f->st += w * s * t;
    f->tt += w * t * t;
    f->x += w * x;
    f->xs += w * x * s;
    f->xt += w * x * t;
    f->y += w * y;
    f->ys += w * y * s;
    f->yt += w * y * t;
}

/* The slopes, about the centroid: a 2x2 system. False: the members leave them open. */
static bool slopes(const struct field_sums *f, double z, double zs, double zt, double slope[2])
{
    double ss = f->ss - f->s * f->s / f->one, tt = f->tt - f->t * f->t / f->one;
    double st = f->st - f->s * f->t / f->one, det = ss * tt - st * st;
    double a = zs - z * f->s / f->one, b = zt - z * f->t / f->one;
    if (!(det > 1e-6 * (ss + tt) * (ss + tt)))
        return false;
    slope[0] = (a * tt - b * st) / det;
    slope[1] = (b * ss - a * st) / det;
    return true;
}

void patch_axes(const struct fit_cloud *cloud, const uint32_t *member, size_t count,
                struct patch_frame *frame)
{
    struct field_sums f = { 0 };
    double dx[2], dy[2];
    for (size_t k = 0; k < count; k++) {
        struct vec3 d = v3_sub(v3_load(cloud->site[member[k]].p), frame->c);
        struct vec3 n = site_normal(cloud, member[k], frame->n);
        double z = v3_dot(n, frame->n);
        if (z < 0.1)
            continue;
        add_to_sums(&f, v3_dot(d, frame->u), v3_dot(d, frame->v), v3_dot(n, frame->u) / z,
                    v3_dot(n, frame->v) / z, z * z);
    }
    if (count < 5 || !(f.one > 0) || !slopes(&f, f.x, f.xs, f.xt, dx) ||
        !slopes(&f, f.y, f.ys, f.yt, dy))
        return;
    /* The symmetric part of (dx, dy): the shape operator. Its eigenvectors are u and v. */
    double a = dx[0], b = 0.5 * (dx[1] + dy[0]), c = dy[1], mean = 0.5 * (a + c);
    double half = hypot(0.5 * (a - c), b);
    frame->bend[0] = mean + half;
    frame->bend[1] = mean - half;
    if (half <= 1e-3 * fabs(mean))
        return; /* umbilic: any axes will do */
    double angle = 0.5 * atan2(2 * b, a - c);
    set_axes(frame, v3_add(v3_scale(frame->u, cos(angle)), v3_scale(frame->v, sin(angle))));
}
