#include "prepare/axis_region.h"

#include <math.h>

#include "base/vec.h"

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

struct axis_view axis_view(const struct stp_scene *scene, const struct stp_camera *camera)
{
    struct axis_view view = { .camera = camera,
                              .volume = scene->volume,
                              .rays = axis_rays(camera),
                              .starts = axis_starts(camera) };
    const double *m = camera->world_to_camera;
    for (int row = 0; row < 3; row++) {
        double sum = 0;
        for (int a = 0; a < 3; a++) {
            double s = KERNEL_SIGMA * scene->volume->grid.spacing[a];
            sum += m[4 * row + a] * m[4 * row + a] * s * s;
        }
        view.half[row] = KERNEL_REACH * sqrt(sum);
    }
    return view;
}

void axis_centre(const struct axis_view *view, uint32_t voxel, double world[3])
{
    const struct grid *grid = &view->volume->grid;
    uint32_t index[3];
    voxel_place(grid, voxel, index);
    for (int a = 0; a < 3; a++)
        world[a] = grid->origin[a] + index[a] * grid->spacing[a];
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

bool axis_pixels(const struct axis_view *view, const double centre[3], struct axis_rectangle *r)
{
    const struct stp_camera *camera = view->camera;
    struct vec3 c = m4_point(camera->world_to_camera, v3_load(centre));
    const double *h = view->half, one[2] = { 1, 1 };
    double depth[2] = { fmax(-c.z - h[2], camera->near_depth),
                        fmin(-c.z + h[2], camera->far_depth) };
    if (!(depth[0] <= depth[1]))
        return false;
    const double *d = camera->orthographic ? one : depth;
    return span(c.x - h[0], c.x + h[0], d, camera->fx, camera->cx, camera->width, &r->x0, &r->x1) &&
           span(-c.y - h[1], -c.y + h[1], d, camera->fy, camera->cy, camera->height, &r->y0,
                &r->y1);
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
    const double *spacing = view->volume->grid.spacing;
    struct vec3 s = axis_ray(&view->starts, px, py);
    double sx = 1 / (KERNEL_SIGMA * spacing[0]), sy = 1 / (KERNEL_SIGMA * spacing[1]),
           sz = 1 / (KERNEL_SIGMA * spacing[2]);
    struct vec3 u = v3(v.x * sx, v.y * sy, v.z * sz);
    struct vec3 e = v3((s.x - centre[0]) * sx, (s.y - centre[1]) * sy, (s.z - centre[2]) * sz);
    double a = v3_dot(u, u), peak = -v3_dot(e, u) / a;
    struct vec3 d = v3_add(e, v3_scale(u, peak));
    return (struct approach){ a, peak, v3_dot(d, d) };
}

bool axis_nearly_meets(const struct axis_view *view, const double centre[3], double peak, double px,
                       double py)
{
    struct approach n = approach(view, centre, axis_ray(&view->rays, px, py), px, py);
    /* At least half of the integral is seen, exp(-m2 / 2) >= 1 - m2 / 2, and 1 - exp(-x) is at
     * least x (1 - x / 2). */
    return n.m2 <= 1 && n.peak >= view->camera->near_depth && n.peak <= view->camera->far_depth &&
           0.5 * peak * (1 - 0.5 * n.m2) >= 1.001 * LEAST_ALPHA;
}

bool axis_hits(const struct axis_view *view, const double centre[3], double tau, double px,
               double py)
{
    const struct stp_camera *camera = view->camera;
    struct vec3 v = axis_ray(&view->rays, px, py);
    struct approach n = approach(view, centre, v, px, py);
    double t = fmin(fmax(n.peak, camera->near_depth), camera->far_depth);
    if (n.m2 + n.a * (t - n.peak) * (t - n.peak) > KERNEL_REACH * KERNEL_REACH)
        return false;
    double root = sqrt(0.5 * n.a);
    double share = 0.5 * (erfc((camera->near_depth - n.peak) * root) -
                          erfc((camera->far_depth - n.peak) * root));
    double integral =
        kernel_amplitude() * v3_length(v) * sqrt(2 * M_PI / n.a) * exp(-0.5 * n.m2) * share;
    return -expm1(-tau * integral) >= LEAST_ALPHA;
}
