#include "prepare/axis_region.h"

#include <math.h>

#include "base/vec.h"

#define LEAST_DEPTH 1.0000500033335834e-4 /* optical: -log1p(-LEAST_ALPHA) */

struct axis_rays axis_rays(const struct stp_camera *camera)
{
    const double *m = camera->world_to_camera; /* rigid: columns are the world's axes */
    struct axis_rays rays;
    for (int a = 0; a < 3; a++) {
        double x = camera->orthographic ? 0 : m[a] / camera->fx;
        double y = camera->orthographic ? 0 : -m[4 + a] / camera->fy;
        rays.component[a] = (struct axis_line){ x, y, -m[8 + a] - x * camera->cx - y * camera->cy };
    }
    return rays;
}

static double at(const struct axis_line *line, double px, double py)
{
    return line->x * px + line->y * py + line->c;
}

struct vec3 axis_ray(const struct axis_rays *rays, double px, double py)
{
    return v3(at(&rays->component[0], px, py), at(&rays->component[1], px, py),
              at(&rays->component[2], px, py));
}

static struct axis_line combine(const struct axis_line *a, double s, const struct axis_line *b,
                                double t)
{
    return (struct axis_line){ s * a->x + t * b->x, s * a->y + t * b->y, s * a->c + t * b->c };
}

struct axis_region axis_region(const struct axis_rays *rays, const struct axis_lists *lists,
                               const struct axis_walk *walk)
{
    struct axis_region region = { .count = 0 };
    bool clip = lists->merge == STP_AXIS_CLIP;
    const struct axis_line *own = &rays->component[walk->axis];
    double sign = walk->backwards ? -1 : 1, h = clip ? 1 - AXIS_CLIP_MARGIN : lists->h;
    region.line[region.count++] = combine(own, sign, own, 0);
    for (int b = 0; b < 3; b++)
        for (int side = -1; b != walk->axis && side < 2; side += 2)
            region.line[region.count++] = combine(own, sign, &rays->component[b], side * h);
    return region;
}

bool axis_region_holds(const struct axis_region *region, double px, double py)
{
    for (unsigned i = 0; i < region->count; i++)
        if (!(at(&region->line[i], px, py) > 0))
            return false;
    return true;
}

bool axis_region_reaches(const struct axis_region *region, const struct axis_rectangle *r)
{
    double x[2] = { (double)r->x0 + 0.5, (double)r->x1 + 0.5 };
    double y[2] = { (double)r->y0 + 0.5, (double)r->y1 + 0.5 };
    for (unsigned i = 0; i < region->count; i++) {
        const struct axis_line *l = &region->line[i];
        if (!(at(l, x[l->x > 0], y[l->y > 0]) > 0))
            return false;
    }
    return true;
}

enum axis_shape axis_shape(const struct stp_scene *scene)
{
    if (!scene->volume)
        return AXIS_DISCS;
    return volume_is_range(scene->volume) ? AXIS_ELLIPSOIDS : AXIS_VOXELS;
}

size_t axis_kernels(const struct stp_scene *scene)
{
    return scene->volume ? scene->volume->kernels.count : scene->splats.count;
}

/* The eye, or where the pixel's ray crosses the plane of the eye. */
static struct axis_rays axis_starts(const struct stp_camera *camera)
{
    const double *m = camera->world_to_camera;
    struct axis_rays starts;
    for (int a = 0; a < 3; a++) {
        double eye = -(m[a] * m[3] + m[4 + a] * m[7] + m[8 + a] * m[11]);
        double x = camera->orthographic ? m[a] / camera->fx : 0;
        double y = camera->orthographic ? -m[4 + a] / camera->fy : 0;
        starts.component[a] = (struct axis_line){ x, y, eye - x * camera->cx - y * camera->cy };
    }
    return starts;
}

static void shape_of_grid(struct axis_view *view)
{
    const double *m = view->camera->world_to_camera;
    const double *spacing = view->volume->grid.spacing;
    for (int row = 0; row < 3; row++) {
        double sum = 0;
        for (int a = 0; a < 3; a++) {
            double s = KERNEL_SIGMA * spacing[a];
            sum += m[4 * row + a] * m[4 * row + a] * s * s;
        }
        view->half[row] = KERNEL_REACH * sqrt(sum);
        view->white[row][row] = 1 / (KERNEL_SIGMA * spacing[row]);
    }
    view->amplitude = kernel_amplitude();
    view->least_peak =
        view->amplitude * sqrt(2 * M_PI) * KERNEL_SIGMA * volume_finest(&view->volume->grid);
}

struct axis_view axis_view(const struct stp_scene *scene, const struct stp_camera *camera)
{
    struct axis_view view = { .camera = camera,
                              .scene = scene,
                              .volume = scene->volume,
                              .shape = axis_shape(scene),
                              .rays = axis_rays(camera),
                              .starts = axis_starts(camera) };
    if (view.shape == AXIS_ELLIPSOIDS)
        view.look = range_view_of(camera);
    else if (view.shape == AXIS_VOXELS)
        shape_of_grid(&view);
    return view;
}

