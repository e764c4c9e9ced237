/* ZP 4.2: which points of a disc other discs cover, and how much of the surface a group does. */
#include "prepare/deferred_cover.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/mix.h"
#include "base/thread.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define GOLDEN_ANGLE  2.39996322972865332
#define MEASURE_BLOCK 1024 /* splats whose sums are taken together, in order */

struct cover_points {
    unsigned count;
    float x[COVER_POINTS], y[COVER_POINTS];
};

static struct cover_points sunflower(void)
{
    struct cover_points points = { .count = COVER_POINTS };
    for (int s = 0; s < COVER_POINTS; s++) {
        double r = sqrt((s + 0.5) / COVER_POINTS), a = s * GOLDEN_ANGLE;
        points.x[s] = (float)(r * cos(a));
        points.y[s] = (float)(r * sin(a));
    }
    return points;
}

static struct cover_points turned(const struct cover_points *points, double turn)
{
    struct cover_points out = { .count = points->count };
    float c = (float)cos(turn), s = (float)sin(turn);
    for (unsigned k = 0; k < points->count; k++) {
        out.x[k] = c * points->x[k] - s * points->y[k];
        out.y[k] = s * points->x[k] + c * points->y[k];
    }
    return out;
}

/* Two unit vectors across n; any two for a normal that is not known. */
static void across(const float n[3], float u[3], float v[3])
{
    float a = fabsf(n[0]) < 0.7f ? 0 : 1;
    float w[3] = { 1 - a, a, 0 };
    u[0] = n[1] * w[2] - n[2] * w[1];
    u[1] = n[2] * w[0] - n[0] * w[2];
    u[2] = n[0] * w[1] - n[1] * w[0];
    float l = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    for (int k = 0; k < 3; k++)
        u[k] = l > 0 ? u[k] / sqrtf(l) : k == 0;
    v[0] = n[1] * u[2] - n[2] * u[1];
    v[1] = n[2] * u[0] - n[0] * u[2];
    v[2] = n[0] * u[1] - n[1] * u[0];
    if (!(l > 0))
        v[1] = 1;
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Squared distance from j's axis, and height above its plane, of i's point (x, y): quadratic and
 * linear in x and y. */
struct pair_form {
    float d2, x, y, r2, h, hx, hy;
};

static struct pair_form form_of(const struct splats *s, size_t i, size_t j)
{
    const float *n = s->normal[j];
    float u[3], v[3], d[3], r = s->radius[i];
    across(s->normal[i], u, v);
    for (int k = 0; k < 3; k++)
        d[k] = (float)(s->position[i][k] - s->position[j][k]);
    return (struct pair_form){ dot(d, d), 2 * r * dot(d, u), 2 * r * dot(d, v), r * r,
                               dot(d, n), r * dot(u, n),     r * dot(v, n) };
}

/* Neither stands for the other: of two objects, or opaque beside transparent. */
static bool one_surface(const struct splats *s, size_t i, size_t j)
{
    return (!s->object || s->object[i] == s->object[j]) &&
           (!s->opacity || (s->opacity[i] == 1) == (s->opacity[j] == 1));
}

/* The points of disc i that disc j, its radius times `factor`, covers, as bits. `points` are up to
 * 32 places in the unit disc. */
static uint32_t cover_mask(const struct cover *cover, const struct cover_points *points, size_t i,
                           size_t j, float factor)
{
    const struct splats *s = cover->splats;
    if (dot(s->normal[i], s->normal[j]) < 0 || !one_surface(s, i, j))
        return 0;
    struct pair_form f = form_of(s, i, j);
    float reach = s->radius[j] * factor,
          epsilon = (float)cover->epsilon[s->object ? s->object[i] : 0];
    float reach2 = reach * reach;
    uint32_t hits = 0;
    for (unsigned k = 0; k < COVER_POINTS; k++) {
        float x = points->x[k], y = points->y[k], h = f.h + x * f.hx + y * f.hy;
        float q = f.d2 + x * f.x + y * f.y + f.r2 * (x * x + y * y) - h * h;
        hits |= (uint32_t)((q <= reach2) & (fabsf(h) <= epsilon)) << k;
    }
    return points->count < COVER_POINTS ? hits & ((1u << points->count) - 1) : hits;
}

uint32_t cover_edge(const struct cover *cover, size_t i, size_t e)
{
    size_t first = i % OVERLAP_POOL ? cover->graph.end[i - 1] : 0;
    return cover->mask[i / OVERLAP_POOL][first + e];
}

uint32_t cover_edge_back(const struct cover *cover, size_t i, size_t j)
{
    struct overlap_row row = overlap_row(&cover->graph, j);
    size_t low = 0, high = row.degree - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (row.neighbour[middle] < i)
            low = middle + 1;
        else
            high = middle;
    }
    return cover_edge(cover, j, low);
}

struct filling {
    struct cover *cover;
    struct cover_points points;
    atomic_bool no_memory;
};

static void fill_row(struct filling *f, size_t i, uint32_t *mask)
{
    struct overlap_row row = overlap_row(&f->cover->graph, i);
    uint8_t *depth = f->cover->depth[i];
    memset(depth, 1, COVER_POINTS);
    for (size_t e = 0; e < row.degree; e++) {
        mask[e] = cover_mask(f->cover, &f->points, i, row.neighbour[e], 1);
        for (unsigned k = 0; mask[e] && k < COVER_POINTS; k++)
            depth[k] += (mask[e] >> k & 1) & (depth[k] < UINT8_MAX);
    }
}

