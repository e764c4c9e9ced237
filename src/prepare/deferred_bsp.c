#include "prepare/deferred_bsp.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#define JOB_LEVELS 4 /* a group is walked in at most 2^4 parts, side by side */

struct item {
    float p[3];
    uint32_t id;
};

struct building {
    const struct splats *splats;
    struct cover_groups *groups;
    struct item *items;
};

/* Is a below b along the axis, along the next one where they are level, along the last one where
 * they are level again? That is a plane turned by as good as nothing, so that an eye within the
 * plane has a side too. */
static bool below(const float a[3], const float b[3], int axis)
{
    int next = (axis + 1) % 3, last = (axis + 2) % 3;
    if (a[axis] != b[axis])
        return a[axis] < b[axis];
    return a[next] != b[next] ? a[next] < b[next] : a[last] < b[last];
}

/* A total order: no two ids are equal. */
static bool item_before(struct item a, struct item b, int axis)
{
    if (below(a.p, b.p, axis))
        return true;
    return !below(b.p, a.p, axis) && a.id < b.id;
}

static size_t any_between(size_t low, size_t high)
{
    uint64_t h = (low ^ high << 24) * 0x9e3779b97f4a7c15u;
    return low + (size_t)((h >> 32) % (high - low));
}

/* Moves the n-th item of [low, high) along the axis to its place, lesser ones before it. The pivot
 * is arbitrary but the same for every run; no file can be made slow by its order. */
static void select_item(struct item *items, size_t low, size_t high, size_t n, int axis)
{
    while (high - low > 1) {
        struct item pivot = items[any_between(low, high)];
        size_t i = low, j = high - 1;
        for (;;) {
            while (item_before(items[i], pivot, axis))
                i++;
            while (item_before(pivot, items[j], axis))
                j--;
            if (i >= j)
                break;
            struct item swap = items[i];
            items[i++] = items[j];
            items[j--] = swap;
        }
        if (i == j && i == n)
            return;
        if (n < i)
            high = i;
        else
            low = i == j ? i + 1 : i; /* where they meet is the pivot itself */
    }
}

static int widest_axis(const struct item *items, size_t low, size_t high)
{
    float least[3], most[3];
    for (int a = 0; a < 3; a++)
        least[a] = most[a] = items[low].p[a];
    for (size_t i = low + 1; i < high; i++)
        for (int a = 0; a < 3; a++) {
            least[a] = items[i].p[a] < least[a] ? items[i].p[a] : least[a];
            most[a] = items[i].p[a] > most[a] ? items[i].p[a] : most[a];
        }
    int best = 0;
    for (int a = 1; a < 3; a++)
        if (most[a] - least[a] > most[best] - least[best])
            best = a;
    return best;
}

static void build_range(struct building *b, size_t low, size_t high)
{
    while (high > low) {
        size_t middle = low + (high - low) / 2;
        int axis = widest_axis(b->items, low, high);
        select_item(b->items, low, high, middle, axis);
        const struct item *m = &b->items[middle];
        b->groups->node[middle] =
            (struct bsp_node){ { m->p[0], m->p[1], m->p[2] }, m->id, (uint8_t)axis };
        build_range(b, middle + 1, high);
        high = middle;
    }
}

static void build_groups(void *context, size_t begin, size_t end, unsigned worker)
{
    struct building *b = context;
    for (size_t k = begin; k < end; k++)
        build_range(b, b->groups->first[k], b->groups->first[k + 1]);
}

enum stp_result bsp_build(const struct stp_env *env, const struct splats *splats,
                          struct cover_groups *groups, const uint32_t *member)
{
    size_t count = groups->first[groups->groups];
    struct building b = { splats, groups, mem_alloc(count, sizeof *b.items) };
    groups->node = mem_alloc(count, sizeof *groups->node);
    bool ok = b.items && groups->node;
    for (size_t i = 0; ok && i < count; i++) {
        b.items[i].id = member[i];
        for (int a = 0; a < 3; a++)
            b.items[i].p[a] = (float)(splats->position[member[i]][a] - splats->origin[a]);
    }
    if (ok)
        parallel_for(env, groups->groups, 1, build_groups, &b);
    mem_free(b.items);
    if (ok)
        return STP_OK;
    mem_free(groups->node);
    groups->node = NULL;
    return log_no_memory(env, count * sizeof *b.items, "the BSP tree");
}

/* A part of a walk: nodes [low, high) go to out[at] and on. */
struct job {
    size_t low, high, at;
};

struct walk {
    const struct bsp_node *node;
    float eye[3];
    uint32_t *out;
    unsigned count;
    struct job job[STP_MAX_GROUPS << JOB_LEVELS];
};

/* Is what lies above the node's plane behind it? */
static bool high_is_far(const struct walk *w, const struct bsp_node *n)
{
    return below(w->eye, n->p, n->axis);
}

static void emit(const struct walk *w, size_t low, size_t high, uint32_t *out)
{
    while (high > low) {
        size_t middle = low + (high - low) / 2;
        const struct bsp_node *n = &w->node[middle];
        bool above = high_is_far(w, n);
        size_t far = above ? high - middle - 1 : middle - low;
        emit(w, above ? middle + 1 : low, above ? high : middle, out);
        out[far] = n->id;
        out += far + 1;
        if (above)
            high = middle;
        else
            low = middle + 1;
    }
}

/* Cuts [low, high) into jobs; the nodes above them are put out at once. */
static void cut(struct walk *w, struct job j, unsigned levels)
{
    if (levels == 0 || j.high - j.low < 1024) {
        w->job[w->count++] = j;
        return;
    }
    size_t middle = j.low + (j.high - j.low) / 2;
    bool above = high_is_far(w, &w->node[middle]);
    struct job low = { j.low, middle, j.at }, high = { middle + 1, j.high, j.at };
    if (above)
        low.at += j.high - middle;
    else
        high.at += middle - j.low + 1;
    w->out[above ? j.at + j.high - middle - 1 : j.at + middle - j.low] = w->node[middle].id;
    cut(w, low, levels - 1);
    cut(w, high, levels - 1);
}

static void run_jobs(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct walk *w = context;
    for (size_t i = begin; i < end; i++)
        emit(w, w->job[i].low, w->job[i].high, w->out + w->job[i].at);
}

void bsp_order(const struct stp_env *env, const struct cover_groups *groups, const double eye[3],
               uint32_t *out)
{
    struct walk w = { .node = groups->node, .out = out };
    for (int a = 0; a < 3; a++)
        w.eye[a] = (float)eye[a];
    for (unsigned k = 0; k < groups->groups; k++)
        cut(&w, (struct job){ groups->first[k], groups->first[k + 1], groups->first[k] },
            JOB_LEVELS);
    parallel_for(env, w.count, 1, run_jobs, &w);
}
