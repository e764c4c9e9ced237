#include "prepare/deferred_blocks.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#include <math.h>
#include <string.h>

#define GRAIN 256 /* nodes */

struct fill {
    const struct splats *splats;
    struct block_tree *tree;
    unsigned level;
};

/* Two lanes at a time: every machine has vectors of 16 bytes. */
typedef double pair __attribute__((vector_size(16)));
typedef int64_t mask __attribute__((vector_size(16)));

struct box {
    double low[3], high[3], radius;
};

static const struct box no_box = { { INFINITY, INFINITY, INFINITY },
                                   { -INFINITY, -INFINITY, -INFINITY },
                                   0 };

static void box_add(struct box *box, const double low[3], const double high[3], double radius)
{
    for (int a = 0; a < 3; a++) {
        box->low[a] = low[a] < box->low[a] ? low[a] : box->low[a];
        box->high[a] = high[a] > box->high[a] ? high[a] : box->high[a];
    }
    box->radius = radius > box->radius ? radius : box->radius;
}

static void node_set(struct block_node *node, unsigned child, const struct box *box)
{
    for (int a = 0; a < 3; a++) {
        node->low[a][child] = box->low[a];
        node->high[a][child] = box->high[a];
    }
    node->radius[child] = box->radius;
}

static struct box node_get(const struct block_node *node, unsigned child)
{
    struct box box = { .radius = node->radius[child] };
    for (int a = 0; a < 3; a++) {
        box.low[a] = node->low[a][child];
        box.high[a] = node->high[a][child];
    }
    return box;
}

static struct box fill_block(const struct fill *f, size_t b)
{
    struct splat_block *block = &f->tree->block[b];
    struct box box = no_box;
    for (size_t k = 0; k < BLOCK_SPLATS; k++) {
        uint32_t id = f->tree->id[b * BLOCK_SPLATS + k];
        bool pad = id == UINT32_MAX;
        const double *p = pad ? NULL : f->splats->position[id];
        block->x[k] = pad ? NAN : p[0];
        block->y[k] = pad ? NAN : p[1];
        block->z[k] = pad ? NAN : p[2];
        block->radius[k] = pad ? 0 : f->splats->radius[id];
        if (!pad)
            box_add(&box, p, p, f->splats->radius[id]);
    }
    return box;
}

static struct box node_bounds(const struct block_node *node)
{
    struct box box = no_box;
    for (unsigned k = 0; k < BLOCK_FANOUT; k++) {
        struct box child = node_get(node, k);
        box_add(&box, child.low, child.high, child.radius);
    }
    return box;
}

static void fill_nodes(void *context, size_t begin, size_t end, unsigned)
{
    struct fill *f = context;
    const struct block_tree *t = f->tree;
    size_t children = f->level ? t->count[f->level - 1] : t->blocks;
    for (size_t n = begin; n < end; n++)
        for (unsigned k = 0; k < BLOCK_FANOUT; k++) {
            size_t child = n * BLOCK_FANOUT + k;
            struct box box = child >= children ? no_box
                             : f->level        ? node_bounds(&t->node[f->level - 1][child])
                                               : fill_block(f, child);
            node_set(&t->node[f->level][n], k, &box);
        }
}

/* Lane to splat, in canonical order. */
static void fill_ids(const struct splats *splats, const uint8_t *skip, struct block_tree *tree)
{
    size_t n = 0;
    for (size_t i = 0; i < splats->count; i++)
        if (!skip || !skip[i])
            tree->id[n++] = (uint32_t)i;
    while (n < tree->blocks * BLOCK_SPLATS)
        tree->id[n++] = UINT32_MAX;
}

static size_t plan_levels(struct block_tree *tree)
{
    size_t nodes = 0;
    for (size_t n = tree->blocks; n > 1 || (n && !tree->levels);) {
        n = (n + BLOCK_FANOUT - 1) / BLOCK_FANOUT;
        tree->count[tree->levels++] = n;
        nodes += n;
    }
    return nodes;
}

