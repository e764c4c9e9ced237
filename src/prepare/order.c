#include "prepare/order.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/bounds.h"
#include "prepare/radix.h"
#include "scene/phong.h"

#define GRAIN     16384
#define SHORT_RUN 32 /* sorted by comparison */
#define WORDS     8  /* and as many of a Phong splat's */

/* Attribute bits of a splat, most significant word first. */
static uint64_t word_of(const struct splats *s, size_t i, unsigned word)
{
    uint32_t half[2] = { 0, 0 };
    uint64_t whole = 0;
    switch (word) {
    case 0:
    case 1:
    case 2:
        memcpy(&whole, &s->position[i][word], sizeof whole);
        return whole;
    case 3:
        if (s->normal)
            memcpy(half, s->normal[i], sizeof half);
        break;
    case 4:
        if (s->normal)
            memcpy(&half[0], &s->normal[i][2], 4);
        if (s->radius)
            memcpy(&half[1], &s->radius[i], 4);
        break;
    case 5:
        if (s->color)
            memcpy(half, s->color[i], sizeof half);
        break;
    case 6:
        if (s->color)
            memcpy(&half[0], &s->color[i][2], 4);
        if (s->opacity)
            memcpy(&half[1], &s->opacity[i], 4);
        break;
    case 7:
        half[1] = s->object ? s->object[i] : 0;
        break;
    default:
        phong_word(&s->phong[i], word - WORDS, half);
    }
    return (uint64_t)half[0] << 32 | half[1];
}

static unsigned words_of(const struct splats *s)
{
    return s->phong ? WORDS + PHONG_WORDS : WORDS;
}

/* Of attributes alone: <0, 0, >0. */
static int compare_attributes(const struct splats *s, size_t a, size_t b)
{
    for (unsigned word = 0; word < words_of(s); word++) {
        uint64_t x = word_of(s, a, word), y = word_of(s, b, word);
        if (x != y)
            return x < y ? -1 : 1;
    }
    return 0;
}

static bool before(const struct splats *s, uint32_t a, uint32_t b)
{
    int order = compare_attributes(s, a, b);
    if (order != 0)
        return order < 0;
    return s->input ? s->input[a] < s->input[b] : a < b;
}

static void insertion_sort(const struct splats *s, uint32_t *order, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        uint32_t moving = order[i];
        size_t at = i;
        for (; at > 0 && before(s, moving, order[at - 1]); at--)
            order[at] = order[at - 1];
        order[at] = moving;
    }
}

struct keys {
    const struct splats *splats;
    const uint32_t *order;
    uint64_t *key;
    double low[3], scale;
    unsigned word;
};

