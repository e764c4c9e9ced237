#include "drawn.h"

#define LEAST 1e-4 /* HM 5: what is fainter is dropped */

/* Lit once, at its centre, by its own normal there. */
static struct vec3 light_of(const struct view *view, uint32_t id, const struct disc *disc)
{
    const struct fragment centre = { .s = 0, .t = 0 };
    struct surface lit = { .normal = fragment_normal(disc, &centre),
                           .point = disc->centre,
                           .albedo = splat_albedo(view, id),
                           .id = id };
    return surface_shade(view, &lit);
}

static void make_surface(struct drawn *d)
{
    d->count = d->view.scene->splats.count;
    d->disc = calloc(d->count, sizeof *d->disc);
    d->light = calloc(d->count, sizeof *d->light);
    assert_true(d->disc && d->light);
    for (uint32_t i = 0; i < d->count; i++)
        if (disc_setup(&d->view, i, &d->disc[i]))
            d->light[i] = light_of(&d->view, i, &d->disc[i]);
        else
            d->disc[i].radius = 0;
}

void drawn_make(const struct stp_scene *scene, const struct stp_camera *camera,
                const struct stp_render_params *params, struct drawn *d)
{
    *d = (struct drawn){ .view = reference_view(scene, camera, params) };
    if (!scene->volume) {
        make_surface(d);
        return;
    }
    d->count = scene->volume->kernels.count;
    assert_int_equal(medium_init(NULL, &d->view, &d->medium), STP_OK);
}

void drawn_release(struct drawn *d)
{
    if (d->view.scene->volume)
        medium_release(&d->medium);
    free(d->disc);
    free(d->light);
    *d = (struct drawn){ 0 };
}

static bool hit_disc(const struct drawn *d, uint32_t id, double px, double py,
                     struct drawn_fragment *f)
{
    struct fragment hit;
    struct ray ray = eye_ray(&d->view.eye, px, py);
    if (!(d->disc[id].radius > 0) || !disc_hit(&d->disc[id], &d->view.eye, &ray, px, py, &hit))
        return false;
    const struct vec3 c = d->light[id];
    *f = (struct drawn_fragment){ splat_opacity(&d->view, id) * exp(-2 * hit.rho2),
                                  { c.x, c.y, c.z, 1, hit.depth } };
    return f->alpha >= LEAST;
}

bool drawn_hit(const struct drawn *d, uint32_t id, double px, double py, struct drawn_fragment *f)
{
    struct medium_fragment hit;
    if (d->disc)
        return hit_disc(d, id, px, py, f);
    struct ray ray = eye_ray(&d->view.eye, px, py);
    if (!medium_hit_kernel(&d->medium, id, medium_centre(&d->medium, id), &ray, &hit))
        return false;
    const double *c = d->medium.shaded[id];
    *f = (struct drawn_fragment){ hit.alpha, { c[0], c[1], c[2], 1, hit.depth } };
    return true;
}

bool drawn_bounds(const struct drawn *d, uint32_t id, double bounds[4])
{
    if (!d->disc)
        return medium_bounds(&d->medium, id, medium_centre(&d->medium, id), bounds);
    const struct disc *disc = &d->disc[id];
    const double box[4] = { disc->x_min, disc->x_max, disc->y_min, disc->y_max };
    memcpy(bounds, box, sizeof box);
    return disc->radius > 0;
}

void drawn_over(const struct drawn_fragment *f, double sum[5])
{
    for (int n = 0; n < 5; n++)
        sum[n] = f->alpha * f->own[n] + (1 - f->alpha) * sum[n];
}

void drawn_divide(const struct drawn *d, double sum[5])
{
    const struct stp_scene *scene = d->view.scene;
    bool covers = scene->volume ? volume_is_range(scene->volume) : !scene->facts.transparent;
    if (!covers || !(sum[3] > 0))
        return;
    double scale = fmin(1, 2 * sum[3]) / sum[3];
    for (int n = 0; n < 5; n++)
        sum[n] *= scale;
}

static bool is_clear(const struct drawn *d, uint32_t id, double px, double py, double near,
                     bool hit)
{
    struct drawn_fragment unused;
    for (int n = 0; n < 4; n++)
        if (drawn_hit(d, id, px + (n % 2 ? near : -near), py + (n / 2 ? near : -near), &unused) !=
            hit)
            return false;
    return true;
}

static bool composite(const struct drawn *d, const uint32_t *order, uint32_t count, double px,
                      double py, double near, double sum[5])
{
    memset(sum, 0, 5 * sizeof *sum);
    for (uint32_t i = 0; i < count; i++) {
        struct drawn_fragment f;
        bool hit = drawn_hit(d, order[i], px, py, &f);
        if (near > 0 && !is_clear(d, order[i], px, py, near, hit))
            return false;
        if (hit)
            drawn_over(&f, sum);
    }
    return true;
}

/* The weight of a walk on a ray of world direction v, HM 5.2: (v_axis / max - h) / (1 - h), or 0.
 * Clip: 1 where it is the dominant one, the first of equal ones. */
static double walk_weight(const struct axis_lists *lists, const struct axis_walk *walk,
                          struct vec3 v)
{
    const double along[3] = { v.x, v.y, v.z };
    double most = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    double own = along[walk->axis] * (walk->backwards ? -1 : 1) / most;
    if (lists->merge == STP_AXIS_SINGLE || lists->merge == STP_AXIS_SORT)
        return 1;
    if (lists->merge == STP_AXIS_CLIP)
        return axis_dominant(v) == walk->axis && own > 0 ? 1 : 0;
    return own > lists->h ? (own - lists->h) / (1 - lists->h) : 0;
}

bool drawn_merge(const struct drawn *d, const struct axis_lists *lists, uint32_t x, uint32_t y,
                 double near, double sum[5])
{
    struct ray ray = eye_ray(&d->view.eye, x + 0.5, y + 0.5);
    struct vec3 v = eye_direction_to_world(&d->view.eye, ray.along);
    double weights = 0;
    memset(sum, 0, 5 * sizeof *sum);
    for (unsigned w = 0; w < lists->walk_count; w++) {
        const struct axis_walk *walk = &lists->walk[w];
        double weight = pow(walk_weight(lists, walk, v), 2), one[5];
        if (!composite(d, lists->order + walk->first, walk->count, x + 0.5, y + 0.5, near, one))
            return false;
        weights += weight;
        for (int n = 0; n < 5; n++)
            sum[n] += weight * one[n];
    }
    for (int n = 0; n < 5; n++)
        sum[n] = weights > 0 ? sum[n] / weights : 0;
    drawn_divide(d, sum);
    return true;
}

void drawn_expect(const double sum[5], const struct stp_image *image, uint32_t x, uint32_t y,
                  double color, double seen, double depth)
{
    static const char *const names[] = { "R", "G", "B", "A" };
    double z = (double)value(image, "Z", x, y), right = sum[4] / sum[3];
    for (int n = 0; n < 4; n++)
        close_to((double)value(image, names[n], x, y), sum[n], color);
    if (sum[3] > seen)
        close_to(z, right, depth * fmax(1, fabs(right)));
    assert_true(isfinite(z) == (value(image, "A", x, y) > 0));
}
