#include "prepare/deferred_blocks.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#include <math.h>

#define GRAIN 1024 /* blocks */

struct fill {
    const struct splats *splats;
    struct block_tree *tree;
    unsigned level;
};

static void box_empty(struct block_box *box)
{
    for (int a = 0; a < 3; a++) {
        box->low[a] = INFINITY;
        box->high[a] = -INFINITY;
    }
    box->radius = 0;
}

static void box_add(struct block_box *box, const double low[3], const double high[3], double radius)
{
    for (int a = 0; a < 3; a++) {
        box->low[a] = low[a] < box->low[a] ? low[a] : box->low[a];
        box->high[a] = high[a] > box->high[a] ? high[a] : box->high[a];
    }
    box->radius = radius > box->radius ? radius : box->radius;
}

static void fill_blocks(void *context, size_t begin, size_t end, unsigned worker)
{
    struct fill *f = context;
    for (size_t b = begin; b < end; b++) {
        struct splat_block *block = &f->tree->block[b];
        struct block_box *box = &f->tree->box[0][b];
        box_empty(box);
        for (int k = 0; k < BLOCK_SPLATS; k++) {
            uint32_t id = f->tree->id[b * BLOCK_SPLATS + k];
            bool pad = id == UINT32_MAX;
            const double *p = pad ? NULL : f->splats->position[id];
            block->x[k] = pad ? NAN : p[0];
            block->y[k] = pad ? NAN : p[1];
            block->z[k] = pad ? NAN : p[2];
            block->radius[k] = pad ? 0 : f->splats->radius[id];
            if (!pad)
                box_add(box, p, p, f->splats->radius[id]);
        }
    }
}

