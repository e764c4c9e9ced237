#include "winners.h"

#include "reference/eye.h"

#define GUARD 64u /* pixels beyond the picture's edges, whose points count too */
#define NONE  UINT32_MAX

struct point {
    struct vec3 center, normal;
    double radius;
};

struct field {
    struct eye eye;
    uint32_t width, height; /* with the guard */
    uint32_t *winner;
    float *depth;
};

/* False: culled, or outside near and far. */
static bool load_point(const struct field *f, const struct stp_scene *scene, bool culled, size_t i,
                       struct point *p)
{
    const struct splats *s = &scene->splats;
    struct vec3 n = eye_direction(&f->eye, v3_loadf(s->normal[i]));
    struct vec3 c = eye_point(&f->eye, s->position[i]), view = eye_view(&f->eye, c);
    n = v3_length(n) < 0.5 ? v3_scale(v3_unit(view), -1) : n; /* unknown: faces the eye */
    *p = (struct point){ c, n, (double)s->radius[i] };
    return -c.z >= f->eye.near_depth && -c.z <= f->eye.far_depth &&
           !(culled && v3_dot(n, view) >= 0);
}

static void place(const struct eye *e, struct vec3 c, double at[2])
{
    double over = e->orthographic ? 1 : -c.z;
    at[0] = e->cx + e->fx * c.x / over;
    at[1] = e->cy - e->fy * c.y / over;
}

/* Nearer than what its pixel holds; of equal depths the one that came first stays. */
static void take(struct field *f, const struct point *p, uint32_t id)
{
    double at[2], x, y;
    place(&f->eye, p->center, at);
    x = floor(at[0]) + GUARD;
    y = floor(at[1]) + GUARD;
    if (!(x >= 0 && y >= 0 && x < f->width && y < f->height))
        return;
    size_t pixel = (size_t)y * f->width + (size_t)x;
    float depth = (float)-p->center.z;
    if (f->winner[pixel] != NONE && f->depth[pixel] <= depth)
        return;
    f->winner[pixel] = id;
    f->depth[pixel] = depth;
}

/* Depth at which the ray of a pixel's centre meets the disc; INFINITY: it does not. */
static double meet(const struct eye *e, const struct point *p, double x, double y)
{
    struct ray ray = eye_ray(e, x + 0.5, y + 0.5);
    double t = v3_dot(p->normal, v3_sub(p->center, ray.start)) / v3_dot(p->normal, ray.along);
    double away = v3_length(v3_sub(ray_at(&ray, t), p->center));
    double pixel = (e->orthographic ? 1 : t) / fmin(e->fx, e->fy);
    double facing = fabs(v3_dot(p->normal, v3_unit(ray.along)));
    double rounded = 1e-3 * (p->radius + pixel / facing);
    bool hit = t >= e->near_depth && t <= e->far_depth && away <= p->radius - rounded;
    return hit ? t : INFINITY;
}

static void cover(const struct field *f, const struct point *p, struct winners *w)
{
    const struct eye *e = &f->eye;
    double at[2], z = -p->center.z;
    double nearest = e->orthographic ? 1 : fmax(z - p->radius, 0.5 * z);
    double reach = fmin(p->radius * fmax(e->fx, e->fy) / nearest + 1, 255);
    place(e, p->center, at);
    double right = fmin(at[0] + reach, w->width - 1.0),
           below = fmin(at[1] + reach, w->height - 1.0);
    for (double y = fmax(floor(at[1] - reach), 0); y <= below; y++)
        for (double x = fmax(floor(at[0] - reach), 0); x <= right; x++) {
            double depth = meet(e, p, x, y);
            size_t i = (size_t)y * w->width + (size_t)x;
            if (depth >= w->depth[i])
                continue;
            w->depth[i] = depth;
            w->reach[i] = depth + p->radius;
        }
}

static void *must(void *pointer)
{
    assert_non_null(pointer);
    return pointer;
}

static struct winners nothing(const struct stp_camera *camera)
{
    struct winners w = { .width = camera->width, .height = camera->height };
    size_t seen = (size_t)w.width * w.height;
    w.depth = must(malloc(seen * sizeof *w.depth));
    w.reach = must(malloc(seen * sizeof *w.reach));
    for (size_t i = 0; i < seen; i++)
        w.depth[i] = w.reach[i] = INFINITY;
    return w;
}

struct winners winners_of_all(const struct stp_scene *scene, const struct stp_camera *camera,
                              const struct stp_render_params *params)
{
    struct winners w = nothing(camera);
    struct field f = { 0 };
    struct point p;
    eye_init(&f.eye, camera, scene->splats.origin);
    for (size_t i = 0; i < scene->splats.count; i++)
        if (load_point(&f, scene, params->cull == STP_CULL_BACK, i, &p))
            cover(&f, &p, &w);
    return w;
}

struct winners winners_find(const struct stp_scene *scene, const struct stp_camera *camera,
                            const struct stp_render_params *params)
{
    struct field f = { .width = camera->width + 2 * GUARD, .height = camera->height + 2 * GUARD };
    struct winners w = nothing(camera);
    size_t all = (size_t)f.width * f.height;
    bool culled = params->cull == STP_CULL_BACK;
    struct point p;
    f.winner = must(malloc(all * sizeof *f.winner));
    f.depth = must(malloc(all * sizeof *f.depth));
    memset(f.winner, 0xff, all * sizeof *f.winner);
    eye_init(&f.eye, camera, scene->splats.origin);
    for (size_t i = 0; i < scene->splats.count; i++)
        if (load_point(&f, scene, culled, i, &p))
            take(&f, &p, (uint32_t)i);
    for (size_t i = 0; i < all; i++)
        if (f.winner[i] != NONE && load_point(&f, scene, culled, f.winner[i], &p))
            cover(&f, &p, &w);
    free(f.winner);
    free(f.depth);
    return w;
}

void winners_release(struct winners *winners)
{
    free(winners->depth);
    free(winners->reach);
    *winners = (struct winners){ 0 };
}
