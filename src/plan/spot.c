/* A splat's bounds on the screen, for estimates. */
#include "plan/survey.h"

#include <float.h>
#include <math.h>

#include "base/thread.h"
#include "base/vec.h"
#include "reference/disc.h"
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
    view.least = params->min_splat < 0   ? 0
                 : params->min_splat > 0 ? params->min_splat
                                         : STP_DEFAULT_MIN_SPLAT;
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

/* The same of p + s a + t b, s^2 + t^2 <= 1: X with (p_x - X p_z)^2 = (a_x - X a_z)^2 + (b_x - X
 * b_z)^2 touches it. The area is that of the unit circle under [a b p]. */
static bool conic_of(const struct spot_view *view, struct vec3 p, struct vec3 a, struct vec3 b,
                     struct outline *o)
{
    double rest = p.z * p.z - a.z * a.z - b.z * b.z, half[2];
    const double f[2] = { view->fx, view->fy };
    const double px[2] = { p.x, p.y }, ax[2] = { a.x, a.y }, bx[2] = { b.x, b.y };
    if (!(rest > 0))
        return false;
    for (int k = 0; k < 2; k++) {
        double mid = (px[k] * p.z - ax[k] * a.z - bx[k] * b.z) / rest;
        double outer = (px[k] * px[k] - ax[k] * ax[k] - bx[k] * bx[k]) / rest;
        half[k] = f[k] * sqrt(fmax(mid * mid - outer, 0));
        o->low[k] = f[k] * (mid - px[k] / p.z) - half[k];
        o->high[k] = f[k] * (mid - px[k] / p.z) + half[k];
    }
    o->area = M_PI * f[0] * f[1] * fabs(v3_dot(p, v3_cross(a, b))) / (rest * sqrt(rest));
    apply_floor(view, half, o);
    return true;
}