static void fill_boxes(void *context, size_t begin, size_t end, unsigned worker)
{
    struct fill *f = context;
    const struct block_box *below = f->tree->box[f->level - 1];
    size_t last = f->tree->count[f->level - 1];
    for (size_t b = begin; b < end; b++) {
        struct block_box *box = &f->tree->box[f->level][b];
        box_empty(box);
        for (size_t k = b * BLOCK_FANOUT; k < (b + 1) * BLOCK_FANOUT && k < last; k++)
            box_add(box, below[k].low, below[k].high, below[k].radius);
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
    size_t boxes = 0, n = tree->blocks;
    for (tree->levels = 0; tree->levels < BLOCK_LEVELS;) {
        tree->count[tree->levels++] = n;
        boxes += n;
        if (n <= 1)
            break;
        n = (n + BLOCK_FANOUT - 1) / BLOCK_FANOUT;
    }
    return boxes;
}

enum stp_result block_tree_build(const struct stp_env *env, const struct splats *splats,
                                 const uint8_t *skip, struct block_tree *tree)
{
    struct block_tree t = { .splats = splats->count };
    for (size_t i = 0; skip && i < splats->count; i++)
        t.splats -= skip[i] != 0;
    t.blocks = (t.splats + BLOCK_SPLATS - 1) / BLOCK_SPLATS;
    size_t boxes = plan_levels(&t);
    t.id = mem_alloc(t.blocks, BLOCK_SPLATS * sizeof *t.id);
    t.block = mem_alloc(t.blocks, sizeof *t.block);
    t.boxes = mem_alloc(boxes, sizeof *t.boxes);
    if (!t.id || !t.block || !t.boxes) {
        block_tree_release(&t);
        return log_no_memory(env, t.blocks * sizeof *t.block, "the overlap search");
    }
    fill_ids(splats, skip, &t);
    struct fill fill = { .splats = splats, .tree = &t };
    t.box[0] = t.boxes;
    parallel_for(env, t.blocks, GRAIN, fill_blocks, &fill);
    for (fill.level = 1; fill.level < t.levels; fill.level++) {
        t.box[fill.level] = t.box[fill.level - 1] + t.count[fill.level - 1];
        parallel_for(env, t.count[fill.level], GRAIN, fill_boxes, &fill);
    }
    *tree = t;
    return STP_OK;
}

void block_tree_release(struct block_tree *tree)
{
    mem_free(tree->id);
    mem_free(tree->block);
    mem_free(tree->boxes);
    *tree = (struct block_tree){ 0 };
}

static bool boxes_near(const struct block_box *a, const struct block_box *b, double overlap)
{
    double squared = 0;
    for (int k = 0; k < 3; k++) {
        double above = a->low[k] - b->high[k], below = b->low[k] - a->high[k];
        double gap = above > below ? above : below;
        gap = gap > 0 ? gap : 0;
        squared += gap * gap;
    }
    double reach = overlap * (a->radius + b->radius);
    return squared < reach * reach;
}

/* A depth-first walk in ascending order. */
struct walk {
    const struct block_tree *tree;
    unsigned depth;
    struct {
        uint32_t box;
        unsigned level;
    } stack[BLOCK_LEVELS * BLOCK_FANOUT];
};

static void walk_push(struct walk *w, size_t box, unsigned level)
{
    w->stack[w->depth].box = (uint32_t)box;
    w->stack[w->depth++].level = level;
}

static void walk_start(struct walk *w, const struct block_tree *tree)
{
    w->tree = tree;
    w->depth = 0;
    if (tree->blocks)
        walk_push(w, 0, tree->levels - 1);
}

static void walk_descend(struct walk *w, size_t box, unsigned level)
{
    size_t first = box * BLOCK_FANOUT, end = first + BLOCK_FANOUT;
    if (end > w->tree->count[level - 1])
        end = w->tree->count[level - 1];
    while (end-- > first)
        walk_push(w, end, level - 1);
}

size_t block_tree_near(const struct block_tree *tree, size_t b, double overlap, uint32_t *found)
{
    struct walk w;
    size_t count = 0;
    const struct block_box *self = &tree->box[0][b];
    for (walk_start(&w, tree); w.depth;) {
        uint32_t box = w.stack[--w.depth].box;
        unsigned level = w.stack[w.depth].level;
        if (!boxes_near(self, &tree->box[level][box], overlap))
            continue;
        if (level == 0)
            found[count++] = box;
        else
            walk_descend(&w, box, level);
    }
    return count;
}

struct crowd {
    const struct block_tree *tree;
    double overlap;
    unsigned limit;
    uint8_t *skip;
};

/* Could a splat under this box come before `id` of that radius? */
static bool may_precede(const struct block_tree *tree, size_t box, unsigned level, double radius,
                        uint32_t id)
{
    double largest = tree->box[level][box].radius;
    size_t lane = (box << (2 * level)) * BLOCK_SPLATS;
    return largest > radius || (largest == radius && tree->id[lane] < id);
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
    struct block_box self;
    const double p[3] = { block->x[k], block->y[k], block->z[k] };
    box_empty(&self);
    box_add(&self, p, p, block->radius[k]);
    unsigned before = 0;
    struct walk w;
    for (walk_start(&w, tree); w.depth && before < c->limit;) {
        uint32_t box = w.stack[--w.depth].box;
        unsigned level = w.stack[w.depth].level;
        if (!may_precede(tree, box, level, self.radius, tree->id[lane]) ||
            !boxes_near(&self, &tree->box[level][box], c->overlap))
            continue;
        if (level == 0)
            before += preceding(tree, box, lane, c->overlap);
        else
            walk_descend(&w, box, level);
    }
    return before >= c->limit;
}

static void mark_crowded(void *context, size_t begin, size_t end, unsigned worker)
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
    parallel_for(env, tree.splats, GRAIN * BLOCK_SPLATS, mark_crowded, &crowd);
    *count = 0;
    for (size_t i = 0; i < splats->count; i++)
        *count += skip[i] == 2;
    block_tree_release(&tree);
    return STP_OK;
}
