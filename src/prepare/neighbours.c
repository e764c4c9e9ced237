/* The distance to a box is computed with the very operations of the distance to a point in it, and
 * rounding is monotonic, so the bound never exceeds the distance: the answer is exact. */
#include "prepare/neighbours.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

struct build {
    struct neighbour_tree *tree;
    unsigned level;
};

static void box_of_leaf(const struct neighbour_tree *t, size_t leaf, double low[3], double high[3])
{
    size_t begin = leaf * TREE_LEAF,
           end = begin + TREE_LEAF < t->count ? begin + TREE_LEAF : t->count;
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = INFINITY;
        high[axis] = -INFINITY;
        for (size_t i = begin; i < end; i++) {
            low[axis] = fmin(low[axis], t->position[i][axis]);
            high[axis] = fmax(high[axis], t->position[i][axis]);
        }
    }
}

static unsigned child_count(const struct neighbour_tree *t, unsigned level, size_t node)
{
    size_t left = t->size[level] - node * TREE_FAN;
    return left < TREE_FAN ? (unsigned)left : TREE_FAN;
}

static void box_of_node(const struct neighbour_tree *t, unsigned level, size_t node, double low[3],
                        double high[3])
{
    const struct tree_boxes *boxes = &t->level[level][node];
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = INFINITY;
        high[axis] = -INFINITY;
        for (unsigned child = 0; child < child_count(t, level, node); child++) {
            low[axis] = fmin(low[axis], boxes->low[axis][child]);
            high[axis] = fmax(high[axis], boxes->high[axis][child]);
        }
    }
}

static void fill_level(void *context, size_t begin, size_t end, unsigned)
{
    const struct build *b = context;
    const struct neighbour_tree *t = b->tree;
    for (size_t child = begin; child < end; child++) {
        struct tree_boxes *boxes = &t->level[b->level][child / TREE_FAN];
        double low[3], high[3];
        if (b->level == 0)
            box_of_leaf(t, child, low, high);
        else
            box_of_node(t, b->level - 1, child, low, high);
        for (int axis = 0; axis < 3; axis++) {
            boxes->low[axis][child % TREE_FAN] = low[axis];
            boxes->high[axis][child % TREE_FAN] = high[axis];
        }
    }
}

enum stp_result neighbour_tree_build(const struct stp_env *env, const double (*position)[3],
                                     size_t count, struct neighbour_tree *tree)
{
    struct neighbour_tree t = { .count = count, .position = position };
    size_t size = (count + TREE_LEAF - 1) / TREE_LEAF;
    do {
        size_t nodes = (size + TREE_FAN - 1) / TREE_FAN;
        t.size[t.levels] = size;
        t.level[t.levels] = mem_zalloc(nodes, sizeof *t.level[0]);
        if (!t.level[t.levels++]) {
            neighbour_tree_release(&t);
            return log_no_memory(env, nodes * sizeof *t.level[0], "the tree of neighbours");
        }
        struct build build = { &t, t.levels - 1 };
        parallel_for(env, size, 512, fill_level, &build);
        size = nodes;
    } while (size > 1);
    *tree = t;
    return STP_OK;
}

void neighbour_tree_release(struct neighbour_tree *tree)
{
    for (unsigned level = 0; level < tree->levels; level++)
        mem_free(tree->level[level]);
    *tree = (struct neighbour_tree){ 0 };
}

struct query {
    const struct neighbour_tree *tree;
    size_t self, own_leaf;
    double p[3];
    unsigned k;
    double worst; /* distance of the k-th so far */
    struct neighbours *best;
};

static void offer(struct query *q, double distance, uint32_t id)
{
    struct neighbours *b = q->best;
    unsigned at = b->count;
    if (at == q->k) {
        if (distance == q->worst && id > b->id[at - 1])
            return;
        at--;
    } else {
        b->count++;
    }
    for (; at > 0 && (b->distance[at - 1] > distance ||
                      (b->distance[at - 1] == distance && b->id[at - 1] > id));
         at--) {
        b->distance[at] = b->distance[at - 1];
        b->id[at] = b->id[at - 1];
    }
    b->distance[at] = distance;
    b->id[at] = id;
    if (b->count == q->k)
        q->worst = b->distance[q->k - 1];
}

static void scan_leaf(struct query *q, size_t leaf)
{
    const struct neighbour_tree *t = q->tree;
    size_t begin = leaf * TREE_LEAF,
           end = begin + TREE_LEAF < t->count ? begin + TREE_LEAF : t->count;
    for (size_t i = begin; i < end; i++) {
        double x = t->position[i][0] - q->p[0], y = t->position[i][1] - q->p[1],
               z = t->position[i][2] - q->p[2];
        double distance = x * x + y * y + z * z;
        if (distance <= q->worst && i != q->self)
            offer(q, distance, (uint32_t)i);
    }
}

static double outside(double p, double low, double high)
{
    double below = low - p, above = p - high;
    double side = below > above ? below : above;
    return side > 0 ? side : 0;
}

static void box_distances(const struct query *q, const struct tree_boxes *boxes,
                          double distance[TREE_FAN])
{
    for (unsigned c = 0; c < TREE_FAN; c++) {
        double x = outside(q->p[0], boxes->low[0][c], boxes->high[0][c]);
        double y = outside(q->p[1], boxes->low[1][c], boxes->high[1][c]);
        double z = outside(q->p[2], boxes->low[2][c], boxes->high[2][c]);
        distance[c] = x * x + y * y + z * z;
    }
}

static size_t first_point(unsigned level, size_t child)
{
    for (; level > 0; level--)
        child *= TREE_FAN;
    return child * TREE_LEAF;
}

/* Children nearer than the k-th so far, nearest first. */
static void visit(struct query *q, unsigned level, size_t node)
{
    double distance[TREE_FAN];
    unsigned char order[TREE_FAN];
    unsigned wanted = 0, children = child_count(q->tree, level, node);
    box_distances(q, &q->tree->level[level][node], distance);
    for (unsigned c = 0; c < children; c++) {
        if (distance[c] > q->worst)
            continue;
        unsigned at = wanted++;
        for (; at > 0 && distance[order[at - 1]] > distance[c]; at--)
            order[at] = order[at - 1];
        order[at] = (unsigned char)c;
    }
    for (unsigned i = 0; i < wanted && distance[order[i]] <= q->worst; i++) {
        size_t child = node * TREE_FAN + order[i];
        if (distance[order[i]] == q->worst && first_point(level, child) > q->best->id[q->k - 1])
            continue; /* ties go to lower ids */
        if (level > 0)
            visit(q, level - 1, child);
        else if (child + 1 < q->own_leaf || child > q->own_leaf + 1)
            scan_leaf(q, child);
    }
}

void neighbours_of(const struct neighbour_tree *tree, size_t i, unsigned k,
                   struct neighbours *nearest)
{
    struct query q = { .tree = tree,
                       .self = i,
                       .own_leaf = i / TREE_LEAF,
                       .k = k,
                       .worst = INFINITY,
                       .best = nearest };
    memcpy(q.p, tree->position[i], sizeof q.p);
    nearest->count = 0;
    /* The runs before and after are near in space: they make a tight first bound. */
    scan_leaf(&q, q.own_leaf);
    if (q.own_leaf > 0)
        scan_leaf(&q, q.own_leaf - 1);
    if (q.own_leaf + 1 < tree->size[0])
        scan_leaf(&q, q.own_leaf + 1);
    visit(&q, tree->levels - 1, 0);
}
