/* ZP 4.1: the overlap graph of Eq. 5 with relaxations (1) to (3). */
#include "prepare/prepare.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/deferred_blocks.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* The search is out of proportion when blocks meet more candidate blocks than this on average;
 * scans meet about 15, and 64 at the densest that 64 groups can colour. */
#define SEARCH_MEAN  512
#define SEARCH_FLOOR ((size_t)1 << 22)

struct worker {
    uint32_t *near; /* candidate blocks */
    unsigned max_degree;
};

struct build {
    const struct splats *splats;
    const struct overlap_params *params;
    const struct block_tree *tree;
    struct overlap_graph *graph;
    struct worker *workers;
    atomic_size_t edges, overlaps,
        searched; /* directed, after and before relaxation; block pairs */
    atomic_bool no_memory;
};

/* One pool as it grows. */
struct rows {
    uint32_t *data;
    size_t size, capacity;
};

static double dot(const float a[3], const float b[3])
{
    return (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2];
}

/* |n.(q - p)| <= bound, for a normal of any length. */
static bool near_plane(const float n[3], const double p[3], const double q[3], double bound)
{
    double h = n[0] * (q[0] - p[0]) + n[1] * (q[1] - p[1]) + n[2] * (q[2] - p[2]);
    return h * h <= bound * bound * dot(n, n);
}

static bool one_color(const struct splats *s, size_t i, size_t j)
{
    for (int k = 0; s->color && k < 3; k++)
        if (!(fabs((double)s->color[i][k] - s->color[j][k]) <= COPLANAR_COLOR))
            return false;
    return !s->opacity || fabs((double)s->opacity[i] - s->opacity[j]) <= COPLANAR_COLOR;
}

static bool coplanar(const struct splats *s, size_t i, size_t j, double cosine)
{
    const float *a = s->normal[i], *b = s->normal[j];
    double least = cos(COPLANAR_DEGREES * M_PI / 180), smaller = fmin(s->radius[i], s->radius[j]);
    return cosine > 0 && cosine * cosine >= least * least * (dot(a, a) * dot(b, b)) &&
           near_plane(a, s->position[i], s->position[j], COPLANAR_OFFSET * smaller) &&
           near_plane(b, s->position[i], s->position[j], COPLANAR_OFFSET * smaller) &&
           (!s->object || s->object[i] == s->object[j]) && one_color(s, i, j);
}

bool overlap_relaxed(const struct splats *splats, unsigned relax, size_t i, size_t j)
{
    double cosine = dot(splats->normal[i], splats->normal[j]);
    if (cosine < 0)
        return relax & STP_RELAX_OPPOSED;
    return (relax & STP_RELAX_COPLANAR) && coplanar(splats, i, j, cosine);
}

static bool rows_reserve(struct rows *rows, size_t more)
{
    if (rows->capacity - rows->size >= more)
        return true;
    size_t capacity = rows->capacity + rows->capacity / 4 + more;
    uint32_t *data =
        capacity <= UINT32_MAX ? mem_realloc(rows->data, capacity, sizeof *data) : NULL;
    if (!data)
        return false;
    rows->data = data;
    rows->capacity = capacity;
    return true;
}

/* Two lanes at a time: every machine has vectors of 16 bytes. */
typedef double pair __attribute__((vector_size(16)));
typedef int64_t mask __attribute__((vector_size(16)));

