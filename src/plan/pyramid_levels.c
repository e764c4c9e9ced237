/* MKC 3.1 to 3.3 on the CPU, pass for pass as glsl/passes/pyramid_*.comp: what the probe compares
 * with the reference. */
#include "plan/pyramid_probe.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

static const struct pyramid_texel nothing = { .depth = INFINITY };

/* Order of floats as unsigned numbers. */
static uint32_t depth_order(float depth)
{
    uint32_t bits;
    memcpy(&bits, &depth, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/* A point in the device's camera frame, and where it falls. */
struct placed {
    struct vec3 center, normal;
    double at[2];
};

/* False: culled, or outside near and far. */
static bool place(const struct pyramid *p, size_t id, struct placed *out)
{
    const struct eye *eye = &p->view->eye;
    const struct splats *splats = &p->view->scene->splats;
    struct vec3 c = eye_point(eye, splats->position[id]);
    struct vec3 n = eye_direction(eye, v3_loadf(splats->normal[id]));
    c = v3(c.x, -c.y, -c.z);
    n = v3(n.x, -n.y, -n.z);
    if (v3_dot(n, n) == 0)
        n = eye->orthographic ? v3(0, 0, -1) : v3_scale(v3_unit(c), -1);
    double away = eye->orthographic ? n.z : v3_dot(n, c);
    double scale = eye->orthographic ? 1 : 1 / c.z;
    out->center = c;
    out->normal = p->view->two_sided && away > 0 ? v3_scale(n, -1) : n;
    out->at[0] = eye->cx + eye->fx * c.x * scale;
    out->at[1] = eye->cy + eye->fy * c.y * scale;
    return (!p->view->cull_back || away < 0) && c.z >= eye->near_depth && c.z <= eye->far_depth;
}

static void take_nearest(uint64_t *key, uint64_t value)
{
    uint64_t old = __atomic_load_n(key, __ATOMIC_RELAXED);
    while (value < old &&
           !__atomic_compare_exchange_n(key, &old, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        ;
}

static void project(void *context, size_t begin, size_t end, unsigned)
{
    const struct pyramid *p = context;
    const struct plan_grid *g = &p->plan->grid;
    for (size_t i = begin; i < end; i++) {
        struct placed point;
        if (!place(p, i, &point))
            continue;
        double x = floor(point.at[0]) - g->x, y = floor(point.at[1]) - g->y;
        if (!(x >= 0 && y >= 0 && x < g->width && y < g->height))
            continue;
        uint64_t order = depth_order((float)point.center.z);
        take_nearest(&p->key[(size_t)y * g->width + (size_t)x], order << 32 | i);
    }
}

bool pyramid_point(const struct pyramid *p, size_t id, struct pyramid_texel *t, double at[2])
{
    struct placed point;
    if (!place(p, id, &point))
        return false;
    *t = (struct pyramid_texel){ .full = true, .exact = true, .id = (uint32_t)id };
    t->depth = (float)point.center.z;
    t->radius = p->view->scene->splats.radius[id];
    v3_storef(point.normal, t->normal);
    v3_storef(splat_albedo(p->view, (uint32_t)id), t->color);
    memcpy(at, point.at, sizeof point.at);
    return true;
}

/* Level 0: the point that won the pixel. */
static struct pyramid_texel point_texel(const struct pyramid *p, int64_t x, int64_t y)
{
    uint64_t key = p->key[(size_t)y * p->width[0] + (size_t)x];
    struct pyramid_texel t;
    double middle[2], at[2];
    if (key == PYRAMID_NOTHING || !pyramid_point(p, (uint32_t)key, &t, at))
        return nothing;
    pyramid_middle(p, 0, x, y, middle);
    for (int k = 0; k < 2; k++)
        t.center[k] = (float)(at[k] - middle[k]);
    return t;
}

int64_t pyramid_origin(const struct pyramid *p, unsigned level, int axis)
{
    return (axis ? p->plan->grid.y : p->plan->grid.x) >> level;
}

void pyramid_middle(const struct pyramid *p, unsigned level, int64_t x, int64_t y, double at[2])
{
    double side = (double)(1u << level);
    at[0] = ((double)(x + pyramid_origin(p, level, 0)) + 0.5) * side;
    at[1] = ((double)(y + pyramid_origin(p, level, 1)) + 0.5) * side;
}

struct pyramid_texel pyramid_load(const struct pyramid *p, unsigned level, int64_t x, int64_t y)
{
    if (x < 0 || y < 0 || x >= p->width[level] || y >= p->height[level])
        return nothing;
    return level ? p->texel[level][(size_t)y * p->width[level] + (size_t)x] : point_texel(p, x, y);
}

struct pyramid_meeting pyramid_meet(const struct pyramid *p, const struct pyramid_texel *t,
                                    const double center[2], const double q[2])
{
    const struct eye *eye = &p->view->eye;
    bool flat = eye->orthographic;
    double ix = 1 / eye->fx, iy = 1 / eye->fy, z = (double)t->depth, unit = flat ? 1 : z;
    double dx = (q[0] - center[0]) * ix, dy = (q[1] - center[1]) * iy;
    struct vec3 ray =
        flat ? v3(0, 0, 1) : v3((center[0] - eye->cx) * ix, (center[1] - eye->cy) * iy, 1);
    double least = (double)p->plan->frame.pyramid_floor * fmin(ix, iy) * unit;
    double radius = fmax((double)t->radius, least), slope = radius > 0 ? least / radius : 0;
    struct vec3 towards = v3_unit(ray), n = v3_loadf(t->normal);
    double facing = v3_dot(n, towards);
    if (fabs(facing) < slope) {
        struct vec3 along = v3_sub(n, v3_scale(towards, facing));
        double turn = sqrt((1 - slope * slope) / fmax(v3_dot(along, along), 1e-20));
        n = v3_add(v3_scale(towards, facing < 0 ? -slope : slope), v3_scale(along, turn));
    }
    double g = v3_dot(n, ray), rise = n.x * dx + n.y * dy, den = flat ? g : g + rise;
    struct vec3 v = v3_sub(v3_scale(v3(dx, dy, 0), g), v3_scale(ray, rise));
    v = v3_scale(v, unit / den);
    struct pyramid_meeting m = { .depth = z - unit * rise / den, .reach = radius };
    m.away2 = den * g > 0 ? v3_dot(v, v) : INFINITY;
    m.hit = m.away2 <= radius * radius;
    return m;
}

/* Sums over the children that count become their mean. */
static void finish_mean(struct pyramid_texel *mean, struct vec3 normal, double count,
                        const float front_normal[3])
{
    float scale = (float)(1 / count);
    mean->depth *= scale;
    mean->radius *= scale;
    for (int k = 0; k < 3; k++)
        mean->color[k] *= scale;
    if (v3_dot(normal, normal) > 1e-12)
        v3_storef(v3_unit(normal), mean->normal);
    else
        memcpy(mean->normal, front_normal, sizeof mean->normal);
}

static float start_of(const struct pyramid_texel *t)
{
    return t->depth - t->extent;
}

/* The frontmost of four, and how far its interval reaches. */
static const struct pyramid_texel *frontmost(const struct pyramid_texel child[4], float *reach)
{
    const struct pyramid_texel *front = NULL;
    for (int i = 0; i < 4; i++)
        if (isfinite(child[i].depth) && (!front || start_of(&child[i]) < start_of(front)))
            front = &child[i];
    if (front)
        *reach = front->depth + front->extent + front->radius;
    return front;
}

/* Neither near nor far cuts the disc. */
static bool uncut(const struct pyramid *p, const struct pyramid_texel *t)
{
    const struct eye *e = &p->view->eye;
    double z = (double)t->depth, r = (double)t->radius;
    return z - r >= e->near_depth && z + r <= e->far_depth;
}

static struct pyramid_texel mean_of(const struct pyramid *p, unsigned level, int64_t x, int64_t y)
{
    int64_t fx = 2 * (x + pyramid_origin(p, level, 0)) - pyramid_origin(p, level - 1, 0);
    int64_t fy = 2 * (y + pyramid_origin(p, level, 1)) - pyramid_origin(p, level - 1, 1);
    struct pyramid_texel child[4], mean = { 0 };
    struct vec3 normal = v3(0, 0, 0);
    double count = 0, full = 0, middle[2], from[2], center[2] = { 0, 0 };
    float reach = 0;
    for (int i = 0; i < 4; i++)
        child[i] = pyramid_load(p, level - 1, fx + (i & 1), fy + (i >> 1));
    const struct pyramid_texel *front = frontmost(child, &reach);
    if (!front)
        return nothing;
    pyramid_middle(p, level, x, y, middle);
    for (int i = 0; i < 4; i++) {
        const struct pyramid_texel *c = &child[i];
        if (!isfinite(c->depth) || start_of(c) > reach)
            continue;
        count++;
        full += c->full;
        mean.exact = mean.exact || (c->exact && (level > 1 || uncut(p, c)));
        mean.depth += c->depth;
        mean.radius += c->radius;
        normal = v3_add(normal, v3_loadf(c->normal));
        pyramid_middle(p, level - 1, fx + (i & 1), fy + (i >> 1), from);
        for (int k = 0; k < 2; k++)
            center[k] += from[k] + (double)c->center[k] - middle[k];
        for (int k = 0; k < 3; k++)
            mean.color[k] += c->color[k];
    }
    finish_mean(&mean, normal, count, front->normal);
    mean.full = full >= (level == 1 ? 2 : 3);
    mean.exact = mean.exact && count <= 1;
    mean.id = front->id;
    for (int k = 0; k < 2; k++)
        mean.center[k] = (float)(center[k] / count);
    for (int i = 0; i < 4; i++) {
        const struct pyramid_texel *c = &child[i];
        if (isfinite(c->depth) && start_of(c) <= reach)
            mean.extent = fmaxf(mean.extent,
                                fmaxf(mean.depth - start_of(c),
                                      c->depth + c->extent + c->radius - mean.depth - mean.radius));
    }
    return mean;
}

struct step {
    const struct pyramid *pyramid;
    unsigned level;
};

static void pull_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct step *s = context;
    uint32_t width = s->pyramid->width[s->level];
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < width; x++)
            s->pyramid->texel[s->level][y * width + x] =
                mean_of(s->pyramid, s->level, x, (int64_t)y);
}

/* Empty and hidden texels are made from the level above. */
static void push_texel(const struct pyramid *p, unsigned level, int64_t x, int64_t y)
{
    struct pyramid_texel *own = &p->texel[level][(size_t)y * p->width[level] + (size_t)x];
    bool valid = isfinite(own->depth);
    double middle[2], q[2];
    pyramid_middle(p, level, x, y, middle);
    for (int k = 0; k < 2; k++)
        q[k] = middle[k] + (valid ? (double)own->center[k] : 0);
    struct pyramid_push r = pyramid_push(p, level + 1, x, y, q, valid);
    if (!(r.weight > 0) || (valid && (double)start_of(own) <= r.reach))
        return;
    *own = r.disc;
    for (int k = 0; k < 2; k++)
        own->center[k] = (float)(r.center[k] - middle[k]);
}

static void push_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct step *s = context;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < s->pyramid->width[s->level]; x++)
            push_texel(s->pyramid, s->level, x, (int64_t)y);
}