/* The axes in the camera frame, and, by cross products, the inverse of the matrix they make. */
static void shape_of_ellipsoid(struct axis_view *view, const float axes[3][3])
{
    const double *m = view->camera->world_to_camera;
    struct vec3 axis[3] = { v3_loadf(axes[0]), v3_loadf(axes[1]), v3_loadf(axes[2]) };
    double volume = v3_dot(axis[0], v3_cross(axis[1], axis[2]));
    for (int n = 0; n < 3; n++) {
        struct vec3 w = v3_scale(v3_cross(axis[(n + 1) % 3], axis[(n + 2) % 3]), 1 / volume);
        v3_store(w, view->white[n]);
        for (int row = 0; row < 3; row++)
            view->reach[row][n] = KERNEL_REACH * v3_dot(v3_load(m + 4 * row), axis[n]);
    }
    for (int row = 0; row < 3; row++)
        view->half[row] = v3_length(v3_load(view->reach[row]));
    view->amplitude = 1;
}

/* An ellipsoid of no thickness, in front of the eye. */
static void shape_of_disc(struct axis_view *view, const struct axis_disc *disc)
{
    for (int n = 0; n < 2; n++) {
        struct vec3 axis = v3_scale(disc->axis[n], disc->radius[n]);
        const double along[3] = { axis.x, axis.y, axis.z };
        for (int row = 0; row < 3; row++)
            view->reach[row][n] = along[row];
    }
    for (int row = 0; row < 3; row++) {
        view->reach[row][2] = 0;
        view->half[row] = v3_length(v3_load(view->reach[row]));
    }
}

void axis_centre(const struct axis_view *view, uint32_t index, double world[3])
{
    const double *place = view->shape == AXIS_DISCS        ? view->scene->splats.position[index]
                          : view->shape == AXIS_ELLIPSOIDS ? view->volume->kernels.place[index]
                                                           : NULL;
    uint32_t at[3] = { 0 };
    if (!place)
        voxel_place(&view->volume->grid, view->volume->kernels.voxel[index], at);
    for (int a = 0; a < 3; a++)
        world[a] =
            place ? place[a] : view->volume->grid.origin[a] + at[a] * view->volume->grid.spacing[a];
}

bool axis_kernel(const struct axis_view *view, uint32_t index, struct axis_kernel *kernel)
{
    axis_centre(view, index, kernel->centre);
    kernel->view = view;
    if (view->shape == AXIS_VOXELS)
        return true;
    kernel->own = *view;
    kernel->view = &kernel->own;
    if (view->shape == AXIS_ELLIPSOIDS) {
        shape_of_ellipsoid(&kernel->own, view->volume->kernels.axes[index]);
        return true;
    }
    if (!axis_disc_make(view->scene, view->camera, &view->disc_look, index, &kernel->disc))
        return false;
    shape_of_disc(&kernel->own, &kernel->disc);
    return true;
}

double axis_tau(const struct axis_view *view, uint32_t index)
{
    if (view->shape == AXIS_DISCS)
        return 0;
    return view->shape == AXIS_ELLIPSOIDS ? range_tau(view->volume, &view->look, index)
                                          : (double)view->volume->kernels.tau[index];
}

/* Pixels of [0, size) whose centres lie in centre + focal * [low, high] / [near, far]. */
static bool span(double low, double high, const double depth[2], double focal, double centre,
                 uint32_t size, int64_t *first, int64_t *last)
{
    double a = centre + focal * (low / depth[low < 0 ? 0 : 1]);
    double b = centre + focal * (high / depth[high > 0 ? 0 : 1]);
    a = fmax(ceil(a - 0.5), 0);
    b = fmin(floor(b - 0.5), (double)size - 1);
    if (!(a <= b))
        return false;
    *first = (int64_t)a;
    *last = (int64_t)b;
    return true;
}

/* Where x / z lies on an ellipsoid in front of the eye: the tangents from the eye, from the dual
 * conic in the frame sheared so that the centre is on its axis, which keeps the digits of a far
 * one. */
static void tangents(const double reach[3][3], int row, double sign, double place, double depth,
                     double bounds[2])
{
    struct vec3 z = v3_scale(v3_load(reach[2]), -1);
    struct vec3 x = v3_sub(v3_scale(v3_load(reach[row]), sign), v3_scale(z, place));
    double zz = depth * depth - v3_dot(z, z), xz = -v3_dot(x, z), xx = -v3_dot(x, x);
    double root = sqrt(fmax(xz * xz - xx * zz, 0));
    bounds[0] = place + (xz - root) / zz;
    bounds[1] = place + (xz + root) / zz;
}

