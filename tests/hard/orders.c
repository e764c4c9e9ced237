#include "orders.h"

#define TIE  1e-5
#define STEP 2e-4 /* pixels */

/* A kernel's place in an order: the least is the nearest; of equal ones the first voxel is. */
struct place {
    double key;
    uint32_t kernel;
};

static int by_place(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->kernel > y->kernel) - (x->kernel < y->kernel);
}

static double key_of(const struct medium *medium, uint32_t kernel, unsigned order)
{
    uint32_t at[3];
    struct vec3 c = medium_centre(medium, kernel);
    if (order == ORDER_SORTED)
        return medium->view->eye.orthographic ? -c.z : v3_length(c);
    voxel_place(&medium->volume->grid, medium->volume->kernels.voxel[kernel], at);
    return order & 1 ? -(double)at[order / 2] : at[order / 2];
}

static struct place *sort_kernels(const struct medium *medium, unsigned order)
{
    size_t count = medium->volume->kernels.count;
    struct place *places = malloc(count * sizeof *places);
    assert_non_null(places);
    for (uint32_t i = 0; i < count; i++)
        places[i] = (struct place){ key_of(medium, i, order), i };
    qsort(places, count, sizeof *places, by_place);
    return places;
}

static bool hits(const struct medium *medium, uint32_t kernel, double px, double py,
                 struct medium_fragment *f)
{
    struct ray ray = eye_ray(&medium->view->eye, px, py);
    f->kernel = kernel;
    return medium_hit(medium, medium_centre(medium, kernel),
                      (double)medium->volume->kernels.tau[kernel], &ray, f);
}

/* Whether rounding decides if there is a fragment. */
static bool on_an_edge(const struct medium *medium, uint32_t kernel, double px, double py)
{
    struct medium_fragment f;
    bool here = hits(medium, kernel, px, py, &f);
    for (int i = 0; i < 4; i++)
        if (hits(medium, kernel, px + (i & 1 ? STEP : -STEP), py + (i & 2 ? STEP : -STEP), &f) !=
            here)
            return true;
    return false;
}

static void add_kernel(struct orders *o, const struct medium *medium, unsigned order,
                       uint32_t kernel)
{
    const struct view *view = medium->view;
    double b[4];
    if (!medium_bounds(medium, kernel, medium_centre(medium, kernel), b))
        return;
    for (uint32_t y = (uint32_t)fmax(0, floor(b[2] - 1)); y < view->height && y < b[3] + 1; y++)
        for (uint32_t x = (uint32_t)fmax(0, floor(b[0] - 1)); x < view->width && x < b[1] + 1;
             x++) {
            size_t at = (size_t)y * view->width + x;
            struct medium_fragment f;
            if (hits(medium, kernel, x + 0.5, y + 0.5, &f))
                composite_over(medium, &f, o->sum[at][order]);
            if (order == ORDER_SORTED && on_an_edge(medium, kernel, x + 0.5, y + 0.5))
                o->fragile[at] = true;
        }
}

struct orders orders_make(const struct stp_scene *scene, const struct stp_camera *camera)
{
    struct view view = { .scene = scene,
                         .width = camera->width,
                         .height = camera->height,
                         .grid = 1,
                         .two_sided = true };
    struct orders o = { .pixels = (size_t)camera->width * camera->height };
    struct medium medium;
    eye_init(&view.eye, camera, scene->splats.origin);
    assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
    o.sum = calloc(o.pixels, sizeof *o.sum);
    o.ray = calloc(o.pixels, sizeof *o.ray);
    o.fragile = calloc(o.pixels, sizeof *o.fragile);
    assert_true(o.sum && o.ray && o.fragile);
    o.forward = eye_direction_to_world(&view.eye, v3(0, 0, -1));
    for (size_t i = 0; i < o.pixels; i++)
        o.ray[i] = eye_direction_to_world(
            &view.eye, eye_ray(&view.eye, i % view.width + 0.5, i / view.width + 0.5).along);
    for (unsigned order = 0; order < ORDERS; order++) {
        struct place *places = sort_kernels(&medium, order);
        for (size_t i = scene->volume->kernels.count; i-- > 0;)
            add_kernel(&o, &medium, order, places[i].kernel);
        free(places);
    }
    medium_release(&medium);
    return o;
}

