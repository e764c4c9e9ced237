/* A splat's bounds on the screen, for estimates: the affine ellipse where the splat is far compared
 * with its radius, and its sphere's box where it is near. */
#include "plan/survey.h"

#include <math.h>

#include "base/vec.h"
#include "shared/frame.h"

#define NEAR_RATIO 0.05 /* radius over depth: above it the sphere bounds the splat */

struct spot_view spot_view_of(const struct stp_scene *scene, const struct stp_camera *camera,
                              const struct stp_render_params *params)
{
    const double *m = camera->world_to_camera;
    struct vec3 t = m4_point(m, v3_load(scene->splats.origin));
    struct spot_view view = { .scene = scene,
                              .translation = { t.x, -t.y, -t.z },
                              .fx = camera->fx,
                              .fy = camera->fy,
                              .cx = camera->cx,
                              .cy = camera->cy,
                              .near_depth = camera->near_depth,
                              .far_depth = camera->far_depth,
                              .width = camera->width,
                              .height = camera->height,
                              .orthographic = camera->orthographic,
                              .cull_back = params->cull == STP_CULL_BACK };
    for (int i = 0; i < 3; i++) {
        view.rotation[i] = m[i];
        view.rotation[3 + i] = -m[4 + i];
        view.rotation[6 + i] = -m[8 + i];
    }
    view.least = params->min_splat < 0 ? 0 : params->min_splat > 0 ? params->min_splat : 1.5;
    return view;
}

static struct vec3 rotate(const double r[9], struct vec3 a)
{
    return v3(r[0] * a.x + r[1] * a.y + r[2] * a.z, r[3] * a.x + r[4] * a.y + r[5] * a.z,
              r[6] * a.x + r[7] * a.y + r[8] * a.z);
}

/* The pixels whose centres lie in [low, high], of `size`; false: none. */
static bool pixels_in(double low, double high, uint32_t size, uint32_t *first, uint32_t *last)
{
    low = ceil(low - 0.5);
    high = floor(high - 0.5);
    if (!(high >= 0 && low <= size - 1.0 && low <= high))
        return false;
    *first = low > 0 ? (uint32_t)low : 0;
    *last = high < size - 1.0 ? (uint32_t)high : size - 1;
    return true;
}

/* Half the extent along both axes, and the area, of the ellipse with the floor applied. */
static void ellipse(const struct spot_view *view, struct vec3 n, struct vec3 s, double scale,
                    double half[2], double *area)
{
    double a = n.x * s.x + n.z, b = n.y * s.y + n.z, floor_ = view->least / 2;
    half[0] = view->fx * scale * sqrt(a * a + n.y * n.y * (1 + s.x * s.x));
    half[1] = view->fy * scale * sqrt(b * b + n.x * n.x * (1 + s.y * s.y));
    /* Semi-axes from their product and the sum of their squares. */
    double product = view->fx * view->fy * scale * scale * fabs(v3_dot(n, s));
    double sum = half[0] * half[0] + half[1] * half[1];
    double spread = sqrt(fmax(sum * sum / 4 - product * product, 0));
    double major = sqrt(sum / 2 + spread), minor = major > 0 ? product / major : 0;
    *area = M_PI * fmax(major, floor_) * fmax(minor, floor_);
    half[0] = fmax(half[0], floor_);
    half[1] = fmax(half[1], floor_);
}

/* The box of the sphere; the whole plane where the eye may be inside. */
static void sphere(const struct spot_view *view, struct vec3 p, double radius, double half[2],
                   double *area)
{
    double least = view->orthographic ? 1 : p.z - radius;
    double scale = least > 0 ? radius / least : INFINITY;
    double slant = view->orthographic ? 0 : fmax(fabs(p.x), fabs(p.y)) / fmax(p.z, radius);
    half[0] = fmax(view->fx * scale * (1 + slant), view->least / 2);
    half[1] = fmax(view->fy * scale * (1 + slant), view->least / 2);
    *area = half[0] * half[1] * (M_PI / 2); /* seen at 60 degrees, the mean of all directions */
}

bool spot_find(const struct spot_view *view, size_t i, struct spot *spot)
{
    const struct splats *splats = &view->scene->splats;
    const double *at = splats->position[i], *o = splats->origin;
    struct vec3 p = rotate(view->rotation, v3(at[0] - o[0], at[1] - o[1], at[2] - o[2]));
    p = v3_add(p, v3_load(view->translation));
    struct vec3 n = rotate(view->rotation, v3_loadf(splats->normal[i]));
    double radius = splats->radius[i], half[2], area;
    bool flat = view->orthographic;
    if (!(p.z + radius >= view->near_depth) || p.z - radius > view->far_depth)
        return false;
    if (view->cull_back && v3_dot(n, flat ? v3(0, 0, 1) : p) > 0)
        return false;
    struct vec3 s = flat ? v3(0, 0, 1) : v3(p.x / p.z, p.y / p.z, 1);
    bool cut = !flat && p.z - radius <= view->near_depth;
    if (v3_dot(n, n) == 0)
        n = v3_unit(s);
    if (flat || radius <= NEAR_RATIO * p.z)
        ellipse(view, n, s, flat ? radius : radius / p.z, half, &area);
    else
        sphere(view, p, radius, half, &area);
    double x = view->cx + view->fx * (flat ? p.x : s.x),
           y = view->cy + view->fy * (flat ? p.y : s.y);
    if (isinf(half[0]))
        x = y = 0;
    if (!pixels_in(x - half[0], x + half[0], view->width, &spot->x0, &spot->x1) ||
        !pixels_in(y - half[1], y + half[1], view->height, &spot->y0, &spot->y1))
        return false;
    double box = (spot->x1 - spot->x0 + 1.0) * (spot->y1 - spot->y0 + 1.0);
    double whole = 4 * half[0] * half[1];
    spot->fragments = isinf(whole) ? box / 2 : fmin(area * fmin(box / whole, 1), box);
    spot->large = cut || box > STP_LARGE_AREA;
    return true;
}
