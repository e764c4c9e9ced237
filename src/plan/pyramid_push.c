/* MKC 3.3 on the CPU: what a coarser level says of a place on a finer one, as glsl/lib/push.glsl.
 */
#include "plan/pyramid_probe.h"

#include <string.h>

/* The disc holds all of a texel of so many pixels about the place. */
static bool disc_holds(const struct pyramid *p, const struct pyramid_texel *t, const double q[2],
                       double side, const struct pyramid_meeting *m)
{
    const struct eye *e = &p->view->eye;
    struct vec3 ray =
        e->orthographic ? v3(0, 0, 1) : v3((q[0] - e->cx) / e->fx, (q[1] - e->cy) / e->fy, 1);
    double facing = fabs(v3_dot(v3_loadf(t->normal), v3_unit(ray)));
    double half = 0.7072 * side * fmax(1 / e->fx, 1 / e->fy);
    bool even = e->orthographic || half <= 0.2 * facing;
    double room = m->reach - sqrt(m->away2);
    return even && room * facing >= 1.25 * half * (e->orthographic ? 1 : m->depth);
}

/* What covers a place, what hides there, and whether one point's disc holds all of its texel. */
static void meet_four(const struct pyramid *p, unsigned coarse, const double center[4][2],
                      const struct pyramid_texel t[4], const double q[2], bool hiding,
                      double depth[4], struct pyramid_push *r)
{
    const struct eye *eye = &p->view->eye;
    double side = (double)(1u << coarse), pixel = fmax(1 / eye->fx, 1 / eye->fy);
    double below = coarse == 1 ? 0 : side / 2; /* a pixel is its sample */
    r->disc.inside = t[0].inside;
    r->front = r->reach = r->before = INFINITY;
    for (int i = 0; i < 4; i++) {
        struct pyramid_texel disc = t[i];
        depth[i] = INFINITY;
        if (!isfinite(disc.depth))
            continue;
        double one = (eye->orthographic ? 1 : (double)disc.depth) * pixel;
        if (hiding && disc.full)
            disc.radius = fmaxf(disc.radius, (float)(0.75 * side * one));
        struct pyramid_meeting m = pyramid_meet(p, &disc, center[i], q);
        double margin = m.reach + 1.5 * one;
        if (!m.hit && m.away2 <= margin * margin)
            r->before = fmin(r->before, m.depth + (double)t[i].radius);
        if (!m.hit)
            continue;
        if (disc.exact && !hiding && disc_holds(p, &disc, q, below, &m))
            r->disc.inside = true;
        depth[i] = m.depth;
        if (m.depth < r->front)
            r->reach = m.depth + (double)t[i].radius;
        r->front = fmin(r->front, m.depth);
    }
}

static void add_share(struct pyramid_push *r, double w, const struct pyramid_texel *t, double depth,
                      const double center[2], const double q[2])
{
    r->disc.exact = r->weight > 0 ? false : t->exact;
    r->weight += w;
    r->depth += w * (depth - r->front);
    r->disc.depth += (float)(w * ((double)t->depth - r->front));
    r->disc.radius += (float)(w * (double)t->radius);
    r->disc.extent = fmaxf(r->disc.extent, t->extent);
    r->disc.full = r->disc.full && t->full;
    for (int k = 0; k < 2; k++)
        r->center[k] += w * (center[k] - q[k]);
    for (int k = 0; k < 3; k++) {
        r->normal[k] += w * (double)t->normal[k];
        r->color[k] += w * (double)t->color[k];
    }
    if (depth == r->front) {
        r->disc.id = t->id;
        memcpy(r->disc.normal, t->normal, sizeof t->normal);
    }
}

static void finish_push(struct pyramid_push *r, const double q[2])
{
    double scale = 1 / r->weight;
    struct vec3 n = v3(r->normal[0], r->normal[1], r->normal[2]);
    r->depth = r->front + r->depth * scale;
    r->disc.depth = (float)(r->front + (double)r->disc.depth * scale);
    r->disc.radius *= (float)scale;
    for (int k = 0; k < 2; k++)
        r->center[k] = q[k] + r->center[k] * scale;
    for (int k = 0; k < 3; k++)
        r->disc.color[k] = (float)(r->color[k] * scale);
    bool cancel = !(v3_dot(n, n) > 1e-12);
    n = v3_unit(n);
    for (int k = 0; k < 3; k++)
        if (cancel) /* the frontmost's is left */
            r->normal[k] = r->weight * (double)r->disc.normal[k];
        else
            r->disc.normal[k] = (float)(k == 0 ? n.x : k == 1 ? n.y : n.z);
}

struct pyramid_push pyramid_push(const struct pyramid *p, unsigned coarse, int64_t x, int64_t y,
                                 const double q[2], bool hiding)
{
    static const double weight[4] = { 9 / 16.0, 3 / 16.0, 3 / 16.0, 1 / 16.0 };
    int64_t gx = x + pyramid_origin(p, coarse - 1, 0), gy = y + pyramid_origin(p, coarse - 1, 1);
    int64_t sx = (gx & 1) * 2 - 1, sy = (gy & 1) * 2 - 1;
    int64_t fx = (gx >> 1) - pyramid_origin(p, coarse, 0),
            fy = (gy >> 1) - pyramid_origin(p, coarse, 1);
    struct pyramid_texel t[4];
    struct pyramid_push r = { .disc.full = true };
    double center[4][2], depth[4];
    for (int i = 0; i < 4; i++) {
        int64_t tx = fx + (i & 1) * sx, ty = fy + (i >> 1) * sy;
        t[i] = pyramid_load(p, coarse, tx, ty);
        pyramid_middle(p, coarse, tx, ty, center[i]);
        for (int k = 0; k < 2; k++)
            center[i][k] += (double)t[i].center[k];
    }
    for (int i = 0; i < 4; i++)
        r.disc.rim =
            r.disc.rim || (t[i].rim && coarse < p->plan->frame.rim_level) || !isfinite(t[i].depth);
    meet_four(p, coarse, center, t, q, hiding, depth, &r);
    r.disc.rim = r.disc.rim && !r.disc.inside;
    for (int i = 0; i < 4; i++)
        if (isfinite(depth[i]) && depth[i] <= r.reach)
            add_share(&r, weight[i], &t[i], depth[i], center[i], q);
    if (r.weight > 0)
        finish_push(&r, q);
    return r;
}