void orders_release(struct orders *o)
{
    free(o->sum);
    free(o->ray);
    free(o->fragile);
    *o = (struct orders){ 0 };
}

/* The order along an axis for rays of direction v, and the axis' share of the dominant one. */
static unsigned order_along(struct vec3 v, unsigned axis, double *share)
{
    const double size[3] = { v.x, v.y, v.z };
    *share = fabs(size[axis]) / fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    return 2 * axis + (size[axis] < 0);
}

/* HM Eq. 1. */
static void blend(const double sum[ORDERS][5], struct vec3 v, double h, double out[5])
{
    double weights = 0;
    memset(out, 0, 5 * sizeof *out);
    for (unsigned axis = 0; axis < 3; axis++) {
        double share;
        unsigned order = order_along(v, axis, &share);
        double w = fmax(0, (share - h) / (1 - h));
        for (int n = 0; n < 5; n++)
            out[n] += w * w * sum[order][n];
        weights += w * w;
    }
    for (int n = 0; n < 5; n++)
        out[n] /= weights;
}

static double distance(const struct stp_image *image, size_t at, const double right[5])
{
    static const char *const names[] = { "R", "G", "B", "A" };
    double z = stp_image_find(image, "Z")->data.f[at], worst = 0;
    for (int n = 0; n < 4; n++)
        worst = fmax(worst, fabs(stp_image_find(image, names[n])->data.f[at] - right[n]));
    if (isfinite(z) != (stp_image_find(image, "A")->data.f[at] > 0))
        return INFINITY;
    if (isfinite(z))
        worst = fmax(worst, fabs(z * right[3] - right[4]) / fmax(1, z));
    return worst;
}

/* The nearest of the orders of all axes that v may have as its dominant one. */
static double nearest_order(const double sum[ORDERS][5], struct vec3 v,
                            const struct stp_image *image, size_t at)
{
    double best = INFINITY, share;
    for (unsigned axis = 0; axis < 3; axis++) {
        unsigned order = order_along(v, axis, &share);
        if (share >= 1 - TIE)
            best = fmin(best, distance(image, at, sum[order]));
    }
    return best;
}

static double pixel_error(const struct orders *o, const struct stp_image *image,
                          enum stp_axis_merge merge, double h, size_t at)
{
    double right[5];
    if (merge == STP_AXIS_SORT)
        return distance(image, at, o->sum[at][ORDER_SORTED]);
    if (merge == STP_AXIS_CLIP)
        return nearest_order(o->sum[at], o->ray[at], image, at);
    blend(o->sum[at], o->ray[at], h, right);
    return distance(image, at, right);
}

static double single_error(const struct orders *o, const struct stp_image *image)
{
    double best = INFINITY, share;
    for (unsigned axis = 0; axis < 3; axis++) {
        unsigned order = order_along(o->forward, axis, &share);
        double worst = 0;
        for (size_t i = 0; i < o->pixels; i++)
            if (!o->fragile[i])
                worst = fmax(worst, distance(image, i, o->sum[i][order]));
        if (share >= 1 - TIE)
            best = fmin(best, worst);
    }
    return best;
}

double orders_error(const struct orders *o, const struct stp_image *image,
                    enum stp_axis_merge merge, double h)
{
    double worst = 0;
    if (merge == STP_AXIS_SINGLE)
        return single_error(o, image);
    for (size_t i = 0; i < o->pixels; i++)
        if (!o->fragile[i])
            worst = fmax(worst, pixel_error(o, image, merge, h, i));
    return worst;
}
