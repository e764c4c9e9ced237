/* One kernel and one ray: the line integral of a Gaussian, exactly, in perspective. */
#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "reference/range.h"
#include "reference/volume.h"

/* In deviations of a kernel along the grid's axes: what is long in one and short in another keeps
 * its digits, as it would not as a quadratic form. */
static struct vec3 in_deviations(const struct medium *medium, struct vec3 v)
{
    return v3(v3_dot(medium->axis[0], v), v3_dot(medium->axis[1], v), v3_dot(medium->axis[2], v));
}

static void set_shape(struct medium *medium)
{
    const double *spacing = medium->volume->grid.spacing;
    double half[3] = { 0 };
    for (int axis = 0; axis < 3; axis++) {
        double s = KERNEL_SIGMA * spacing[axis];
        struct vec3 a = eye_direction(&medium->view->eye, v3(axis == 0, axis == 1, axis == 2));
        medium->axis[axis] = v3_scale(a, 1 / s);
        half[0] += s * s * a.x * a.x;
        half[1] += s * s * a.y * a.y;
        half[2] += s * s * a.z * a.z;
    }
    medium->half = v3_scale(v3(sqrt(half[0]), sqrt(half[1]), sqrt(half[2])), KERNEL_REACH);
    medium->amplitude = kernel_amplitude();
}

struct vec3 medium_centre(const struct medium *medium, uint32_t kernel)
{
    const struct grid *grid = &medium->volume->grid;
    uint32_t at[3];
    double world[3];
    if (volume_is_range(medium->volume))
        return eye_point(&medium->view->eye, medium->volume->kernels.place[kernel]);
    voxel_place(grid, medium->volume->kernels.voxel[kernel], at);
    for (int axis = 0; axis < 3; axis++)
        world[axis] = grid->origin[axis] + at[axis] * grid->spacing[axis];
    return eye_point(&medium->view->eye, world);
}

static void shade_range(void *context, size_t begin, size_t end, unsigned)
{
    struct medium *medium = context;
    const struct kernels *k = &medium->volume->kernels;
    for (size_t i = begin; i < end; i++) {
        struct vec3 albedo = v3_loadf(k->color[i]), c = albedo;
        struct vec3 n = k->normal ? v3_loadf(k->normal[i]) : v3(0, 0, 0);
        if (n.x != 0 || n.y != 0 || n.z != 0) {
            struct vec3 point = medium_centre(medium, (uint32_t)i);
            n = v3_unit(eye_direction(&medium->view->eye, n));
            if (v3_dot(n, eye_view(&medium->view->eye, point)) > 0)
                n = v3_scale(n, -1);
            struct surface lit = { .normal = n, .point = point, .albedo = albedo };
            c = surface_shade(medium->view, &lit);
        }
        v3_store(c, medium->shaded[i]);
    }
}

enum stp_result medium_init(const struct stp_env *env, const struct view *view,
                            struct medium *medium)
{
    const struct volume *volume = view->scene->volume;
    struct medium made = { .view = view, .volume = volume, .least_alpha = LEAST_ALPHA };
    bool range = volume_is_range(volume);
    if (!range)
        set_shape(&made);
    made.shaded = mem_alloc(volume->kernels.count, sizeof *made.shaded);
    if (!made.shaded)
        return log_no_memory(env, volume->kernels.count * sizeof *made.shaded, "shaded kernels");
    enum stp_result result = range ? ellipsoids_look(env, &made) : STP_OK;
    if (result != STP_OK) {
        mem_free(made.shaded);
        return result;
    }
    if (!range)
        parallel_for(env, volume->kernels.count, 4096, shade_range, &made);
    *medium = made;
    return STP_OK;
}

void medium_release(struct medium *medium)
{
    mem_free(medium->shaded);
    mem_free(medium->tau);
    medium->shaded = NULL;
    medium->tau = NULL;
}

/* The share of a Gaussian around 0 of deviation 1 / (sqrt 2 root) that lies in [from, to]. */
static double share(double from, double to, double root)
{
    if (from * root < -6 && to * root > 6)
        return 1; /* to the last bit */
    return 0.5 * (erfc(from * root) - erfc(to * root));
}

bool medium_hit(const struct medium *medium, struct vec3 centre, double tau, const struct ray *ray,
                struct medium_fragment *fragment)
{
    const struct eye *eye = &medium->view->eye;
    struct vec3 e = in_deviations(medium, v3_sub(ray->start, centre));
    struct vec3 along = in_deviations(medium, ray->along);
    double a = v3_dot(along, along), peak = -v3_dot(e, along) / a;
    /* From the nearest point, not as a difference of squares: a far kernel keeps its digits. */
    struct vec3 d = v3_add(e, v3_scale(along, peak));
    double m2 = v3_dot(d, d);
    double depth = fmin(fmax(peak, eye->near_depth), eye->far_depth);
    if (m2 + a * (depth - peak) * (depth - peak) > KERNEL_REACH * KERNEL_REACH)
        return false;
    double visible = share(eye->near_depth - peak, eye->far_depth - peak, sqrt(0.5 * a));
    double integral =
        medium->amplitude * v3_length(ray->along) * sqrt(2 * M_PI / a) * exp(-0.5 * m2) * visible;
    fragment->depth = depth;
    fragment->alpha = -expm1(-tau * integral);
    return fragment->alpha >= medium->least_alpha;
}

bool medium_hit_kernel(const struct medium *medium, uint32_t kernel, struct vec3 centre,
                       const struct ray *ray, struct medium_fragment *fragment)
{
    if (medium->tau)
        return ellipsoid_hit(medium, kernel, centre, medium->tau[kernel], ray, fragment);
    return medium_hit(medium, centre, (double)medium->volume->kernels.tau[kernel], ray, fragment);
}

/* Where x / z can lie for x in [low, high], z in [near, far], both positive. */
static void quotients(double low, double high, double near, double far, double out[2])
{
    out[0] = low / (low < 0 ? near : far);
    out[1] = high / (high > 0 ? near : far);
}

bool medium_bounds(const struct medium *medium, uint32_t kernel, struct vec3 c, double bounds[4])
{
    const struct eye *eye = &medium->view->eye;
    struct vec3 h = medium->tau ? ellipsoid_half(medium, kernel) : medium->half;
    double near = fmax(-c.z - h.z, eye->near_depth), far = fmin(-c.z + h.z, eye->far_depth);
    double x[2] = { c.x - h.x, c.x + h.x }, y[2] = { -c.y - h.y, -c.y + h.y };
    if (!(near <= far))
        return false;
    if (!eye->orthographic) {
        quotients(x[0], x[1], near, far, x);
        quotients(y[0], y[1], near, far, y);
    }
    for (int i = 0; i < 2; i++) {
        bounds[i] = eye->cx + eye->fx * x[i];
        bounds[2 + i] = eye->cy + eye->fy * y[i];
    }
    return true;
}
