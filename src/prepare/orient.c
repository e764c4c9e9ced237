#include "prepare/orient.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/normals.h"

#define WEIGHTS      4096
#define NO_COMPONENT UINT32_MAX

/* What is turned. */
struct surface {
    size_t count;
    const double (*position)[3];
    float (*normal)[3];
    const float *spacing;
    const uint32_t (*neighbour)[SURROUND_GRAPH];
};

/* Edges as SURROUND_GRAPH times the point, plus which neighbour; sorted by weight by counting, so
 * that nothing but this one array is needed. Ties stay in the order of ids. */
struct edges {
    const struct surface *surface;
    size_t count, block;
    uint32_t *slot;
    size_t (*bins)[WEIGHTS]; /* a block: counts, then where the next edge of a weight goes */
};

/* An edge that both ends list is that of the lower one. */
static bool owns_edge(const struct edges *e, size_t i, uint32_t j)
{
    if (j == NO_NEIGHBOUR || normal_is_unknown(e->surface->normal[j]))
        return false;
    if (i < j)
        return true;
    for (unsigned k = 0; k < SURROUND_GRAPH; k++)
        if (e->surface->neighbour[j][k] == i)
            return false;
    return true;
}

static double dot_normals(const struct surface *s, size_t i, size_t j)
{
    return v3_dot(v3_loadf(s->normal[i]), v3_loadf(s->normal[j]));
}

/* Linear in the angle between the planes, where that is small. */
static unsigned weight_of(const struct surface *s, size_t i, uint32_t j)
{
    double weight = 1 - fabs(dot_normals(s, i, j));
    return weight > 0 ? (unsigned)(sqrt(weight) * (WEIGHTS - 1)) : 0;
}

/* Counts, and the second time places. */
static void edge_range(void *context, size_t begin, size_t end, unsigned)
{
    struct edges *e = context;
    size_t *bins = e->bins[begin / e->block];
    for (size_t i = begin; i < end; i++)
        for (unsigned k = 0; k < SURROUND_GRAPH && !normal_is_unknown(e->surface->normal[i]); k++) {
            uint32_t j = e->surface->neighbour[i][k];
            if (!owns_edge(e, i, j))
                continue;
            size_t at = bins[weight_of(e->surface, i, j)]++;
            if (e->slot)
                e->slot[at] = (uint32_t)(i * SURROUND_GRAPH + k);
        }
}

static void prefix_sums(struct edges *e, size_t blocks)
{
    for (unsigned weight = 0; weight < WEIGHTS; weight++)
        for (size_t block = 0; block < blocks; block++) {
            size_t here = e->bins[block][weight];
            e->bins[block][weight] = e->count;
            e->count += here;
        }
}

/* Lightest first. Stable, so the number of blocks does not show. */
static enum stp_result edges_build(const struct stp_env *env, struct edges *e)
{
    size_t points = e->surface->count, threads = thread_count(env);
    e->block = (points + threads - 1) / threads;
    size_t blocks = (points + e->block - 1) / e->block;
    e->bins = mem_zalloc(blocks, sizeof *e->bins);
    if (!e->bins)
        return log_no_memory(env, blocks * sizeof *e->bins, "edges");
    parallel_for(env, points, e->block, edge_range, e);
    prefix_sums(e, blocks);
    e->slot = mem_alloc(e->count, sizeof *e->slot);
    if (e->slot)
        parallel_for(env, points, e->block, edge_range, e);
    mem_free(e->bins);
    return e->slot ? STP_OK : log_no_memory(env, e->count * sizeof *e->slot, "edges");
}

/* A spanning forest that knows, for each point, whether it is turned against its root. */
struct forest {
    uint32_t *parent, *size;
    uint8_t *against; /* the parent */
};

static uint32_t find_root(struct forest *f, uint32_t i, uint8_t *against)
{
    *against = 0;
    while (f->parent[i] != i) {
        uint32_t parent = f->parent[i];
        f->against[i] ^= f->against[parent];
        f->parent[i] = f->parent[parent];
        *against ^= f->against[i];
        i = f->parent[i];
    }
    return i;
}

static void join(struct forest *f, uint32_t i, uint32_t j, bool opposed)
{
    uint8_t i_against, j_against;
    uint32_t a = find_root(f, i, &i_against), b = find_root(f, j, &j_against);
    if (a == b)
        return;
    uint32_t high = f->size[a] >= f->size[b] ? a : b, low = high == a ? b : a;
    f->parent[low] = high;
    f->size[high] += f->size[low];
    f->against[low] = (uint8_t)(i_against ^ j_against ^ opposed);
}

static void grow_forest(struct forest *f, const struct edges *e)
{
    for (size_t i = 0; i < e->surface->count; i++) {
        f->parent[i] = (uint32_t)i;
        f->size[i] = 1;
        f->against[i] = 0;
    }
    for (size_t n = 0; n < e->count; n++) {
        uint32_t i = e->slot[n] / SURROUND_GRAPH,
                 j = e->surface->neighbour[i][e->slot[n] % SURROUND_GRAPH];
        join(f, i, j, dot_normals(e->surface, i, j) < 0);
    }
}

/* Turns each splat to the side of its root; parent[i] becomes the root of i. */
static void turn_to_root(struct forest *f, const struct surface *s)
{
    for (size_t i = 0; i < s->count; i++) {
        uint8_t against;
        f->size[i] = find_root(f, (uint32_t)i, &against);
        for (int axis = 0; against && axis < 3; axis++)
            s->normal[i][axis] = 0 - s->normal[i][axis];
    }
    memcpy(f->parent, f->size, s->count * sizeof *f->parent);
}