static void parallel_of(const struct spot_view *view, struct vec3 a, struct vec3 b,
                        struct outline *o)
{
    double half[2] = { view->fx * hypot(a.x, b.x), view->fy * hypot(a.y, b.y) };
    o->area = M_PI * view->fx * view->fy * fabs(a.x * b.y - a.y * b.x);
    for (int k = 0; k < 2; k++) {
        o->low[k] = -half[k];
        o->high[k] = half[k];
    }
    apply_floor(view, half, o);
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

/* A splat as the camera sees it: the disc, or the ellipse's half axes a and b. */
struct shape {
    struct vec3 p, n, a, b;
    double radius, reach; /* reach: along the view, from its centre */
    bool ellipse;
};

/* Of what the near plane cuts, as glsl/lib/clipped.glsl bounds it: around the view's axis,
 * quotients of the intervals that hold x, y and z of the part beyond the plane. */
static void cut_outline(const struct spot_view *view, const struct shape *s, struct outline *o)
{
    const double f[2] = { view->fx, view->fy }, at[2] = { s->p.x, s->p.y };
    const double n[2] = { s->n.x, s->n.y };
    const double ellipse[2] = { hypot(s->a.x, s->b.x), hypot(s->a.y, s->b.y) };
    double nearest = fmax(view->near_depth, DBL_MIN), farthest = s->p.z + s->reach;
    for (int k = 0; k < 2; k++) {
        double reach = s->ellipse ? ellipse[k] : s->radius * sqrt(fmax(0, 1 - n[k] * n[k]));
        double low = at[k] - reach, high = at[k] + reach;
        o->low[k] = f[k] * low / (low < 0 ? nearest : farthest);
        o->high[k] = f[k] * high / (high < 0 ? farthest : nearest);
    }
}

static void take_ellipse(const struct spot_view *view, const struct stp_phong_splat *phong,
                         struct shape *s)
{
    struct vec3 u = rotate(view->rotation, v3_loadf(phong->u));
    if (v3_dot(u, u) == 0)
        return;
    s->ellipse = true;
    s->a = v3_scale(u, phong->radius[0]);
    s->b = v3_scale(v3_cross(s->n, u), phong->radius[1]);
    s->reach = hypot(s->a.z, s->b.z);
}

/* Whether culling takes it: an ellipse may bend its normals to the eye. */
static bool faces_away(const struct spot_view *view, const struct stp_phong_splat *phong,
                       const struct shape *s)
{
    struct vec3 towards = view->orthographic ? v3(0, 0, -1) : v3_scale(s->p, -1);
    if (v3_dot(s->n, towards) > 0)
        return false;
    if (!s->ellipse)
        return true;
    struct ellipse e = { .normal = s->n, .turned = 1 };
    e.u = v3_scale(s->a, 1 / (double)phong->radius[0]);
    e.v = v3_scale(s->b, 1 / (double)phong->radius[1]);
    for (int i = 0; i < 2; i++)
        e.radius[i] = phong->radius[i];
    for (int i = 0; i < 4; i++)
        e.field[i] = phong->field[i];
    return !ellipse_faces(&e, towards, view->orthographic);
}

/* False: not in view. */
static bool take_shape(const struct spot_view *view, size_t i, struct shape *s)
{
    const struct splats *splats = &view->scene->splats;
    const struct stp_phong_splat *phong = splats->phong ? &splats->phong[i] : NULL;
    const double *at = splats->position[i], *o = splats->origin;
    struct vec3 p = rotate(view->rotation, v3(at[0] - o[0], at[1] - o[1], at[2] - o[2]));
    *s = (struct shape){ .p = v3_add(p, v3_load(view->translation)), .radius = splats->radius[i] };
    s->n = rotate(view->rotation, v3_loadf(splats->normal[i]));
    if (v3_dot(s->n, s->n) == 0)
        s->n = view->orthographic ? v3(0, 0, -1) : v3_unit(v3_scale(s->p, -1));
    s->reach = s->radius * sqrt(fmax(0, 1 - s->n.z * s->n.z));
    if (phong)
        take_ellipse(view, phong, s);
    if (!(s->p.z + s->reach >= view->near_depth) || s->p.z - s->reach > view->far_depth)
        return false;
    return !view->cull_back || !faces_away(view, phong, s);
}

/* Around the centre's place on the screen; false: cut by the eye plane. */
static bool find_outline(const struct spot_view *view, const struct shape *s, struct vec3 ray,
                         struct outline *o)
{
    if (view->orthographic && s->ellipse)
        parallel_of(view, s->a, s->b, o);
    else if (view->orthographic)
        parallel(view, s->n, s->radius, o);
    else if (s->p.z - s->reach <= view->near_depth)
        return false;
    else
        return s->ellipse ? conic_of(view, s->p, s->a, s->b, o)
                          : conic(view, s->n, ray, s->p.z / s->radius, o);
    return true;
}

bool spot_find(const struct spot_view *view, size_t i, struct spot *spot)
{
    struct shape shape;
    struct outline outline;
    if (!take_shape(view, i, &shape))
        return false;
    struct vec3 p = shape.p, s = view->orthographic ? v3(p.x, p.y, 1) : v3(p.x / p.z, p.y / p.z, 1);
    bool cut = !find_outline(view, &shape, s, &outline);
    if (cut) {
        cut_outline(view, &shape, &outline);
        s = v3(0, 0, 1);
    }
    double x = view->cx + view->fx * s.x, y = view->cy + view->fy * s.y;
    if (!pixels_in(x + outline.low[0], x + outline.high[0], view->width, &spot->x0, &spot->x1) ||
        !pixels_in(y + outline.low[1], y + outline.high[1], view->height, &spot->y0, &spot->y1))
        return false;
    /* As much of the area as of the box is in the picture, in the mean over places of its centre;
     * of what is cut, half of the box. */
    double box = (spot->x1 - spot->x0 + 1.0) * (spot->y1 - spot->y0 + 1.0);
    double whole = (outline.high[0] - outline.low[0]) * (outline.high[1] - outline.low[1]);
    spot->fragments = cut ? 0.5 * box : fmin(outline.area / whole, 1) * box;
    spot->large = cut || box > STP_LARGE_AREA;
    return true;
}

struct counted {
    const struct spot_view *view;
    uint64_t found;
};

static void count_range(void *context, size_t begin, size_t end, unsigned)
{
    struct counted *counted = context;
    struct spot spot;
    uint64_t found = 0;
    for (size_t i = begin; i < end; i++)
        found += spot_find(counted->view, i, &spot);
    __atomic_fetch_add(&counted->found, found, __ATOMIC_RELAXED);
}

uint64_t spot_count(const struct stp_env *env, const struct spot_view *view)
{
    struct counted counted = { .view = view };
    if (view->scene->splats.position)
        parallel_for(env, view->scene->splats.count, 4096, count_range, &counted);
    return counted.found;
}
