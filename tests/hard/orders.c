#include "orders.h"

#define TIE  1e-5
#define STEP 2e-4 /* pixels */
/* Pixels. Where a ray meets a splat is a sum of three terms linear in the pixel (s.x dx + s.y dy +
 * s.z, lib/gaussian.glsl), each rounded to 2^-24 of itself and none beyond the picture's 112
 * pixels: 3 x 112 x 2^-24. */
#define MOVED 2e-5

/* A splat's place in an order: the least is the nearest; of equal ones the first is. */
struct place {
    double key;
    uint32_t id;
};

static int by_place(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

/* Voxels of one sheet are equally far along its axis. */
static double key_of(const struct drawn *d, uint32_t id, unsigned order)
{
    uint32_t at[3];
    double sign = order & 1 ? -1 : 1;
    if (order == ORDER_SORTED) {
        struct vec3 c = d->disc ? d->disc[id].centre : medium_centre(&d->medium, id);
        return d->view.eye.orthographic ? -c.z : v3_length(c);
    }
    if (d->disc)
        return sign * d->view.scene->splats.position[id][order / 2];
    voxel_place(&d->medium.volume->grid, d->medium.volume->kernels.voxel[id], at);
    return sign * at[order / 2];
}

/* How near each splat is in each order, from 0. */
static uint32_t *rank_splats(const struct drawn *d)
{
    struct place *places = malloc(d->count * sizeof *places);
    uint32_t *rank = malloc(ORDERS * d->count * sizeof *rank);
    assert_true(places && rank);
    for (unsigned order = 0; order < ORDERS; order++) {
        for (uint32_t i = 0; i < d->count; i++)
            places[i] = (struct place){ key_of(d, i, order), i };
        qsort(places, d->count, sizeof *places, by_place);
        for (uint32_t i = 0; i < d->count; i++)
            rank[order * d->count + places[i].id] = i;
    }
    free(places);
    return rank;
}

/* A pixel's centre, and around it as far as rounding may move it. */
#define PLACES 5
static const double aside[PLACES][2] = {
    { 0, 0 }, { -STEP, -STEP }, { STEP, -STEP }, { -STEP, STEP }, { STEP, STEP }
};

struct seen {
    uint32_t rank; /* in the order that is composited */
    uint32_t id;
    struct drawn_fragment at[PLACES];
};

static int far_first(const void *a, const void *b)
{
    const struct seen *x = a, *y = b;
    return (x->rank < y->rank) - (x->rank > y->rank);
}

/* The pixel's fragments; fragile where one is there at some of the places only. */
static size_t find_seen(const struct drawn *d, const double (*bounds)[4], uint32_t x, uint32_t y,
                        struct seen *seen, bool *fragile)
{
    size_t count = 0;
    for (uint32_t id = 0; id < d->count; id++) {
        const double *b = bounds[id];
        struct seen *s = &seen[count];
        unsigned hits = 0;
        if (x + 1 < b[0] || x > b[1] || y + 1 < b[2] || y > b[3])
            continue;
        for (int n = 0; n < PLACES; n++)
            hits += drawn_hit(d, id, x + 0.5 + aside[n][0], y + 0.5 + aside[n][1], &s->at[n]);
        s->id = id;
        count += hits == PLACES;
        *fragile = *fragile || (hits > 0 && hits < PLACES);
    }
    return count;
}

static void composite(const struct drawn *d, const struct seen *seen, size_t count, int place,
                      double sum[5])
{
    memset(sum, 0, 5 * sizeof *sum);
    for (size_t i = 0; i < count; i++)
        drawn_over(&seen[i].at[place], sum);
    drawn_divide(d, sum);
}

/* How far the places around the centre are from it. */
static double slope_of(const struct drawn *d, const struct seen *seen, size_t count,
                       const double sum[5])
{
    double most = 0, one[5];
    for (int place = 1; place < PLACES; place++) {
        composite(d, seen, count, place, one);
        for (int n = 0; n < 5; n++)
            most = fmax(most, fabs(one[n] - sum[n]));
    }
    return most;
}

static void make_pixel(struct orders *o, const struct drawn *d, const double (*bounds)[4],
                       const uint32_t *rank, struct seen *seen, size_t at)
{
    uint32_t x = (uint32_t)(at % d->view.width), y = (uint32_t)(at / d->view.width);
    size_t count = find_seen(d, bounds, x, y, seen, &o->fragile[at]);
    for (unsigned order = 0; order < ORDERS; order++) {
        for (size_t i = 0; i < count; i++)
            seen[i].rank = rank[order * d->count + seen[i].id];
        qsort(seen, count, sizeof *seen, far_first);
        composite(d, seen, count, 0, o->sum[at][order]);
        if (d->disc)
            o->slope[at] =
                fmax(o->slope[at], MOVED / STEP * slope_of(d, seen, count, o->sum[at][order]));
    }
}

static void make_pixels(struct orders *o, const struct drawn *d)
{
    double(*bounds)[4] = malloc(d->count * sizeof *bounds);
    struct seen *seen = malloc(d->count * sizeof *seen);
    uint32_t *rank = rank_splats(d);
    static const double nowhere[4] = { 1, 0, 1, 0 };
    assert_true(bounds && seen);
    for (uint32_t i = 0; i < d->count; i++)
        if (!drawn_bounds(d, i, bounds[i]))
            memcpy(bounds[i], nowhere, sizeof nowhere);
    for (size_t at = 0; at < o->pixels; at++)
        make_pixel(o, d, (const double(*)[4])bounds, rank, seen, at);
    free(bounds);
    free(seen);
    free(rank);
}

struct orders orders_make(const struct stp_scene *scene, const struct stp_camera *camera,
                          const struct stp_render_params *params)
{
    struct orders o = { .pixels = (size_t)camera->width * camera->height };
    struct drawn d;
    drawn_make(scene, camera, params, &d);
    o.sum = calloc(o.pixels, sizeof *o.sum);
    o.ray = calloc(o.pixels, sizeof *o.ray);
    o.slope = calloc(o.pixels, sizeof *o.slope);
    o.fragile = calloc(o.pixels, sizeof *o.fragile);
    assert_true(o.sum && o.ray && o.slope && o.fragile);
    o.forward = eye_direction_to_world(&d.view.eye, v3(0, 0, -1));
    for (size_t i = 0; i < o.pixels; i++)
        o.ray[i] = eye_direction_to_world(
            &d.view.eye,
            eye_ray(&d.view.eye, i % camera->width + 0.5, i / camera->width + 0.5).along);
    make_pixels(&o, &d);
    drawn_release(&d);
    return o;
}

void orders_release(struct orders *o)
{
    free(o->sum);
    free(o->ray);
    free(o->slope);
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

static double distance(const struct orders *o, const struct stp_image *image, size_t at,
                       const double right[5])
{
    static const char *const names[] = { "R", "G", "B", "A" };
    double z = stp_image_find(image, "Z")->data.f[at], worst = 0;
    for (int n = 0; n < 4; n++)
        worst = fmax(worst, fabs(stp_image_find(image, names[n])->data.f[at] - right[n]));
    if (isfinite(z) != (stp_image_find(image, "A")->data.f[at] > 0))
        return INFINITY;
    if (isfinite(z))
        worst = fmax(worst, fabs(z * right[3] - right[4]) / fmax(1, z));
    return fmax(0, worst - o->slope[at]);
}

/* The nearest of the orders of all axes that v may have as its dominant one. */
static double nearest_order(const struct orders *o, const struct stp_image *image, size_t at)
{
    double best = INFINITY, share;
    for (unsigned axis = 0; axis < 3; axis++) {
        unsigned order = order_along(o->ray[at], axis, &share);
        if (share >= 1 - TIE)
            best = fmin(best, distance(o, image, at, o->sum[at][order]));
    }
    return best;
}

static double pixel_error(const struct orders *o, const struct stp_image *image,
                          enum stp_axis_merge merge, double h, size_t at)
{
    double right[5];
    if (merge == STP_AXIS_SORT)
        return distance(o, image, at, o->sum[at][ORDER_SORTED]);
    if (merge == STP_AXIS_CLIP)
        return nearest_order(o, image, at);
    blend(o->sum[at], o->ray[at], h, right);
    return distance(o, image, at, right);
}

static double single_error(const struct orders *o, const struct stp_image *image)
{
    double best = INFINITY, share;
    for (unsigned axis = 0; axis < 3; axis++) {
        unsigned order = order_along(o->forward, axis, &share);
        double worst = 0;
        for (size_t i = 0; i < o->pixels; i++)
            if (!o->fragile[i])
                worst = fmax(worst, distance(o, image, i, o->sum[i][order]));
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
