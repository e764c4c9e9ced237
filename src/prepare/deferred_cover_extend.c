/* ZP 4.2.2: groups are made to cover the surface by duplicates, or by larger radii. */
#include "prepare/deferred_cover.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#include <math.h>
#include <stdatomic.h>

#define SWEEPS        6
#define SETTLED       512               /* of so many splats, one moved: that will do */
#define LEAST_NEW     2                 /* points: a splat with fewer new ones is not added */
#define RADIUS_BUDGET ((size_t)1 << 18) /* points that a step of Eq. 9 looks at */
#define RADIUS_STEPS  32
#define LARGEST_STEP  0.2  /* of a squared factor */
#define CLOSE_ENOUGH  5e-4 /* of the surface */

static unsigned count_bits(uint32_t word)
{
    return (unsigned)__builtin_popcount(word);
}

/* The group whose members cover the splat least; its own where that is as good, else the smallest
 * of several. */
static unsigned least_covered(const struct cover *c, size_t i, const uint8_t *group,
                              const size_t *size)
{
    struct overlap_row row = overlap_row(&c->graph, i);
    uint32_t covered[STP_MAX_GROUPS] = { 0 };
    for (size_t e = 0; e < row.degree; e++)
        if (group[row.neighbour[e]] < c->groups)
            covered[group[row.neighbour[e]]] |= cover_edge(c, i, e);
    bool fresh = group[i] >= c->groups;
    unsigned best = fresh ? 0 : group[i];
    for (unsigned k = 0; k < c->groups; k++) {
        unsigned bits = count_bits(covered[k]), least = count_bits(covered[best]);
        if (bits < least || (fresh && bits == least && size[k] < size[best]))
            best = k;
    }
    return best;
}

static void sweep(const struct cover *c, uint8_t *group)
{
    size_t n = c->splats->count, moved = n, size[STP_MAX_GROUPS] = { 0 };
    for (unsigned round = 0; round < SWEEPS && moved > n / SETTLED; round++) {
        moved = 0;
        for (size_t i = 0; i < n; i++) {
            if (c->skip[i])
                continue;
            unsigned best = least_covered(c, i, group, size);
            size[best] += round == 0;
            moved += group[i] != best;
            group[i] = (uint8_t)best;
        }
    }
}

void cover_assign(struct cover *cover)
{
    size_t turn = 0;
    sweep(cover, cover->home);
    for (size_t i = 0; i < cover->splats->count; i++) {
        if (cover->skip[i] == COVER_CROWDED)
            cover->home[i] = (uint8_t)(turn++ % cover->groups);
        cover->member[i] = cover->home[i] < cover->groups ? (uint64_t)1 << cover->home[i] : 0;
    }
}

/* A splat that may join the group, by the area that it would add: the queue of ZP 4.2.2 (1). The
 * area only falls while the group grows, so an entry that is still right when it comes up is the
 * best there is. */
struct candidate {
    float area;
    uint32_t id;
};

/* One group as it grows. */
struct growing {
    struct cover *cover;
    uint64_t bit;
    double missing; /* area until the target is met */
    uint32_t *have; /* points of every splat that the group covers */
    struct candidate *heap;
    size_t size, room; /* of the heap; members that may still join */
};

static bool before(struct candidate a, struct candidate b)
{
    return a.area > b.area || (a.area == b.area && a.id < b.id);
}

static void sift_down(struct growing *g, size_t at)
{
    struct candidate moving = g->heap[at];
    for (size_t child = 2 * at + 1; child < g->size; child = 2 * at + 1) {
        if (child + 1 < g->size && before(g->heap[child + 1], g->heap[child]))
            child++;
        if (!before(g->heap[child], moving))
            break;
        g->heap[at] = g->heap[child];
        at = child;
    }
    g->heap[at] = moving;
}

static float new_area(const struct growing *g, size_t i)
{
    unsigned points = COVER_POINTS - count_bits(g->have[i]);
    float r = g->cover->splats->radius[i];
    return points < LEAST_NEW ? 0 : (float)points * r * r;
}

/* The group now covers these points of splat i too. */
static double cover_more(struct growing *g, size_t i, uint32_t points)
{
    const struct cover *c = g->cover;
    double area = (double)c->splats->radius[i] * c->splats->radius[i] / COVER_POINTS, sum = 0;
    for (uint32_t added = points & ~g->have[i]; added; added &= added - 1)
        sum += area / c->depth[i][__builtin_ctz(added)];
    g->have[i] |= points;
    return sum;
}

static void join(struct growing *g, size_t i)
{
    struct overlap_row row = overlap_row(&g->cover->graph, i);
    g->missing -= cover_more(g, i, UINT32_MAX);
    for (size_t e = 0; e < row.degree; e++)
        g->missing -=
            cover_more(g, row.neighbour[e], cover_edge_back(g->cover, i, row.neighbour[e]));
}

static void start(struct growing *g, double target)
{
    const struct cover *c = g->cover;
    for (size_t i = 0; i < c->splats->count; i++) {
        double area = (double)c->splats->radius[i] * c->splats->radius[i] / COVER_POINTS;
        for (unsigned k = 0; !c->skip[i] && k < COVER_POINTS; k++)
            g->missing += target * area / c->depth[i][k];
    }
    for (size_t i = 0; i < c->splats->count; i++)
        if (!c->skip[i] && (c->member[i] & g->bit))
            join(g, i);
    for (size_t i = 0; i < c->splats->count; i++)
        if (!c->skip[i] && !(c->member[i] & g->bit))
            g->heap[g->size++] = (struct candidate){ new_area(g, i), (uint32_t)i };
    for (size_t at = g->size / 2; at-- > 0;)
        sift_down(g, at);
}

