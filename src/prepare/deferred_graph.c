/* ZP 4.1: the overlap graph of Eq. 5 with relaxations (1) to (3). */
#include "prepare/prepare.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/deferred_blocks.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define CHUNK_BLOCKS 512 /* blocks that share a buffer of rows */
/* The search is out of proportion when blocks meet more candidate blocks than this on average;
 * scans meet about 15, and 64 at the densest that 64 groups can colour. */
#define SEARCH_MEAN  512
#define SEARCH_FLOOR ((size_t)1 << 22)

/* Rows of one chunk's splats, back to back. */
struct rows {
    uint32_t *data;
    size_t size, capacity;
};

struct worker {
    uint32_t *near; /* candidate blocks */
    unsigned max_degree;
};

struct build {
    const struct splats *splats;
    const struct overlap_params *params;
    const struct block_tree *tree;
    struct overlap_graph *graph;
    struct rows *rows; /* one a chunk */
    struct worker *workers;
    atomic_size_t edges, searched; /* directed edges; pairs of blocks */
    atomic_bool no_memory;
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
    uint32_t *data = mem_realloc(rows->data, capacity, sizeof *data);
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
                        uint32_t *row)
{
    const struct splats *s = b->splats;
    const unsigned relax = b->params->relax & (STP_RELAX_OPPOSED | STP_RELAX_COPLANAR);
    const double radius = s->radius[i], overlap = b->params->overlap;
    size_t degree = 0;
    for (size_t c = 0; c < count; c++) {
        const uint32_t *id = &b->tree->id[(size_t)near[c] * BLOCK_SPLATS];
        unsigned hits = overlapping(&b->tree->block[near[c]], s->position[i], radius, overlap);
        for (; hits; hits &= hits - 1) {
            uint32_t j = id[__builtin_ctz(hits)];
            row[degree] = j;
            degree += j != i && !(relax && overlap_relaxed(s, relax, i, j));
        }
    }
    return degree;
}

static bool out_of_proportion(struct build *b, size_t edges, size_t searched)
{
    size_t max = b->params->max_edges;
    return max && (edges / 2 > max ||
                   (searched > SEARCH_FLOOR && searched / SEARCH_MEAN > b->tree->blocks));
}

/* The rows of one block's splats; degrees go to first[], as yet not summed. */
static bool build_block(struct build *b, size_t block, struct rows *rows, struct worker *worker)
{
    size_t near = block_tree_near(b->tree, block, b->params->overlap, worker->near);
    size_t begin = rows->size;
    for (int k = 0; k < BLOCK_SPLATS; k++) {
        uint32_t i = b->tree->id[block * BLOCK_SPLATS + k];
        if (i == UINT32_MAX)
            break;
        if (!rows_reserve(rows, near * BLOCK_SPLATS)) {
            atomic_store(&b->no_memory, true);
            return false;
        }
        size_t degree = write_row(b, worker->near, near, i, rows->data + rows->size);
        rows->size += degree;
        b->graph->first[i] = degree;
        worker->max_degree = degree > worker->max_degree ? (unsigned)degree : worker->max_degree;
    }
    size_t edges = rows->size - begin + atomic_fetch_add(&b->edges, rows->size - begin);
    return !out_of_proportion(b, edges, near + atomic_fetch_add(&b->searched, near));
}

static void build_chunks(void *context, size_t begin, size_t end, unsigned worker)
{
    struct build *b = context;
    for (size_t chunk = begin; chunk < end; chunk++) {
        struct rows *rows = &b->rows[chunk];
        size_t last = (chunk + 1) * CHUNK_BLOCKS;
        last = last < b->tree->blocks ? last : b->tree->blocks;
        if (atomic_load(&b->no_memory) ||
            out_of_proportion(b, atomic_load(&b->edges), atomic_load(&b->searched)))
            return;
        for (size_t block = chunk * CHUNK_BLOCKS; block < last; block++)
            if (!build_block(b, block, rows, &b->workers[worker]))
                return;
        uint32_t *shrunk = rows->size ? mem_realloc(rows->data, rows->size, sizeof *shrunk) : NULL;
        rows->data = shrunk ? shrunk : rows->data;
    }
}

