#include "prepare/deferred_bsp.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/radix.h"

#define JOB_LEVELS 4 /* a group is walked in at most 2^4 parts, side by side */

/* Sine of the angle between a plane and the ray to its node, below which the plane counts as seen
 * edge-on. Then sheets 1 / EDGE_ON of the discs' reach and more apart are right beside all planes.
 */
#define EDGE_ON 0.0625f

/* Planes are at right angles to one of these: the axes, and what lies halfway between two. */
#define DIRECTIONS 9
static const int8_t directions[DIRECTIONS][3] = { { 1, 0, 0 },  { 0, 1, 0 },  { 0, 0, 1 },
                                                  { 1, 1, 0 },  { 1, -1, 0 }, { 1, 0, 1 },
                                                  { 1, 0, -1 }, { 0, 1, 1 },  { 0, 1, -1 } };

struct item {
    float p[3];
    uint32_t id;
};

struct building {
    const struct splats *splats;
    struct cover_groups *groups;
    struct item *items;
};

static float along(const float p[3], int direction)
{
    const int8_t *d = directions[direction];
    return (float)d[0] * p[0] + (float)d[1] * p[1] + (float)d[2] * p[2];
}

/* Is a below b along the direction, along the first axis where they are level, and so on? That is a
 * plane turned by as good as nothing, so that an eye within the plane has a side too. */
static bool below(const float a[3], const float b[3], int direction)
{
    float s = along(a, direction), t = along(b, direction);
    if (s != t)
        return s < t;
    if (a[0] != b[0])
        return a[0] < b[0];
    return a[1] != b[1] ? a[1] < b[1] : a[2] < b[2];
}

/* A total order: no two ids are equal. */
static bool item_before(struct item a, struct item b, int direction)
{
    if (below(a.p, b.p, direction))
        return true;
    return !below(b.p, a.p, direction) && a.id < b.id;
}

static size_t any_between(size_t low, size_t high)
{
    uint64_t h = (low ^ high << 24) * 0x9e3779b97f4a7c15u;
    return low + (size_t)((h >> 32) % (high - low));
}

/* Moves the n-th item of [low, high) along the direction to its place, lesser ones before it. The
 * pivot is arbitrary but the same for every run; no file can be made slow by its order. */
