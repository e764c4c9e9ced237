#include "prepare/phong_cover.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

#define PROBES      32  /* seeds that tell how many sites a patch holds */
#define REDUNDANCY  3.0 /* candidates that hold a site, on average, in the first round */
#define RELAXATIONS 2

struct cover {
    const struct stp_env *env;
    const struct fit_cloud *cloud;
    const struct fit_limits *limits;
    struct patch_set pool; /* candidates */
    uint32_t *holders;     /* a site: of the patches that count now, how many hold it */
    uint32_t *chosen;      /* of the pool, in the order of choice */
    size_t chosen_count;
    size_t walk, step; /* through all sites, evenly over the surface: they lie in Morton order */
};

void patch_set_release(struct patch_set *set)
{
    patches_release(set->patch, set->count);
    mem_free(set->patch);
    *set = (struct patch_set){ 0 };
}

static int by_site(const void *a, const void *b)
{
    uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
    return (p > q) - (p < q);
}

/* Sorts the seeds: patches that lie side by side are grown, and later looked at, one after the
 * other. */
static enum stp_result add_candidates(struct cover *c, uint32_t *seed, size_t count)
{
    struct patch_set *pool = &c->pool;
    if (pool->count + count > pool->capacity) {
        size_t capacity = 2 * (pool->count + count);
        struct patch *patch = mem_realloc(pool->patch, capacity, sizeof *patch);
        if (!patch)
            return log_no_memory(c->env, capacity * sizeof *patch, "patches");
        pool->patch = patch;
        pool->capacity = capacity;
    }
    qsort(seed, count, sizeof *seed, by_site);
    enum stp_result result =
        patches_grow(c->env, c->cloud, c->limits, seed, count, pool->patch + pool->count);
    if (result == STP_OK)
        pool->count += count;
    return result;
}

/* The golden section of the count, made prime to it: k * step visits every site once. */
static size_t coprime_step(size_t count)
{
    size_t step = (size_t)(0.6180339887498949 * (double)count) | 1;
    for (;; step++) {
        size_t a = count, b = step;
        while (b > 0) {
            size_t rest = a % b;
            a = b;
            b = rest;
        }
        if (a == 1)
            return step;
    }
}

/* The next `count` sites of the walk that no candidate holds. */
static size_t next_seeds(struct cover *c, size_t count, uint32_t *seed)
{
    size_t n = 0;
    for (size_t tried = 0; tried < c->cloud->count && n < count; tried++) {
        c->walk = (c->walk + c->step) % c->cloud->count;
        if (c->holders[c->walk] == 0)
            seed[n++] = (uint32_t)c->walk;
    }
    return n;
}

/* Counts the holders from candidate `from` on; returns how many sites had none. */
static size_t count_holders(struct cover *c, size_t from)
{
    size_t fresh = 0;
    for (size_t i = from; i < c->pool.count; i++)
        for (uint32_t k = 0; k < c->pool.patch[i].count; k++)
            fresh += c->holders[c->pool.patch[i].member[k]]++ == 0;
    return fresh;
}

/* Of the cover: one of several, perhaps. */
static void report(const struct cover *c, double fraction)
{
    const struct fit_limits *l = c->limits;
    log_progress(c->env, "fit", l->begun + (l->ended - l->begun) * fraction);
}

/* Until every site is held by some candidate. */
static enum stp_result find_candidates(struct cover *c)
{
    size_t left = c->cloud->count, wanted = PROBES;
    uint32_t *seed = mem_alloc(left, sizeof *seed);
    enum stp_result result =
        seed ? STP_OK : log_no_memory(c->env, left * sizeof *seed, "seeds of patches");
    while (left > 0 && result == STP_OK) {
        size_t from = c->pool.count, members = 0;
        size_t count = next_seeds(c, wanted < left ? wanted : left, seed);
        result = add_candidates(c, seed, count);
        if (result != STP_OK)
            break;
        size_t fresh = count_holders(c, from);
        left -= fresh;
        for (size_t i = from; i < c->pool.count; i++)
            members += c->pool.patch[i].count;
        report(c, 0.8 * (1 - (double)left / (double)c->cloud->count));
        double mean = from == 0 ? (double)members : REDUNDANCY * (double)fresh;
        wanted = (size_t)ceil(REDUNDANCY * (double)left * (double)count / mean);
    }
    mem_free(seed);
    return result;
}

/* Greedy selection: the candidate that holds most sites that none before it holds. */
struct heap_entry {
    uint32_t gain, patch; /* gain: an upper bound, exact when it was last looked at */
};

static bool is_before(struct heap_entry a, struct heap_entry b)
{
    return a.gain != b.gain ? a.gain > b.gain : a.patch < b.patch;
}

static void sift_down(struct heap_entry *heap, size_t count, size_t at)
{
    for (;;) {
        size_t child = 2 * at + 1;
        if (child >= count)
            return;
        if (child + 1 < count && is_before(heap[child + 1], heap[child]))
            child++;
        if (!is_before(heap[child], heap[at]))
            return;
        struct heap_entry keep = heap[at];
        heap[at] = heap[child];
        heap[child] = keep;
        at = child;
    }
}

static uint32_t gain_of(const struct cover *c, uint32_t patch)
{
    const struct patch *p = &c->pool.patch[patch];
    uint32_t gain = 0;
    for (uint32_t k = 0; k < p->count; k++)
        gain += c->holders[p->member[k]] == 0;
    return gain;
}

static void choose(struct cover *c, uint32_t patch)
{
    const struct patch *p = &c->pool.patch[patch];
    for (uint32_t k = 0; k < p->count; k++)
        c->holders[p->member[k]]++;
    c->chosen[c->chosen_count++] = patch;
}