static void copy_chunks(void *context, size_t begin, size_t end, unsigned worker)
{
    struct build *b = context;
    for (size_t chunk = begin; chunk < end; chunk++) {
        struct rows *rows = &b->rows[chunk];
        size_t first = b->graph->first[b->tree->id[chunk * CHUNK_BLOCKS * BLOCK_SPLATS]];
        if (rows->size)
            memcpy(b->graph->neighbour + first, rows->data, rows->size * sizeof *rows->data);
        mem_free(rows->data);
        rows->data = NULL;
    }
}

/* Degrees to offsets. */
static size_t sum_degrees(struct overlap_graph *graph)
{
    size_t sum = 0;
    for (size_t i = 0; i <= graph->count; i++) {
        size_t degree = graph->first[i];
        graph->first[i] = sum;
        sum += degree;
    }
    return sum;
}

static enum stp_result join_rows(const struct stp_env *env, struct build *b, size_t chunks)
{
    struct overlap_graph *graph = b->graph;
    size_t edges = sum_degrees(graph);
    for (unsigned w = 0; w < thread_count(env); w++)
        if (b->workers[w].max_degree > graph->max_degree)
            graph->max_degree = b->workers[w].max_degree;
    graph->neighbour = mem_alloc(edges, sizeof *graph->neighbour);
    if (!graph->neighbour)
        return log_no_memory(env, edges * sizeof *graph->neighbour, "the overlap graph");
    parallel_for(env, chunks, 1, copy_chunks, b);
    return STP_OK;
}

static enum stp_result search(const struct stp_env *env, struct build *b, size_t chunks,
                              bool *overload)
{
    parallel_for(env, chunks, 1, build_chunks, b);
    if (atomic_load(&b->no_memory))
        return log_no_memory(env, atomic_load(&b->edges) * sizeof(uint32_t), "the overlap graph");
    bool over = out_of_proportion(b, atomic_load(&b->edges), atomic_load(&b->searched));
    if (overload)
        *overload = over;
    return over ? STP_OK : join_rows(env, b, chunks);
}

static void free_scratch(const struct stp_env *env, struct build *b, size_t chunks)
{
    for (size_t i = 0; b->rows && i < chunks; i++)
        mem_free(b->rows[i].data);
    for (unsigned w = 0; b->workers && w < thread_count(env); w++)
        mem_free(b->workers[w].near);
    mem_free(b->rows);
    mem_free(b->workers);
}

static bool alloc_scratch(const struct stp_env *env, struct build *b, size_t chunks)
{
    b->graph->first = mem_zalloc(b->graph->count + 1, sizeof *b->graph->first);
    b->rows = mem_zalloc(chunks, sizeof *b->rows);
    b->workers = mem_zalloc(thread_count(env), sizeof *b->workers);
    bool ok = b->graph->first && b->rows && b->workers;
    for (unsigned w = 0; ok && w < thread_count(env); w++) {
        b->workers[w].near = mem_alloc(b->tree->blocks, sizeof *b->workers[w].near);
        ok = b->workers[w].near;
    }
    return ok;
}

static enum stp_result build_graph(const struct stp_env *env, struct build *b, bool *overload)
{
    size_t chunks = (b->tree->blocks + CHUNK_BLOCKS - 1) / CHUNK_BLOCKS;
    enum stp_result result;
    if (alloc_scratch(env, b, chunks))
        result = search(env, b, chunks, overload);
    else
        result = log_no_memory(env, b->graph->count * sizeof *b->graph->first, "the overlap graph");
    free_scratch(env, b, chunks);
    return result;
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
    result = build_graph(env, &build, overload);
    block_tree_release(&tree);
    if (result == STP_OK && built.neighbour)
        *graph = built;
    else
        overlap_graph_release(&built);
    return result;
}

void overlap_graph_release(struct overlap_graph *graph)
{
    mem_free(graph->first);
    mem_free(graph->neighbour);
    *graph = (struct overlap_graph){ 0 };
}