enum stp_result block_tree_build(const struct stp_env *env, const struct splats *splats,
                                 const uint8_t *skip, struct block_tree *tree)
{
    struct block_tree t = { .splats = splats->count };
    for (size_t i = 0; skip && i < splats->count; i++)
        t.splats -= skip[i] != 0;
    t.blocks = (t.splats + BLOCK_SPLATS - 1) / BLOCK_SPLATS;
    size_t nodes = plan_levels(&t);
    t.id = mem_alloc(t.blocks, BLOCK_SPLATS * sizeof *t.id);
    t.block = mem_alloc(t.blocks, sizeof *t.block);
    t.nodes = mem_alloc(nodes, sizeof *t.nodes);
    if (!t.id || !t.block || !t.nodes) {
        block_tree_release(&t);
        return log_no_memory(env, t.blocks * sizeof *t.block, "the overlap search");
    }
    fill_ids(splats, skip, &t);
    struct fill fill = { .splats = splats, .tree = &t };
    struct block_node *next = t.nodes;
    for (; fill.level < t.levels; next += t.count[fill.level++]) {
        t.node[fill.level] = next;
        parallel_for(env, t.count[fill.level], GRAIN, fill_nodes, &fill);
    }
    *tree = t;
    return STP_OK;
}

void block_tree_release(struct block_tree *tree)
{
    mem_free(tree->id);
    mem_free(tree->block);
    mem_free(tree->nodes);
    *tree = (struct block_tree){ 0 };
}