/* 21 bits to every third of 63. */
static uint64_t spread(uint64_t x)
{
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

static uint64_t morton_code(const double p[3], const double low[3], double scale)
{
    uint64_t code = 0;
    for (int axis = 0; axis < 3; axis++) {
        double cell = (p[axis] - low[axis]) * scale;
        uint64_t bits = cell < 2097151.0 ? (uint64_t)cell : 2097151u;
        code |= spread(bits) << (2 - axis);
    }
    return code;
}

static bool has_cells(double extent)
{
    return !(2097152.0 / extent > DBL_MAX || extent < DBL_MIN);
}

uint64_t order_code(const double p[3], const struct bounds *box)
{
    double extent = bounds_extent(box);
    return has_cells(extent) ? morton_code(p, box->low, 2097152.0 / extent) : 0;
}

static void morton_keys(void *context, size_t begin, size_t end, unsigned)
{
    const struct keys *k = context;
    for (size_t i = begin; i < end; i++)
        k->key[i] = morton_code(k->splats->position[k->order[i]], k->low, k->scale);
}

static void word_keys(void *context, size_t begin, size_t end, unsigned)
{
    const struct keys *k = context;
    const unsigned words = words_of(k->splats);
    for (size_t i = begin; i < end; i++)
        k->key[i] = k->word == words
                        ? (k->splats->input ? k->splats->input[k->order[i]] : k->order[i])
                        : word_of(k->splats, k->order[i], k->word);
}

/* Coincident splats: least significant word first. */
static enum stp_result sort_by_words(const struct stp_env *env, struct keys *k, uint32_t *order,
                                     size_t count)
{
    enum stp_result result = STP_OK;
    for (unsigned word = words_of(k->splats) + 1; word-- > 0 && result == STP_OK;) {
        k->word = word;
        parallel_for(env, count, GRAIN, word_keys, k);
        result = radix_sort(env, count, k->key, order);
    }
    return result;
}

static enum stp_result sort_range(const struct stp_env *env, const struct splats *s,
                                  uint32_t *order, size_t count, const struct bounds *within);

/* Splats of one cell are sorted among themselves. */
static enum stp_result sort_runs(const struct stp_env *env, const struct splats *s,
                                 const uint64_t *key, uint32_t *order, size_t count)
{
    enum stp_result result = STP_OK;
    for (size_t begin = 0, end; begin < count && result == STP_OK; begin = end) {
        for (end = begin + 1; end < count && key[end] == key[begin]; end++)
            ;
        if (end - begin <= SHORT_RUN)
            insertion_sort(s, order + begin, end - begin);
        else
            result = sort_range(env, s, order + begin, end - begin, NULL);
    }
    return result;
}

/* within: NULL, or the box whose cells count instead of those of their own bounds. */
static enum stp_result sort_range(const struct stp_env *env, const struct splats *s,
                                  uint32_t *order, size_t count, const struct bounds *within)
{
    struct bounds box;
    enum stp_result result = STP_OK;
    if (within)
        box = *within;
    else
        result = bounds_of(env, s->position, order, count, &box);
    if (result != STP_OK)
        return result;
    double extent = bounds_extent(&box);
    struct keys k = { s,
                      order,
                      mem_alloc(count, sizeof *k.key),
                      { box.low[0], box.low[1], box.low[2] },
                      2097152.0 / extent,
                      0 };
    if (!k.key)
        return log_no_memory(env, count * sizeof *k.key, "the sorting keys");
    if (!has_cells(extent)) {
        result = sort_by_words(env, &k, order, count);
    } else {
        parallel_for(env, count, GRAIN, morton_keys, &k);
        result = radix_sort(env, count, k.key, order);
        if (result == STP_OK)
            result = sort_runs(env, s, k.key, order, count);
    }
    mem_free(k.key);
    return result;
}

struct gather {
    const uint32_t *order;
    const char *from;
    char *to;
    size_t size;
};

static void gather_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct gather *g = context;
    switch (g->size) {
    case 4:
        for (size_t i = begin; i < end; i++)
            memcpy(g->to + 4 * i, g->from + 4 * (size_t)g->order[i], 4);
        break;
    case 12:
        for (size_t i = begin; i < end; i++)
            memcpy(g->to + 12 * i, g->from + 12 * (size_t)g->order[i], 12);
        break;
    case 24:
        for (size_t i = begin; i < end; i++)
            memcpy(g->to + 24 * i, g->from + 24 * (size_t)g->order[i], 24);
        break;
    default:
        for (size_t i = begin; i < end; i++)
            memcpy(g->to + g->size * i, g->from + g->size * g->order[i], g->size);
    }
}

/* One array at a time, so that only one is ever there twice. */
static bool permute(const struct stp_env *env, const uint32_t *order, size_t count, void **array,
                    size_t size)
{
    if (!*array)
        return true;
    struct gather g = { order, *array, mem_alloc(count, size), size };
    if (!g.to)
        return false;
    parallel_for(env, count, GRAIN, gather_range, &g);
    mem_free(*array);
    *array = g.to;
    return true;
}

static bool permute_all(const struct stp_env *env, struct splats *s, uint32_t **order)
{
    size_t n = s->count;
    if (!permute(env, *order, n, (void **)&s->position, sizeof *s->position) ||
        !permute(env, *order, n, (void **)&s->normal, sizeof *s->normal) ||
        !permute(env, *order, n, (void **)&s->radius, sizeof *s->radius) ||
        !permute(env, *order, n, (void **)&s->color, sizeof *s->color) ||
        !permute(env, *order, n, (void **)&s->opacity, sizeof *s->opacity) ||
        !permute(env, *order, n, (void **)&s->phong, sizeof *s->phong) ||
        !permute(env, *order, n, (void **)&s->object, sizeof *s->object) ||
        !permute(env, *order, n, (void **)&s->input, sizeof *s->input))
        return false;
    if (!s->input) {
        s->input = *order;
        *order = NULL;
    }
    return true;
}

static size_t count_duplicates(const struct splats *s)
{
    size_t duplicates = 0;
    for (size_t i = 1; i < s->count; i++)
        duplicates += compare_attributes(s, i - 1, i) == 0;
    return duplicates;
}

enum stp_result order_splats(const struct stp_env *env, struct splats *s, size_t *duplicates)
{
    return order_splats_within(env, s, NULL, duplicates);
}

enum stp_result order_splats_within(const struct stp_env *env, struct splats *s,
                                    const struct bounds *within, size_t *duplicates)
{
    uint32_t *order = mem_alloc(s->count, sizeof *order);
    if (!order)
        return log_no_memory(env, s->count * sizeof *order, "the order of the splats");
    for (size_t i = 0; i < s->count; i++)
        order[i] = (uint32_t)i;
    enum stp_result result = STP_OK;
    if (s->count > 0)
        result = sort_range(env, s, order, s->count, within);
    if (result == STP_OK && !permute_all(env, s, &order))
        result = log_no_memory(env, s->count * sizeof *s->position, "the splats in order");
    mem_free(order);
    if (result == STP_OK && duplicates)
        *duplicates = count_duplicates(s);
    return result;
}
