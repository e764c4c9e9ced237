#include "prepare/axis_blocks.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

/* Of a walk's list, counted and filled apart; a block's entries are theirs in turn. */
#define RUNS  8
#define AHEAD 16 /* kernels that are fetched before their turn */

struct blocking {
    const struct axis_lists *lists;
    const struct axis_blocks *blocks; /* cursor: walks x RUNS x blocks */
    uint32_t *entry;                  /* NULL: they are counted */
};

/* entry NULL: counts only. Kernels lie apart in memory where sheets are across x or y. */
static inline void enter_run(const struct axis_lists *lists, unsigned bit, size_t from, size_t to,
                             uint32_t *restrict cursor, uint32_t *restrict entry)
{
    for (size_t i = from; i < to; i++) {
        uint32_t kernel = lists->order[i];
        if (i + AHEAD < to)
            __builtin_prefetch(&lists->span[lists->order[i + AHEAD]]);
        struct axis_span r = lists->span[kernel];
        for (unsigned y = r.y0 / AXIS_BLOCK_HEIGHT; y <= r.y1 / AXIS_BLOCK_HEIGHT; y++)
            for (unsigned x = r.x0 / AXIS_BLOCK_WIDTH; x <= r.x1 / AXIS_BLOCK_WIDTH; x++) {
                size_t block = (size_t)y * lists->blocks_x + x;
                if (!(lists->open[block] >> bit & 1))
                    continue;
                uint32_t at = cursor[block]++;
                if (entry)
                    entry[at] = kernel;
            }
    }
}

static void enter_runs(void *context, size_t begin, size_t end, unsigned)
{
    const struct blocking *b = context;
    size_t blocks = (size_t)b->blocks->across * b->blocks->down;
    for (size_t n = begin; n < end; n++) {
        const struct axis_walk *walk = &b->lists->walk[n / RUNS];
        size_t length = (walk->count + RUNS - 1) / RUNS, run = n % RUNS;
        size_t from = run * length < walk->count ? run * length : walk->count;
        size_t to = from + length < walk->count ? from + length : walk->count;
        uint32_t *cursor = b->blocks->cursor + n * blocks;
        unsigned bit = axis_walk_bit(walk);
        if (b->entry)
            enter_run(b->lists, bit, walk->first + from, walk->first + to, cursor, b->entry);
        else
            enter_run(b->lists, bit, walk->first + from, walk->first + to, cursor, NULL);
    }
}

/* Counts to places, block by block and run by run within a block. */
static void place_runs(struct axis_blocks *blocks, size_t walks)
{
    size_t count = (size_t)blocks->across * blocks->down;
    blocks->count = blocks->longest = blocks->fullest = 0;
    for (size_t n = 0; n < walks * count; n++) {
        size_t before = blocks->count;
        blocks->first[n] = (uint32_t)before;
        for (size_t run = 0; run < RUNS; run++) {
            uint32_t *cursor = &blocks->cursor[(n / count * RUNS + run) * count + n % count];
            uint32_t own = *cursor;
            *cursor = (uint32_t)blocks->count;
            blocks->count += own;
        }
        if (blocks->count - before > blocks->longest)
            blocks->longest = blocks->count - before;
    }
    blocks->first[walks * count] = (uint32_t)blocks->count;
}

static void find_fullest(struct axis_blocks *blocks, size_t walks)
{
    size_t count = (size_t)blocks->across * blocks->down;
    for (size_t block = 0; block < count; block++) {
        size_t sum = 0;
        for (size_t w = 0; w < walks; w++)
            sum += blocks->first[w * count + block + 1] - blocks->first[w * count + block];
        if (sum > blocks->fullest)
            blocks->fullest = sum;
    }
}

static enum stp_result make_room(const struct stp_env *env, uint32_t **array, size_t *room,
                                 size_t count)
{
    if (count <= *room)
        return STP_OK;
    mem_free(*array);
    *array = mem_alloc(count, sizeof **array);
    *room = *array ? count : 0;
    return *array ? STP_OK : log_no_memory(env, count * sizeof **array, "the blocks' lists");
}

static enum stp_result count_blocks(const struct stp_env *env, const struct axis_lists *lists,
                                    struct axis_blocks *blocks)
{
    size_t walks = lists->walk_count, count = walks * (size_t)lists->blocks_x * lists->blocks_y;
    struct blocking b = { lists, blocks, NULL };
    blocks->across = lists->blocks_x;
    blocks->down = lists->blocks_y;
    enum stp_result result = make_room(env, &blocks->first, &blocks->lists, count + 1);
    if (result == STP_OK)
        result = make_room(env, &blocks->cursor, &blocks->cursors, RUNS * count + 1);
    if (result != STP_OK)
        return result;
    memset(blocks->cursor, 0, RUNS * count * sizeof *blocks->cursor);
    parallel_for(env, walks * RUNS, 1, enter_runs, &b);
    place_runs(blocks, walks);
    find_fullest(blocks, walks);
    if (blocks->count > UINT32_MAX)
        return log_error(env, STP_ERROR_MEMORY, "%zu splats in the blocks' lists: at most 2^32 - 1",
                         blocks->count);
    return STP_OK;
}

enum stp_result axis_blocks_count(const struct stp_env *env, const struct axis_lists *lists,
                                  struct axis_blocks *blocks)
{
    enum stp_result result = count_blocks(env, lists, blocks);
    if (result != STP_OK)
        axis_blocks_release(blocks);
    return result;
}

void axis_blocks_fill(const struct stp_env *env, const struct axis_lists *lists,
                      struct axis_blocks *blocks, uint32_t *entry)
{
    struct blocking b = { lists, blocks, entry };
    if (blocks->count > 0)
        parallel_for(env, lists->walk_count * RUNS, 1, enter_runs, &b);
}

enum stp_result axis_blocks_update(const struct stp_env *env, const struct axis_lists *lists,
                                   struct axis_blocks *blocks)
{
    enum stp_result result = count_blocks(env, lists, blocks);
    if (result == STP_OK)
        result = make_room(env, &blocks->entry, &blocks->room, blocks->count);
    if (result == STP_OK)
        axis_blocks_fill(env, lists, blocks, blocks->entry);
    else
        axis_blocks_release(blocks);
    return result;
}

void axis_blocks_release(struct axis_blocks *blocks)
{
    mem_free(blocks->first);
    mem_free(blocks->entry);
    mem_free(blocks->cursor);
    *blocks = (struct axis_blocks){ 0 };
}