static void fill_pools(void *context, size_t begin, size_t end, unsigned)
{
    struct filling *f = context;
    const struct overlap_graph *graph = &f->cover->graph;
    for (size_t pool = begin; pool < end; pool++) {
        size_t i = pool * OVERLAP_POOL, last = i + OVERLAP_POOL;
        last = last < graph->count ? last : graph->count;
        uint32_t *mask = mem_alloc(graph->end[last - 1] + 1u, sizeof *mask);
        f->cover->mask[pool] = mask;
        if (!mask)
            atomic_store(&f->no_memory, true);
        for (size_t first = 0; mask && i < last; first = graph->end[i++])
            fill_row(f, i, mask + first);
    }
}

enum stp_result cover_masks_build(struct cover *cover)
{
    struct filling filling = { .cover = cover, .points = sunflower() };
    size_t n = cover->splats->count, pools = (n + OVERLAP_POOL - 1) / OVERLAP_POOL;
    cover->mask = mem_zalloc(pools, sizeof *cover->mask);
    cover->depth = mem_alloc(n, sizeof *cover->depth);
    if (!cover->mask || !cover->depth)
        return log_no_memory(cover->env, n * sizeof *cover->depth, "coverage");
    parallel_for(cover->env, pools, 1, fill_pools, &filling);
    if (atomic_load(&filling.no_memory))
        return log_no_memory(cover->env, 2 * cover->graph.edges * sizeof(uint32_t), "coverage");
    return STP_OK;
}

struct measure_sums {
    double area, covered[STP_MAX_GROUPS];
    size_t points;
};

struct measuring {
    const struct cover *cover;
    const double *factor;
    size_t stride;
    struct cover_points points;
    struct measure_sums *sums; /* one a block */
};

/* Adds the masks of one neighbour to the groups it is in; radii may differ from group to group. */
static void add_neighbour(const struct measuring *m, const struct cover_points *points, size_t i,
                          size_t j, uint32_t *hit, uint8_t depth[COVER_POINTS])
{
    uint32_t plain = cover_mask(m->cover, points, i, j, 1);
    for (unsigned k = 0; plain && k < COVER_POINTS; k++)
        depth[k] += (plain >> k & 1) & (depth[k] < UINT8_MAX);
    for (uint64_t in = m->cover->member[j]; in; in &= in - 1) {
        unsigned g = (unsigned)__builtin_ctzll(in);
        float factor = m->factor ? (float)m->factor[g] : 1;
        hit[g] |= factor > 1 ? cover_mask(m->cover, points, i, j, factor) : plain;
    }
}

static void measure_splat(const struct measuring *m, size_t i, struct measure_sums *sums)
{
    const struct cover *c = m->cover;
    struct overlap_row row = overlap_row(&c->graph, i);
    uint32_t hit[STP_MAX_GROUPS] = { 0 };
    uint8_t depth[COVER_POINTS];
    struct cover_points points = turned(&m->points, mix_bits((uint32_t)i) * 0x1p-32 * 2 * M_PI);
    memset(depth, 1, sizeof depth);
    for (uint64_t in = c->member[i]; in; in &= in - 1)
        hit[__builtin_ctzll(in)] = UINT32_MAX;
    for (size_t e = 0; e < row.degree; e++)
        add_neighbour(m, &points, i, row.neighbour[e], hit, depth);
    double area = (double)c->splats->radius[i] * c->splats->radius[i];
    for (unsigned k = 0; k < COVER_POINTS; k++) {
        sums->area += area / depth[k];
        for (unsigned g = 0; g < c->groups; g++)
            sums->covered[g] += (hit[g] >> k & 1) * area / depth[k];
    }
    sums->points += COVER_POINTS;
}

static void measure_blocks(void *context, size_t begin, size_t end, unsigned)
{
    const struct measuring *m = context;
    for (size_t b = begin; b < end; b++) {
        size_t i = b * MEASURE_BLOCK * m->stride, last = (b + 1) * MEASURE_BLOCK * m->stride;
        for (; i < last && i < m->cover->splats->count; i += m->stride)
            if (!m->cover->skip[i])
                measure_splat(m, i, &m->sums[b]);
    }
}

enum stp_result cover_measure(const struct cover *cover, const double *factor, size_t budget,
                              double *share, size_t *points)
{
    size_t n = cover->splats->count, stride = n * COVER_POINTS / (budget ? budget : 1);
    struct measuring m = { cover, factor, stride ? stride : 1, sunflower(), NULL };
    size_t blocks = (n + MEASURE_BLOCK * m.stride - 1) / (MEASURE_BLOCK * m.stride);
    struct measure_sums total = { 0 };
    m.sums = mem_zalloc(blocks, sizeof *m.sums);
    if (!m.sums)
        return log_no_memory(cover->env, blocks * sizeof *m.sums, "coverage");
    parallel_for(cover->env, blocks, 1, measure_blocks, &m);
    for (size_t b = 0; b < blocks; b++) {
        total.area += m.sums[b].area;
        total.points += m.sums[b].points;
        for (unsigned g = 0; g < cover->groups; g++)
            total.covered[g] += m.sums[b].covered[g];
    }
    for (unsigned g = 0; g < cover->groups; g++)
        share[g] = total.area > 0 ? total.covered[g] / total.area : 1;
    if (points)
        *points = total.points;
    mem_free(m.sums);
    return STP_OK;
}