/* Gains only shrink: a candidate whose gain is still what the heap says is the best of all. */
static enum stp_result select_greedily(struct cover *c)
{
    size_t count = c->pool.count;
    struct heap_entry *heap = mem_alloc(count, sizeof *heap);
    uint32_t *chosen = mem_realloc(c->chosen, count, sizeof *chosen);
    if (chosen)
        c->chosen = chosen;
    if (!heap || !chosen) {
        mem_free(heap);
        return log_no_memory(c->env, count * sizeof *heap, "the selection of patches");
    }
    memset(c->holders, 0, c->cloud->count * sizeof *c->holders);
    c->chosen_count = 0;
    for (size_t i = 0; i < count; i++)
        heap[i] = (struct heap_entry){ c->pool.patch[i].count, (uint32_t)i };
    for (size_t i = count / 2; i-- > 0;)
        sift_down(heap, count, i);
    while (count > 0 && heap[0].gain > 0) {
        uint32_t gain = gain_of(c, heap[0].patch);
        bool best = gain == heap[0].gain;
        if (best)
            choose(c, heap[0].patch);
        heap[0].gain = gain;
        if (best || gain == 0)
            heap[0] = heap[--count];
        sift_down(heap, count, 0);
    }
    mem_free(heap);
    return STP_OK;
}

/* Last chosen first: those whose sites are all held by others too go. */
static void drop_redundant(struct cover *c)
{
    size_t kept = c->chosen_count;
    for (size_t i = c->chosen_count; i-- > 0;) {
        const struct patch *p = &c->pool.patch[c->chosen[i]];
        bool needed = false;
        for (uint32_t k = 0; k < p->count && !needed; k++)
            needed = c->holders[p->member[k]] == 1;
        if (needed)
            continue;
        for (uint32_t k = 0; k < p->count; k++)
            c->holders[p->member[k]]--;
        c->chosen[i] = NO_SITE;
        kept--;
    }
    size_t at = 0;
    for (size_t i = 0; i < c->chosen_count; i++)
        if (c->chosen[i] != NO_SITE)
            c->chosen[at++] = c->chosen[i];
    c->chosen_count = kept;
}

/* The member nearest to the middle of those that no other chosen patch holds. */
static uint32_t middle_of_own(const struct cover *c, const struct patch *p)
{
    struct vec3 sum = v3(0, 0, 0);
    uint32_t own = 0, best = p->seed;
    double least = INFINITY;
    for (uint32_t k = 0; k < p->count; k++)
        if (c->holders[p->member[k]] == 1) {
            sum = v3_add(sum, v3_load(c->cloud->site[p->member[k]].p));
            own++;
        }
    sum = v3_scale(sum, own > 0 ? 1.0 / own : 0);
    for (uint32_t k = 0; k < p->count && own > 0; k++) {
        struct vec3 d = v3_sub(v3_load(c->cloud->site[p->member[k]].p), sum);
        if (v3_dot(d, d) < least || (v3_dot(d, d) == least && p->member[k] < best)) {
            least = v3_dot(d, d);
            best = p->member[k];
        }
    }
    return best;
}

/* The pool shrinks to the chosen. */
static void forget_others(struct cover *c)
{
    size_t count = c->pool.count;
    for (size_t i = 0; i < c->chosen_count; i++) { /* mark by count: bit 31 is never a count's */
        c->pool.patch[c->chosen[i]].count |= 0x80000000u;
        c->chosen[i] = (uint32_t)i;
    }
    size_t at = 0;
    for (size_t i = 0; i < count; i++) {
        struct patch p = c->pool.patch[i];
        if (p.count & 0x80000000u) {
            p.count &= 0x7fffffffu;
            c->pool.patch[at++] = p;
        } else {
            mem_free(p.member);
        }
    }
    c->pool.count = at;
}

/* Patches grown anew from the middles of what only they hold stand beside the chosen, and the
 * selection runs again. */
static enum stp_result relax(struct cover *c)
{
    size_t count = c->chosen_count, seeds = 0;
    uint32_t *seed = mem_alloc(count, sizeof *seed);
    if (!seed)
        return log_no_memory(c->env, count * sizeof *seed, "the relaxation of patches");
    for (size_t i = 0; i < count; i++) {
        const struct patch *p = &c->pool.patch[c->chosen[i]];
        uint32_t middle = middle_of_own(c, p);
        if (middle != p->seed)
            seed[seeds++] = middle;
    }
    enum stp_result result = add_candidates(c, seed, seeds);
    mem_free(seed);
    if (result == STP_OK)
        result = select_greedily(c);
    if (result == STP_OK)
        drop_redundant(c);
    return result;
}

enum stp_result patches_cover(const struct stp_env *env, const struct fit_cloud *cloud,
                              const struct fit_limits *limits, struct patch_set *set)
{
    struct cover c = { .env = env, .cloud = cloud, .limits = limits };
    c.step = coprime_step(cloud->count);
    c.holders = mem_zalloc(cloud->count, sizeof *c.holders);
    enum stp_result result =
        c.holders ? find_candidates(&c)
                  : log_no_memory(env, cloud->count * sizeof *c.holders, "the cover of sites");
    if (result == STP_OK)
        result = select_greedily(&c);
    if (result == STP_OK)
        drop_redundant(&c);
    for (int i = 0; i < RELAXATIONS && result == STP_OK; i++) {
        result = relax(&c);
        report(&c, 0.8 + 0.2 * (i + 1) / RELAXATIONS);
    }
    if (result == STP_OK)
        forget_others(&c);
    mem_free(c.holders);
    mem_free(c.chosen);
    if (result != STP_OK)
        patch_set_release(&c.pool);
    else
        *set = c.pool;
    return result;
}