static inline pair load(const double *p)
{
    pair v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* Lanes k and k + 1 of the block: does it overlap the splat? */
static inline mask pair_overlaps(const struct splat_block *block, int k, const double p[3],
                                 double radius, double overlap)
{
    pair dx = p[0] - load(&block->x[k]), dy = p[1] - load(&block->y[k]),
         dz = p[2] - load(&block->z[k]);
    pair t = overlap * (radius + load(&block->radius[k]));
    return dx * dx + dy * dy + dz * dz < t * t;
}

/* A bit a lane. */
static inline unsigned overlapping(const struct splat_block *block, const double p[3],
                                   double radius, double overlap)
{
    mask bits = (pair_overlaps(block, 0, p, radius, overlap) & (mask){ 1, 2 }) |
                (pair_overlaps(block, 2, p, radius, overlap) & (mask){ 4, 8 }) |
                (pair_overlaps(block, 4, p, radius, overlap) & (mask){ 16, 32 }) |
                (pair_overlaps(block, 6, p, radius, overlap) & (mask){ 64, 128 });
    return (unsigned)(bits[0] | bits[1]);
}

/* Splat i's neighbours among the candidate blocks; the room is there. */
static size_t write_row(const struct build *b, const uint32_t *near, size_t count, uint32_t i,
                        uint32_t *row, size_t *overlaps)
{
    const struct splats *s = b->splats;
    const unsigned relax = b->params->relax & (STP_RELAX_OPPOSED | STP_RELAX_COPLANAR);
    const double radius = s->radius[i], overlap = b->params->overlap;
    size_t degree = 0, tested = 0;
    for (size_t c = 0; c < count; c++) {
        const uint32_t *id = &b->tree->id[(size_t)near[c] * BLOCK_SPLATS];
        unsigned hits = overlapping(&b->tree->block[near[c]], s->position[i], radius, overlap);
        for (; hits; hits &= hits - 1, tested++) {
            uint32_t j = id[__builtin_ctz(hits)];
            row[degree] = j;
            degree += j != i && !(relax && overlap_relaxed(s, relax, i, j));
        }
    }
    *overlaps += tested;
    return degree;
}

/* Overlaps that relaxation spares cost time too: as many again are allowed. */
static bool out_of_proportion(struct build *b)
{
    size_t max = b->params->max_edges, searched = atomic_load(&b->searched);
    return max && (atomic_load(&b->edges) / 2 > max || atomic_load(&b->overlaps) / 4 > max ||
                   (searched > SEARCH_FLOOR && searched / SEARCH_MEAN > b->tree->blocks));
}

/* The rows of the lanes [lane, last) of one block. */
static bool build_block(struct build *b, size_t lane, size_t last, struct rows *rows,
                        struct worker *worker)
{
    size_t near = block_tree_near(b->tree, lane / BLOCK_SPLATS, b->params->overlap, worker->near);
    size_t begin = rows->size, overlaps = 0;
    for (; lane < last; lane++) {
        uint32_t i = b->tree->id[lane];
        if (!rows_reserve(rows, near * BLOCK_SPLATS)) {
            atomic_store(&b->no_memory, true);
            return false;
        }
        size_t degree = write_row(b, worker->near, near, i, rows->data + rows->size, &overlaps);
        rows->size += degree;
        b->graph->end[i] = (uint32_t)degree;
        worker->max_degree = degree > worker->max_degree ? (unsigned)degree : worker->max_degree;
    }
    atomic_fetch_add(&b->edges, rows->size - begin);
    atomic_fetch_add(&b->overlaps, overlaps);
    atomic_fetch_add(&b->searched, near);
    return !out_of_proportion(b);
}

/* The first lane whose splat is at or after i. */
static size_t lane_from(const struct block_tree *tree, size_t i)
{
    size_t low = 0, high = tree->splats;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (tree->id[middle] < i)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool build_rows(struct build *b, size_t pool, struct rows *rows, struct worker *worker)
{
    size_t lane = lane_from(b->tree, pool * OVERLAP_POOL);
    size_t end = lane_from(b->tree, (pool + 1) * OVERLAP_POOL);
    while (lane < end) {
        size_t last = (lane / BLOCK_SPLATS + 1) * BLOCK_SPLATS;
        last = last < end ? last : end;
        if (!build_block(b, lane, last, rows, worker))
            return false;
        lane = last;
    }
    return true;
}

/* Gives back what was reserved too much, and turns degrees into ends. */
static void finish_pool(struct overlap_graph *graph, size_t pool, struct rows *rows)
{
    size_t i = pool * OVERLAP_POOL, last = i + OVERLAP_POOL;
    uint32_t sum = 0;
    if (rows->size) {
        uint32_t *shrunk = mem_realloc(rows->data, rows->size, sizeof *shrunk);
        rows->data = shrunk ? shrunk : rows->data;
    }
    for (; i < last && i < graph->count; i++) {
        sum += graph->end[i];
        graph->end[i] = sum;
    }
    graph->pool[pool] = rows->data;
}

static void build_pools(void *context, size_t begin, size_t end, unsigned worker)
{
    struct build *b = context;
    for (size_t pool = begin; pool < end; pool++) {
        struct rows rows = { 0 };
        if (atomic_load(&b->no_memory) || out_of_proportion(b))
            return;
        if (build_rows(b, pool, &rows, &b->workers[worker]))
            finish_pool(b->graph, pool, &rows);
        else
            mem_free(rows.data);
    }
}

static size_t pool_count(const struct overlap_graph *graph)
{
    return (graph->count + OVERLAP_POOL - 1) / OVERLAP_POOL;
}

static bool alloc_graph(const struct stp_env *env, struct build *b)
{
    b->graph->end = mem_zalloc(b->graph->count, sizeof *b->graph->end);
    b->graph->pool = mem_zalloc(pool_count(b->graph), sizeof *b->graph->pool);
    b->workers = mem_zalloc(thread_count(env), sizeof *b->workers);
    bool ok = b->graph->end && b->graph->pool && b->workers;
    for (unsigned w = 0; ok && w < thread_count(env); w++) {
        b->workers[w].near = mem_alloc(b->tree->blocks, sizeof *b->workers[w].near);
        ok = b->workers[w].near;
    }
    return ok;
}

static void free_workers(const struct stp_env *env, struct build *b)
{
    for (unsigned w = 0; b->workers && w < thread_count(env); w++) {
        if (b->workers[w].max_degree > b->graph->max_degree)
            b->graph->max_degree = b->workers[w].max_degree;
        mem_free(b->workers[w].near);
    }
    mem_free(b->workers);
}

/* STP_OK and *over false: the graph is whole. */
static enum stp_result build_graph(const struct stp_env *env, struct build *b, bool *over)
{
    bool ok = alloc_graph(env, b);
    if (ok)
        parallel_for(env, pool_count(b->graph), 1, build_pools, b);
    ok = ok && !atomic_load(&b->no_memory);
    free_workers(env, b);
    b->graph->edges = atomic_load(&b->edges) / 2;
    *over = out_of_proportion(b);
    size_t bytes = (b->graph->count + 2 * b->graph->edges) * sizeof(uint32_t);
    return ok ? STP_OK : log_no_memory(env, bytes, "the overlap graph");
}

enum stp_result overlap_graph_build(const struct stp_env *env, const struct splats *splats,
                                    const struct overlap_params *params,
                                    struct overlap_graph *graph, bool *overload)
{
    struct block_tree tree;
    struct overlap_graph built = { .count = splats->count };
    enum stp_result result = block_tree_build(env, splats, params->skip, &tree);
    if (result != STP_OK)
        return result;
    built.nodes = tree.splats;
    struct build build = { .splats = splats, .params = params, .tree = &tree, .graph = &built };
    bool over;
    result = build_graph(env, &build, &over);
    block_tree_release(&tree);
    if (result == STP_OK && overload)
        *overload = over;
    if (result == STP_OK && !over)
        *graph = built;
    else
        overlap_graph_release(&built);
    return result;
}

void overlap_graph_release(struct overlap_graph *graph)
{
    for (size_t i = 0; graph->pool && i < pool_count(graph); i++)
        mem_free(graph->pool[i]);
    mem_free(graph->pool);
    mem_free(graph->end);
    *graph = (struct overlap_graph){ 0 };
}