static void select_item(struct item *items, size_t low, size_t high, size_t n, int direction)
{
    while (high - low > 1) {
        struct item pivot = items[any_between(low, high)];
        size_t i = low, j = high - 1;
        for (;;) {
            while (item_before(items[i], pivot, direction))
                i++;
            while (item_before(pivot, items[j], direction))
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

/* Second moments, xx yy zz xy xz yz. */
static void moments_add(double m[6], const double v[3], double weight)
{
    for (int a = 0; a < 3; a++)
        m[a] += weight * v[a] * v[a];
    m[3] += weight * v[0] * v[1];
    m[4] += weight * v[0] * v[2];
    m[5] += weight * v[1] * v[2];
}

static double moments_along(const double m[6], int direction)
{
    const int8_t *d = directions[direction];
    double squares = m[0] * d[0] * d[0] + m[1] * d[1] * d[1] + m[2] * d[2] * d[2];
    return squares + 2 * (m[3] * d[0] * d[1] + m[4] * d[0] * d[2] + m[5] * d[1] * d[2]);
}

/* The direction in which centres are spread most for what their discs reach along it, which is
 * r sqrt(1 - (n.d)^2): a plane across it cuts the fewest discs, and those are what may come in the
 * wrong order. Sheets closer than their discs are wide are so parted along their normal. A cut
 * across an edge of a box is sqrt(2) as long as one across a face: slanted planes must be better by
 * that. */
static int least_cut(const struct building *b, size_t low, size_t high)
{
    const struct splats *splats = b->splats;
    double spread[6] = { 0 }, flat[6] = { 0 }, reach = 0, best = -1;
    const float *from = b->items[low].p;
    double mean[3] = { 0 }, count = (double)(high - low);
    int found = 0;
    for (size_t i = low; i < high; i++) {
        uint32_t id = b->items[i].id;
        double p[3], n[3], r2 = (double)splats->radius[id] * splats->radius[id];
        for (int a = 0; a < 3; a++) {
            p[a] = (double)b->items[i].p[a] - from[a];
            n[a] = splats->normal[id][a];
            mean[a] += p[a] / count;
        }
        moments_add(spread, p, 1);
        moments_add(flat, n, r2);
        reach += r2;
    }
    moments_add(spread, mean, -count);
    for (int d = 0; d < DIRECTIONS; d++) {
        double length2 = d < 3 ? 1 : 2, cut = length2 * reach - moments_along(flat, d);
        double gain = moments_along(spread, d) / (length2 * fmax(cut, 1e-6 * reach));
        if (gain > best) {
            best = gain;
            found = d;
        }
    }
    return found;
}

static void build_range(struct building *b, size_t low, size_t high)
{
    while (high > low) {
        size_t middle = low + (high - low) / 2;
        int direction = least_cut(b, low, high);
        select_item(b->items, low, high, middle, direction);
        const struct item *m = &b->items[middle];
        b->groups->node[middle] =
            (struct bsp_node){ { m->p[0], m->p[1], m->p[2] }, m->id, (uint8_t)direction };
        build_range(b, middle + 1, high);
        high = middle;
    }
}

static void build_groups(void *context, size_t begin, size_t end, unsigned)
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
    bool by_distance;
};

struct walk {
    const struct bsp_node *node;
    float eye[3];
    bool parallel;           /* then the eye is a direction, and */
    bool beyond[DIRECTIONS]; /* is what lies above a plane nearer to it? */
    uint32_t *out;
    unsigned count;
    struct job job[STP_MAX_GROUPS << JOB_LEVELS];
};

/* Is what lies above the node's plane behind it? */
static bool high_is_far(const struct walk *w, const struct bsp_node *n)
{
    return w->parallel ? !w->beyond[n->direction] : below(w->eye, n->p, n->direction);
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

static bool seen_edge_on(const struct walk *w, const struct bsp_node *n)
{
    float v[3], square = 0;
    for (int a = 0; a < 3; a++) {
        v[a] = w->parallel ? w->eye[a] : w->eye[a] - n->p[a];
        square += v[a] * v[a];
    }
    float across = along(v, n->direction), length2 = n->direction < 3 ? 1 : 2;
    return across * across < EDGE_ON * EDGE_ON * length2 * square;
}

/* Cuts [low, high) into jobs; the nodes above them are put out at once. */
static void cut(struct walk *w, struct job j, unsigned levels)
{
    size_t middle = j.low + (j.high - j.low) / 2;
    j.by_distance = levels > 0 && j.high > j.low && seen_edge_on(w, &w->node[middle]);
    if (levels == 0 || j.high - j.low < 1024 || j.by_distance) {
        w->job[w->count++] = j;
        return;
    }
    bool above = high_is_far(w, &w->node[middle]);
    struct job low = { j.low, middle, j.at, false }, high = { middle + 1, j.high, j.at, false };
    if (above)
        low.at += j.high - middle;
    else
        high.at += middle - j.low + 1;
    w->out[above ? j.at + j.high - middle - 1 : j.at + middle - j.low] = w->node[middle].id;
    cut(w, low, levels - 1);
    cut(w, high, levels - 1);
}

static void run_jobs(void *context, size_t begin, size_t end, unsigned)
{
    const struct walk *w = context;
    for (size_t i = begin; i < end; i++)
        if (!w->job[i].by_distance)
            emit(w, w->job[i].low, w->job[i].high, w->out + w->job[i].at);
}

/* Grows with the distance from the eye. */
static double distance(const struct walk *w, const float p[3])
{
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        double v = (double)p[a] - w->eye[a];
        sum += w->parallel ? -(double)p[a] * w->eye[a] : v * v;
    }
    return sum;
}

/* In memory of its own: `out` may be a device's, slow to read. */
static enum stp_result sort_job(const struct stp_env *env, const struct walk *w, struct job j)
{
    size_t count = j.high - j.low;
    uint64_t *key = mem_alloc(count, sizeof *key);
    uint32_t *id = mem_alloc(count, sizeof *id);
    enum stp_result result = STP_OK;
    if (!key || !id)
        result = log_no_memory(env, count * (sizeof *key + sizeof *id), "the order of splats");
    for (size_t i = 0; i < count && result == STP_OK; i++) {
        const struct bsp_node *n = &w->node[j.low + i];
        key[i] = ~radix_ascending((float)distance(w, n->p)); /* a float's digits */
        id[i] = n->id;
    }
    if (result == STP_OK)
        result = radix_sort(env, count, key, id);
    if (result == STP_OK)
        memcpy(w->out + j.at, id, count * sizeof *id);
    mem_free(key);
    mem_free(id);
    return result;
}

enum stp_result bsp_order(const struct stp_env *env, const struct cover_groups *groups,
                          const double eye[4], uint32_t *out)
{
    static const float origin[3];
    struct walk w = { .node = groups->node, .out = out, .parallel = eye[3] == 0 };
    for (int a = 0; a < 3; a++)
        w.eye[a] = (float)eye[a];
    for (int d = 0; d < DIRECTIONS; d++)
        w.beyond[d] = below(origin, w.eye, d);
    for (unsigned k = 0; k < groups->groups; k++)
        cut(&w, (struct job){ groups->first[k], groups->first[k + 1], groups->first[k], false },
            JOB_LEVELS);
    parallel_for(env, w.count, 1, run_jobs, &w);
    enum stp_result result = STP_OK;
    for (unsigned i = 0; i < w.count && result == STP_OK; i++)
        if (w.job[i].by_distance)
            result = sort_job(env, &w, w.job[i]);
    return result;
}