struct component {
    struct vec3 sum, normals;
    double count, flux, most;
    double reach[6];  /* of the extreme points along +x -x +y -y +z -z */
    double facing[6]; /* n.axis there */
    bool inward;
};

static double along(struct vec3 v, int side)
{
    double c = side / 2 == 0 ? v.x : side / 2 == 1 ? v.y : v.z;
    return side % 2 ? -c : c;
}

static void add_to_component(struct component *c, struct vec3 p, struct vec3 n, double r)
{
    struct vec3 d = v3_sub(p, v3_scale(c->sum, 1 / c->count));
    c->flux += r * r * v3_dot(n, d);
    c->most += r * r * v3_length(d);
    c->normals = v3_add(c->normals, v3_scale(n, r * r));
    for (int side = 0; side < 6; side++)
        if (along(d, side) > c->reach[side]) {
            c->reach[side] = along(d, side);
            c->facing[side] = along(n, side);
        }
}

static bool is_inward(const struct component *c, struct vec3 up)
{
    double extent = 0, vote = 0,
           sign[4] = { v3_dot(c->normals, up), c->normals.x, c->normals.y, c->normals.z };
    if (fabs(c->flux) >= 0.05 * c->most && c->most > 0)
        return c->flux < 0;
    for (int side = 0; side < 6; side++)
        extent = fmax(extent, c->reach[side]);
    for (int side = 0; side < 6; side++) /* a flat sheet has no extreme point across it */
        vote += c->reach[side] > 0.01 * extent ? c->facing[side] : 0;
    if (fabs(vote) >= 0.5)
        return vote < 0;
    for (int i = 0; i < 4; i++)
        if (fabs(sign[i]) > 0.1 * v3_length(c->normals))
            return sign[i] < 0;
    return false;
}

/* Sums run in canonical order. component[i] is NO_COMPONENT where the normal is unknown. */
static void measure_components(const struct surface *s, const uint32_t *component,
                               struct component *c, struct vec3 origin)
{
    for (size_t i = 0; i < s->count; i++) {
        if (component[i] == NO_COMPONENT)
            continue;
        struct component *own = &c[component[i]];
        own->sum = v3_add(own->sum, v3_sub(v3_load(s->position[i]), origin));
        own->count += 1;
    }
    for (size_t i = 0; i < s->count; i++)
        if (component[i] != NO_COMPONENT)
            add_to_component(&c[component[i]], v3_sub(v3_load(s->position[i]), origin),
                             v3_loadf(s->normal[i]), (double)s->spacing[i]);
}

static void turn_outward(const struct surface *s, const uint32_t *component, struct component *c,
                         size_t count, struct vec3 up)
{
    for (size_t i = 0; i < count; i++)
        c[i].inward = is_inward(&c[i], up);
    for (size_t i = 0; i < s->count; i++)
        if (component[i] != NO_COMPONENT && c[component[i]].inward)
            for (int axis = 0; axis < 3; axis++)
                s->normal[i][axis] = 0 - s->normal[i][axis];
}

/* root[i] -> dense numbers in the order of their first splats; returns how many. */
static size_t number_components(const struct surface *s, uint32_t *root, uint32_t *scratch)
{
    size_t components = 0;
    memset(scratch, 0xff, s->count * sizeof *scratch);
    for (size_t i = 0; i < s->count; i++) {
        uint32_t *number = &scratch[root[i]];
        bool known = !normal_is_unknown(s->normal[i]);
        if (known && *number == NO_COMPONENT)
            *number = (uint32_t)components++;
        root[i] = known ? *number : NO_COMPONENT;
    }
    return components;
}

static enum stp_result orient(const struct stp_env *env, const struct surface *s,
                              struct edges *edges, struct forest *f, struct vec3 up)
{
    enum stp_result result = edges_build(env, edges);
    if (result != STP_OK)
        return result;
    grow_forest(f, edges);
    turn_to_root(f, s);
    size_t count = number_components(s, f->parent, f->size);
    struct component *components = mem_zalloc(count, sizeof *components);
    if (!components)
        return log_no_memory(env, count * sizeof *components, "connected components");
    measure_components(s, f->parent, components, v3_load(s->position[0]));
    turn_outward(s, f->parent, components, count, up);
    mem_free(components);
    return STP_OK;
}

enum stp_result orient_normals(const struct stp_env *env, const struct places *places,
                               struct surroundings *all, struct vec3 up)
{
    size_t count = places->count;
    if (count > UINT32_MAX / SURROUND_GRAPH)
        return log_error(env, STP_ERROR_MEMORY, "normals can be estimated for %u points at most",
                         UINT32_MAX / SURROUND_GRAPH);
    struct surface surface = { count, places->position, all->normal, all->spacing,
                               (const uint32_t(*)[SURROUND_GRAPH])all->neighbour };
    struct edges edges = { .surface = &surface };
    struct forest f = { mem_alloc(count, sizeof *f.parent), mem_alloc(count, sizeof *f.size),
                        mem_alloc(count, sizeof *f.against) };
    enum stp_result result = STP_OK;
    if (!f.parent || !f.size || !f.against)
        result = log_no_memory(env, count * 9, "the orientation of normals");
    else if (count > 0)
        result = orient(env, &surface, &edges, &f, up);
    mem_free(edges.slot);
    mem_free(f.parent);
    mem_free(f.size);
    mem_free(f.against);
    return result;
}