static bool ellipsoid_pixels(const struct axis_view *view, struct vec3 c, struct axis_rectangle *r)
{
    const struct stp_camera *camera = view->camera;
    const double one[2] = { 1, 1 };
    double x[2], y[2];
    tangents(view->reach, 0, 1, c.x / -c.z, -c.z, x);
    tangents(view->reach, 1, -1, -c.y / -c.z, -c.z, y);
    return span(x[0], x[1], one, camera->fx, camera->cx, camera->width, &r->x0, &r->x1) &&
           span(y[0], y[1], one, camera->fy, camera->cy, camera->height, &r->y0, &r->y1);
}

/* Around the ellipse on the screen that stands for a disc below the floor. */
static bool floored_pixels(const struct axis_disc *d, struct axis_rectangle *r)
{
    const double one[2] = { 1, 1 };
    const struct stp_camera *c = d->camera;
    return span(-d->reach[0], d->reach[0], one, 1, d->at[0], c->width, &r->x0, &r->x1) &&
           span(-d->reach[1], d->reach[1], one, 1, d->at[1], c->height, &r->y0, &r->y1);
}

bool axis_pixels(const struct axis_kernel *kernel, struct axis_rectangle *r)
{
    const struct axis_view *view = kernel->view;
    const struct stp_camera *camera = view->camera;
    if (view->shape == AXIS_DISCS && kernel->disc.floored)
        return floored_pixels(&kernel->disc, r);
    struct vec3 c = m4_point(camera->world_to_camera, v3_load(kernel->centre));
    const double *h = view->half, one[2] = { 1, 1 };
    double depth[2] = { fmax(-c.z - h[2], camera->near_depth),
                        fmin(-c.z + h[2], camera->far_depth) };
    if (!(depth[0] <= depth[1]))
        return false;
    if (view->shape != AXIS_VOXELS && !camera->orthographic && -c.z - h[2] > camera->near_depth)
        return ellipsoid_pixels(view, c, r);
    const double *d = camera->orthographic ? one : depth;
    return span(c.x - h[0], c.x + h[0], d, camera->fx, camera->cx, camera->width, &r->x0, &r->x1) &&
           span(-c.y - h[1], -c.y + h[1], d, camera->fy, camera->cy, camera->height, &r->y0,
                &r->y1);
}

/* Of a grid it is diagonal. */
static struct vec3 whitened(const struct axis_view *view, struct vec3 v)
{
    if (view->shape == AXIS_VOXELS)
        return v3(view->white[0][0] * v.x, view->white[1][1] * v.y, view->white[2][2] * v.z);
    return v3(v3_dot(v3_load(view->white[0]), v), v3_dot(v3_load(view->white[1]), v),
              v3_dot(v3_load(view->white[2]), v));
}

/* A ray in the space where the kernel is the unit Gaussian. */
struct approach {
    double a;    /* squared length of the ray's direction */
    double peak; /* where it is nearest */
    double m2;   /* how near, squared */
};

static struct approach approach(const struct axis_view *view, const double centre[3], struct vec3 v,
                                double px, double py)
{
    struct vec3 s = axis_ray(&view->starts, px, py);
    struct vec3 u = whitened(view, v), e = whitened(view, v3_sub(s, v3_load(centre)));
    double a = v3_dot(u, u), peak = -v3_dot(e, u) / a;
    struct vec3 d = v3_add(e, v3_scale(u, peak));
    return (struct approach){ a, peak, v3_dot(d, d) };
}

/* Certain of a voxel's fragment without its exact opacity: where it is greatest is seen, so that at
 * least half of the integral is, exp(-m2 / 2) >= 1 - m2 / 2, and 1 - exp(-x) is at least
 * x (1 - x / 2). */
static bool is_plain(const struct axis_view *view, const struct approach *n, double tau)
{
    const double rim = 0.0111; /* below exp(-4.5), at the reach */
    return n->peak >= view->camera->near_depth && n->peak <= view->camera->far_depth &&
           0.5 * tau * view->least_peak * fmax(1 - 0.5 * n->m2, rim) >= 1.001 * LEAST_ALPHA;
}

bool axis_hits(const struct axis_kernel *kernel, double tau, double px, double py)
{
    const struct axis_view *view = kernel->view;
    const struct stp_camera *camera = view->camera;
    if (view->shape == AXIS_DISCS)
        return axis_disc_hits(&kernel->disc, px, py);
    struct vec3 v = axis_ray(&view->rays, px, py);
    struct approach n = approach(view, kernel->centre, v, px, py);
    if (n.m2 > KERNEL_REACH * KERNEL_REACH)
        return false;
    if (is_plain(view, &n, tau))
        return true;
    double t = fmin(fmax(n.peak, camera->near_depth), camera->far_depth);
    if (n.m2 + n.a * (t - n.peak) * (t - n.peak) > KERNEL_REACH * KERNEL_REACH)
        return false;
    double root = sqrt(0.5 * n.a);
    double share = 0.5 * (erfc((camera->near_depth - n.peak) * root) -
                          erfc((camera->far_depth - n.peak) * root));
    double integral =
        view->amplitude * v3_length(v) * sqrt(2 * M_PI / n.a) * exp(-0.5 * n.m2) * share;
    return tau * integral >= LEAST_DEPTH;
}