/* `joined` collects the members' bits apart, since groups grow side by side. */
static void grow(struct growing *g, uint8_t *joined)
{
    while (g->size && g->room && g->missing > 0 && g->heap[0].area > 0) {
        struct candidate best = g->heap[0];
        float area = new_area(g, best.id);
        if (area == best.area) {
            joined[best.id] = 1;
            join(g, best.id);
            g->room--;
            area = 0;
        }
        if (area > 0)
            g->heap[0].area = area;
        else
            g->heap[0] = g->heap[--g->size];
        if (g->size)
            sift_down(g, 0);
    }
}

struct duplicating {
    struct cover *cover;
    double target;
    size_t room;     /* a group */
    uint8_t *joined; /* a byte a splat and group */
    atomic_bool no_memory;
};

static void duplicate_groups(void *context, size_t begin, size_t end, unsigned)
{
    struct duplicating *d = context;
    size_t n = d->cover->splats->count;
    for (size_t k = begin; k < end; k++) {
        struct growing g = { .cover = d->cover, .bit = (uint64_t)1 << k, .room = d->room };
        g.have = mem_zalloc(n, sizeof *g.have);
        g.heap = mem_alloc(n, sizeof *g.heap);
        if (g.have && g.heap) {
            start(&g, d->target);
            grow(&g, d->joined + k * n);
        } else {
            atomic_store(&d->no_memory, true);
        }
        mem_free(g.have);
        mem_free(g.heap);
    }
}

enum stp_result cover_duplicate(struct cover *cover, double target, size_t room)
{
    size_t n = cover->splats->count;
    struct duplicating d = { .cover = cover, .target = target, .room = room };
    d.joined = mem_zalloc(n, cover->groups);
    if (d.joined)
        parallel_for(cover->env, cover->groups, 1, duplicate_groups, &d);
    bool ok = d.joined && !atomic_load(&d.no_memory);
    for (unsigned k = 0; ok && k < cover->groups; k++)
        for (size_t i = 0; i < n; i++)
            cover->member[i] |= (uint64_t)d.joined[k * n + i] << k;
    mem_free(d.joined);
    return ok ? STP_OK : log_no_memory(cover->env, n * (cover->groups + 12), "duplicates");
}

/* Sum of r^2 over each group, in units where a disc's area is r^2. */
static void group_areas(const struct cover *c, double *area)
{
    for (size_t i = 0; i < c->splats->count; i++)
        for (uint64_t in = c->member[i]; in; in &= in - 1)
            area[__builtin_ctzll(in)] += (double)c->splats->radius[i] * c->splats->radius[i];
}

static double surface_area(const struct cover *c)
{
    double area = 0;
    for (size_t i = 0; i < c->splats->count; i++) {
        double part = (double)c->splats->radius[i] * c->splats->radius[i] / COVER_POINTS;
        for (unsigned k = 0; !c->skip[i] && k < COVER_POINTS; k++)
            area += part / c->depth[i][k];
    }
    return area;
}

/* One group on its way: x is its factor squared. */
struct enlarging {
    double x, share;           /* before the last step */
    double area, missing_area; /* of its discs at factor 1; of the surface, short of the target */
};

/* ZP Eq. 9 adds the missing area to the discs' as if none of it overlapped; after the first step
 * what a step has gained is known, and the next goes as far as that promises. The gain falls as the
 * radii grow, so neither reaches far beyond the target. */
static double next_factor(struct enlarging *e, double factor, double share, double most)
{
    double x = factor * factor, slope = e->area;
    if (x > e->x && share > e->share)
        slope = fmin(slope, (share - e->share) / (x - e->x));
    double step = e->missing_area / slope;
    e->x = x;
    e->share = share;
    return fmin(sqrt(x + fmin(step, LARGEST_STEP)), most);
}

/* False: none needs another step. */
static bool enlarge_groups(struct enlarging *state, unsigned groups, double target, double most,
                           const double *share, double *factor)
{
    bool moved = false;
    for (unsigned k = 0; k < groups; k++) {
        state[k].missing_area = target - share[k];
        if (!(state[k].missing_area > CLOSE_ENOUGH) || !(state[k].area > 0) || factor[k] >= most)
            continue;
        factor[k] = next_factor(&state[k], factor[k], share[k], most);
        moved = true;
    }
    return moved;
}

enum stp_result cover_enlarge(const struct cover *cover, double target, double most, double *factor)
{
    struct enlarging state[STP_MAX_GROUPS] = { 0 };
    double area[STP_MAX_GROUPS] = { 0 }, share[STP_MAX_GROUPS], surface = surface_area(cover);
    bool moved = surface > 0;
    group_areas(cover, area);
    for (unsigned k = 0; k < cover->groups; k++) {
        state[k] = (struct enlarging){ .x = 1, .area = area[k] / surface };
        factor[k] = 1;
    }
    for (unsigned step = 0; moved && step < RADIUS_STEPS; step++) {
        enum stp_result result = cover_measure(cover, factor, RADIUS_BUDGET, share, NULL);
        if (result != STP_OK)
            return result;
        moved = enlarge_groups(state, cover->groups, target, most, share, factor);
    }
    return STP_OK;
}