static inline pair load(const double *p)
{
    pair v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* Lanes k and k + 1 of the node: is the child within reach of the box? */
static inline mask pair_near(const struct block_node *n, int k, const struct box *box,
                             double overlap)
{
    pair squared = { 0, 0 };
    for (int a = 0; a < 3; a++) {
        pair above = load(&n->low[a][k]) - box->high[a], below = box->low[a] - load(&n->high[a][k]);
        mask positive = above > 0, negative = below > 0;
        pair gap = (pair)(((mask)above & positive) | ((mask)below & negative));
        squared += gap * gap;
    }
    pair reach = overlap * (load(&n->radius[k]) + box->radius);
    return squared < reach * reach;
}

/* A bit a child. */
static inline unsigned children_near(const struct block_node *n, const struct box *box,
                                     double overlap)
{
    mask bits = (pair_near(n, 0, box, overlap) & (mask){ 1, 2 }) |
                (pair_near(n, 2, box, overlap) & (mask){ 4, 8 });
    return (unsigned)(bits[0] | bits[1]);
}

/* A depth-first walk, ascending. */
struct walk {
    const struct block_tree *tree;
    unsigned depth;
    struct {
        uint32_t node;
        unsigned level;
    } stack[BLOCK_LEVELS * BLOCK_FANOUT];
};

static void walk_push(struct walk *w, size_t node, unsigned level)
{
    w->stack[w->depth].node = (uint32_t)node;
    w->stack[w->depth++].level = level;
}

static void walk_start(struct walk *w, const struct block_tree *tree)
{
    w->tree = tree;
    w->depth = 0;
    if (tree->levels)
        walk_push(w, 0, tree->levels - 1);
}

static void walk_push_children(struct walk *w, size_t node, unsigned level, unsigned children)
{
    for (unsigned k = BLOCK_FANOUT; k-- > 0;)
        if (children >> k & 1)
            walk_push(w, node * BLOCK_FANOUT + k, level - 1);
}

size_t block_tree_near(const struct block_tree *tree, size_t b, double overlap, uint32_t *found)
{
    struct walk w;
    size_t count = 0;
    const struct box self = node_get(&tree->node[0][b / BLOCK_FANOUT], b % BLOCK_FANOUT);
    for (walk_start(&w, tree); w.depth;) {
        uint32_t node = w.stack[--w.depth].node;
        unsigned level = w.stack[w.depth].level;
        unsigned children = children_near(&tree->node[level][node], &self, overlap);
        if (level)
            walk_push_children(&w, node, level, children);
        for (; !level && children; children &= children - 1)
            found[count++] = node * BLOCK_FANOUT + (uint32_t)__builtin_ctz(children);
    }
    return count;
}

struct crowd {
    const struct block_tree *tree;
    double overlap;
    unsigned limit;
    uint8_t *skip;
};

/* The children under which a splat may come before `id` of that radius. */
static unsigned children_before(const struct block_tree *tree, size_t node, unsigned level,
                                double radius, uint32_t id)
{
    unsigned children = 0;
    for (unsigned k = 0; k < BLOCK_FANOUT; k++) {
        double largest = tree->node[level][node].radius[k];
        size_t lane = ((node * BLOCK_FANOUT + k) << (2 * level)) * BLOCK_SPLATS;
        bool before =
            largest > radius || (largest == radius && lane < tree->splats && tree->id[lane] < id);
        children |= (unsigned)before << k;
    }
    return children;
}

/* How many of block b's splats come before lane `self` and overlap it. */
static unsigned preceding(const struct block_tree *tree, size_t b, size_t self, double overlap)
{
    const struct splat_block *block = &tree->block[b], *own = &tree->block[self / BLOCK_SPLATS];
    size_t s = self % BLOCK_SPLATS;
    unsigned n = 0;
    for (size_t k = 0; k < BLOCK_SPLATS; k++) {
        double dx = own->x[s] - block->x[k], dy = own->y[s] - block->y[k],
               dz = own->z[s] - block->z[k], reach = overlap * (own->radius[s] + block->radius[k]);
        bool first = block->radius[k] > own->radius[s] ||
                     (block->radius[k] == own->radius[s] && b * BLOCK_SPLATS + k < self);
        n += first && dx * dx + dy * dy + dz * dz < reach * reach;
    }
    return n;
}

static bool is_crowded(const struct crowd *c, size_t lane)
{
    const struct block_tree *tree = c->tree;
    const struct splat_block *block = &tree->block[lane / BLOCK_SPLATS];
    size_t k = lane % BLOCK_SPLATS;
    const double p[3] = { block->x[k], block->y[k], block->z[k] };
    struct box self = no_box;
    box_add(&self, p, p, block->radius[k]);
    unsigned before = 0;
    struct walk w;
    for (walk_start(&w, tree); w.depth && before < c->limit;) {
        uint32_t node = w.stack[--w.depth].node;
        unsigned level = w.stack[w.depth].level;
        unsigned children = children_near(&tree->node[level][node], &self, c->overlap) &
                            children_before(tree, node, level, self.radius, tree->id[lane]);
        if (level)
            walk_push_children(&w, node, level, children);
        for (; !level && children; children &= children - 1)
            before += preceding(tree, node * BLOCK_FANOUT + (unsigned)__builtin_ctz(children), lane,
                                c->overlap);
    }
    return before >= c->limit;
}

static void mark_crowded(void *context, size_t begin, size_t end, unsigned)
{
    struct crowd *c = context;
    for (size_t lane = begin; lane < end; lane++)
        if (is_crowded(c, lane))
            c->skip[c->tree->id[lane]] = 2;
}

enum stp_result block_tree_crowded(const struct stp_env *env, const struct splats *splats,
                                   double overlap, unsigned limit, uint8_t *skip, size_t *count)
{
    struct block_tree tree;
    enum stp_result result = block_tree_build(env, splats, skip, &tree);
    if (result != STP_OK)
        return result;
    struct crowd crowd = { &tree, overlap, limit, skip };
    parallel_for(env, tree.splats, 8192, mark_crowded, &crowd);
    *count = 0;
    for (size_t i = 0; i < splats->count; i++)
        *count += skip[i] == 2;
    block_tree_release(&tree);
    return STP_OK;
}
