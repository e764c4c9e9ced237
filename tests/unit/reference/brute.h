/* An evaluation that has no tiles, no bounds and no camera frame: every splat at every pixel, in
 * the world, with tangents; fragments sorted. */
#ifndef TEST_REFERENCE_BRUTE_H
#define TEST_REFERENCE_BRUTE_H

#include "fixture.h"

struct hit {
    double depth, rho2;
    size_t id;
    struct vec3 normal;
};

struct brute {
    struct fixture *fixture;
    struct stp_camera camera;
    struct stp_render_params params;
    struct vec3 eye, right, up, back; /* the camera in the world */
};

static inline struct brute brute_of(struct fixture *f, const struct stp_camera *camera,
                                    const struct stp_render_params *params)
{
    const double *m = camera->world_to_camera;
    struct brute b = { .fixture = f, .camera = *camera, .params = *params };
    b.right = v3(m[0], m[1], m[2]);
    b.up = v3(m[4], m[5], m[6]);
    b.back = v3(m[8], m[9], m[10]);
    b.eye = v3_scale(b.right, -m[3]);
    b.eye = v3_sub(b.eye, v3_scale(b.up, m[7]));
    b.eye = v3_sub(b.eye, v3_scale(b.back, m[11]));
    return b;
}

/* A ray in the world; its parameter is the eye depth. */
static inline void world_ray(const struct brute *b, uint32_t i, uint32_t j, struct vec3 *from,
                             struct vec3 *along)
{
    double x = (i + 0.5 - b->camera.cx) / b->camera.fx, y = (b->camera.cy - j - 0.5) / b->camera.fy;
    struct vec3 side = v3_add(v3_scale(b->right, x), v3_scale(b->up, y));
    *from = b->camera.orthographic ? v3_add(b->eye, side) : b->eye;
    *along = v3_scale(b->back, -1);
    if (!b->camera.orthographic)
        *along = v3_add(*along, side);
}

static inline bool meets(const struct brute *b, size_t id, struct vec3 from, struct vec3 along,
                         struct hit *hit)
{
    const struct fixture *f = b->fixture;
    struct vec3 p = v3_load(f->position[id]), n = v3_unit(v3_loadf(f->normal[id]));
    struct vec3 to_eye = b->camera.orthographic ? b->back : v3_sub(b->eye, p);
    if (v3_length(n) == 0)
        n = v3_unit(to_eye);
    if (b->params.cull == STP_CULL_BACK && v3_dot(n, to_eye) <= 0)
        return false;
    if (f->scene.facts.two_sided && v3_dot(n, to_eye) < 0)
        n = v3_scale(n, -1);
    struct vec3 a = v3_unit(v3_cross(n, fabs(n.x) < 0.5 ? v3(1, 0, 0) : v3(0, 1, 0)));
    struct vec3 c = v3_cross(n, a);
    double t = v3_dot(v3_sub(p, from), n) / v3_dot(along, n);
    struct vec3 x = v3_sub(v3_add(from, v3_scale(along, t)), p);
    double u = v3_dot(x, a) / f->radius[id], v = v3_dot(x, c) / f->radius[id];
    *hit = (struct hit){ t, u * u + v * v, id, n };
    return hit->rho2 <= 1 && t >= b->camera.near_depth && t <= b->camera.far_depth;
}

static inline int nearer(const void *a, const void *b)
{
    const struct hit *x = a, *y = b;
    if (x->depth != y->depth)
        return x->depth < y->depth ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

/* Every fragment on the ray of pixel (i, j), sorted; returns how many. */
static inline size_t brute_hits(const struct brute *b, uint32_t i, uint32_t j, struct vec3 *from,
                                struct vec3 *along, struct hit hit[MOST])
{
    size_t count = 0;
    world_ray(b, i, j, from, along);
    for (size_t id = 0; id < b->fixture->scene.splats.count; id++)
        count += meets(b, id, *from, *along, &hit[count]);
    qsort(hit, count, sizeof *hit, nearer);
    return count;
}

#endif
