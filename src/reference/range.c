/* One ellipsoid of range images and one ray, and what a view makes of it (docs/range.md). */
#include "reference/range.h"

#include <math.h>

#include "base/memory.h"
#include "base/thread.h"
#include "base/log.h"
#include "scene/range.h"

/* The rows that turn the ellipsoid into the unit ball: the inverse of its axes, by cross products.
 */
static void whiten(const struct medium *medium, uint32_t kernel, struct vec3 row[3])
{
    struct vec3 axis[3];
    for (int n = 0; n < 3; n++)
        axis[n] =
            eye_direction(&medium->view->eye, v3_loadf(medium->volume->kernels.axes[kernel][n]));
    double volume = v3_dot(axis[0], v3_cross(axis[1], axis[2]));
    for (int n = 0; n < 3; n++)
        row[n] = v3_scale(v3_cross(axis[(n + 1) % 3], axis[(n + 2) % 3]), 1 / volume);
}

static struct vec3 into_ball(const struct vec3 row[3], struct vec3 v)
{
    return v3(v3_dot(row[0], v), v3_dot(row[1], v), v3_dot(row[2], v));
}

bool ellipsoid_hit(const struct medium *medium, uint32_t kernel, struct vec3 centre, double tau,
                   const struct ray *ray, struct medium_fragment *fragment)
{
    const struct eye *eye = &medium->view->eye;
    struct vec3 row[3];
    whiten(medium, kernel, row);
    struct vec3 e = into_ball(row, v3_sub(ray->start, centre)), u = into_ball(row, ray->along);
    double a = v3_dot(u, u), peak = -v3_dot(e, u) / a;
    struct vec3 d = v3_add(e, v3_scale(u, peak));
    double depth = fmin(fmax(peak, eye->near_depth), eye->far_depth), off = depth - peak;
    if (v3_dot(d, d) + a * off * off > KERNEL_REACH * KERNEL_REACH)
        return false;
    double root = sqrt(0.5 * a);
    double visible =
        0.5 * (erfc((eye->near_depth - peak) * root) - erfc((eye->far_depth - peak) * root));
    double integral =
        v3_length(ray->along) * sqrt(2 * M_PI / a) * exp(-0.5 * v3_dot(d, d)) * visible;
    fragment->depth = depth;
    fragment->alpha = -expm1(-tau * integral);
    return fragment->alpha >= medium->least_alpha;
}

struct vec3 ellipsoid_half(const struct medium *medium, uint32_t kernel)
{
    struct vec3 sum = v3(0, 0, 0);
    for (int n = 0; n < 3; n++) {
        struct vec3 a =
            eye_direction(&medium->view->eye, v3_loadf(medium->volume->kernels.axes[kernel][n]));
        sum = v3_add(sum, v3(a.x * a.x, a.y * a.y, a.z * a.z));
    }
    return v3_scale(v3(sqrt(sum.x), sqrt(sum.y), sqrt(sum.z)), KERNEL_REACH);
}

/* The angle between two directions, as the length of the chord. */
static double chord(struct vec3 a, struct vec3 b)
{
    return 2 * sin(0.5 * atan2(v3_length(v3_cross(a, b)), v3_dot(a, b)));
}

static void look(const struct medium *medium, size_t i, double *tau, double color[3])
{
    const struct kernels *k = &medium->volume->kernels;
    const struct eye *eye = &medium->view->eye;
    struct vec3 sight = eye_view(eye, eye_point(eye, k->place[i])), sum = v3(0, 0, 0);
    double own = 0, all = 0, colors = 0;
    for (size_t n = k->source_first[i]; n < k->source_first[i + 1]; n++) {
        const double *m = medium->volume->range.frame[k->source[n].frame].camera.to_world;
        struct vec3 from = v3_sub(v3_load(k->place[i]), v3(m[3], m[7], m[11]));
        double angle = chord(sight, eye_direction(eye, from));
        double w = (double)k->source[n].weight / (1 + pow(angle / RANGE_ANGLE, 2));
        double c = (double)k->source[n].weight * pow(1 + pow(angle / RANGE_COLOR_ANGLE, 2), -2);
        own = n == k->source_first[i] ? w : own;
        all += w;
        colors += c;
        if (k->source_color)
            sum = v3_add(sum, v3_scale(v3_loadf(k->source_color[n]), c));
    }
    sum = k->source_color ? v3_scale(sum, 1 / colors) : v3_loadf(k->color[i]);
    *tau = (double)k->tau[i] * own / all;
    v3_store(sum, color);
}

static void look_range(void *context, size_t begin, size_t end, unsigned)
{
    struct medium *medium = context;
    for (size_t i = begin; i < end; i++)
        look(medium, i, &medium->tau[i], medium->shaded[i]);
}

enum stp_result ellipsoids_look(const struct stp_env *env, struct medium *medium)
{
    size_t count = medium->volume->kernels.count;
    medium->tau = mem_alloc(count, sizeof *medium->tau);
    if (!medium->tau)
        return log_no_memory(env, count * sizeof *medium->tau, "weighted ellipsoids");
    parallel_for(env, count, 4096, look_range, medium);
    return STP_OK;
}