/* Of a level: the texels that touch the grid. */
static uint32_t extent_of(int32_t first, uint32_t length, unsigned level)
{
    int64_t last = (int64_t)first + length - 1;
    return (uint32_t)((last >> level) - ((int64_t)first >> level) + 1);
}

static bool allocate(struct pyramid *p)
{
    const struct plan_grid *g = &p->plan->grid;
    bool made = true;
    for (unsigned l = 0; l < p->levels; l++) {
        p->width[l] = extent_of(g->x, g->width, l);
        p->height[l] = extent_of(g->y, g->height, l);
    }
    p->key = mem_alloc((size_t)g->width * g->height, sizeof *p->key);
    for (unsigned l = 1; l < p->levels && made; l++) {
        p->texel[l] = mem_alloc((size_t)p->width[l] * p->height[l], sizeof *p->texel[l]);
        made = p->texel[l] != NULL;
    }
    return p->key && made;
}

enum stp_result pyramid_make(const struct stp_env *env, const struct stp_plan *plan,
                             const struct view *view, struct pyramid *pyramid)
{
    struct pyramid p = { .plan = plan, .view = view, .levels = plan->levels };
    size_t pixels = (size_t)plan->grid.width * plan->grid.height;
    if (!allocate(&p)) {
        pyramid_release(&p);
        return log_no_memory(env, pixels * sizeof **p.texel / 3, "a pyramid to judge by");
    }
    memset(p.key, 0xff, pixels * sizeof *p.key);
    parallel_for(env, view->scene->splats.count, 4096, project, &p);
    for (unsigned level = 1; level < p.levels; level++)
        parallel_for(env, p.height[level], 8, pull_rows, &(struct step){ &p, level });
    for (unsigned level = p.levels - 1; level-- > 1;)
        parallel_for(env, p.height[level], 8, push_rows, &(struct step){ &p, level });
    *pyramid = p;
    return STP_OK;
}

void pyramid_release(struct pyramid *pyramid)
{
    mem_free(pyramid->key);
    for (unsigned l = 0; l < STP_LEVELS; l++)
        mem_free(pyramid->texel[l]);
    *pyramid = (struct pyramid){ 0 };
}
