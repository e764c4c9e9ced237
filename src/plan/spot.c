/* A splat's bounds on the screen, for estimates. */
#include "plan/survey.h"

#include <math.h>

#include "base/vec.h"
#include "shared/frame.h"

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

/* A box around the projected centre, in pixels, and the area of what is in it. */
struct outline {
    double low[2], high[2], area;
};

/* The floor, as if the ellipse's axes were known from their product and the sum of their squares.
 */
static void apply_floor(const struct spot_view *view, const double half[2], struct outline *o)
{
    double product = o->area / M_PI, least = view->least / 2;
    double sum = half[0] * half[0] + half[1] * half[1];
    double spread = sqrt(fmax(sum * sum / 4 - product * product, 0));
    double major = sqrt(sum / 2 + spread), minor = major > 0 ? product / major : 0;
    o->area = M_PI * fmax(major, least) * fmax(minor, least);
    for (int k = 0; k < 2; k++) {
        double more = fmax(least - half[k], 0);
        o->low[k] -= more;
        o->high[k] += more;
    }
}

/* docs/deferred.md, "Bounds": the tangents of the conic, and its area, exact while the disc does
 * not reach the eye plane. s: the centre's ray; alpha: depth over radius. */
static bool conic(const struct spot_view *view, struct vec3 n, struct vec3 s, double alpha,
                  struct outline *o)
{
    double m = n.x * n.x + n.y * n.y, rest = alpha * alpha - m;
    if (!(rest > 0))
        return false;
    const double f[2] = { view->fx, view->fy }, a[2] = { n.x, n.y }, at[2] = { s.x, s.y };
    double half[2];
    for (int k = 0; k < 2; k++) {
        double mid = (at[k] * m + a[k] * n.z) / rest, e = a[k] * at[k] + n.z;
        double other = a[1 - k] * a[1 - k] * (1 + at[k] * at[k]);
        half[k] = f[k] * sqrt(mid * mid + (e * e + other) / rest);
        o->low[k] = f[k] * mid - half[k];
        o->high[k] = f[k] * mid + half[k];
    }
    o->area = M_PI * f[0] * f[1] * fabs(v3_dot(n, s)) * alpha / (rest * sqrt(rest));
    apply_floor(view, half, o);
    return true;
}

static void parallel(const struct spot_view *view, struct vec3 n, double radius, struct outline *o)
{
    double half[2] = { radius * view->fx * sqrt(fmax(0, 1 - n.x * n.x)),
                       radius * view->fy * sqrt(fmax(0, 1 - n.y * n.y)) };
    o->area = M_PI * radius * radius * view->fx * view->fy * fabs(n.z);
    for (int k = 0; k < 2; k++) {
        o->low[k] = -half[k];
        o->high[k] = half[k];
    }
    apply_floor(view, half, o);
}

/* A disc that the near plane cuts may be anywhere: half the picture. */
static void cut_outline(const struct spot_view *view, struct outline *o)
{
    *o = (struct outline){ { -INFINITY, -INFINITY },
                           { INFINITY, INFINITY },
                           0.5 * view->width * view->height };
}

bool spot_find(const struct spot_view *view, size_t i, struct spot *spot)
{
    const struct splats *splats = &view->scene->splats;
    const double *at = splats->position[i], *o = splats->origin;
    struct vec3 p = rotate(view->rotation, v3(at[0] - o[0], at[1] - o[1], at[2] - o[2]));
    p = v3_add(p, v3_load(view->translation));
    struct vec3 n = rotate(view->rotation, v3_loadf(splats->normal[i]));
    double radius = splats->radius[i];
    struct outline outline;
    bool flat = view->orthographic;
    if (v3_dot(n, n) == 0)
        n = flat ? v3(0, 0, -1) : v3_unit(v3_scale(p, -1));
    double reach = radius * sqrt(fmax(0, 1 - n.z * n.z));
    if (!(p.z + reach >= view->near_depth) || p.z - reach > view->far_depth)
        return false;
    if (view->cull_back && !(v3_dot(n, flat ? v3(0, 0, 1) : p) < 0))
        return false;
    struct vec3 s = flat ? v3(p.x, p.y, 1) : v3(p.x / p.z, p.y / p.z, 1);
    bool cut =
        !flat && (p.z - reach <= view->near_depth || !conic(view, n, s, p.z / radius, &outline));
    if (cut) {
        cut_outline(view, &outline);
        s = v3(0, 0, 1);
    } else if (flat)
        parallel(view, n, radius, &outline);
    double x = view->cx + view->fx * s.x, y = view->cy + view->fy * s.y;
    if (!pixels_in(x + outline.low[0], x + outline.high[0], view->width, &spot->x0, &spot->x1) ||
        !pixels_in(y + outline.low[1], y + outline.high[1], view->height, &spot->y0, &spot->y1))
        return false;
    /* As much of the area as of the box is in the picture, in the mean over places of its centre.
     */
    double box = (spot->x1 - spot->x0 + 1.0) * (spot->y1 - spot->y0 + 1.0);
    double whole = (outline.high[0] - outline.low[0]) * (outline.high[1] - outline.low[1]);
    spot->fragments = cut ? outline.area : fmin(outline.area / whole, 1) * box;
    spot->large = cut || box > STP_LARGE_AREA;
    return true;
}
