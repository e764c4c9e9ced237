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
    const struct axis_blocks *blocks; /* cursor: walks x RUNS tables of cells */
    uint32_t *entry;                  /* NULL: they are counted */
};

/* A run's table has a column and a row beyond its blocks. */
static size_t cells_of(uint32_t across, uint32_t down)
{
    return ((size_t)across + 1) * (down + 1);
}

struct run {
    const struct axis_lists *lists;
    unsigned bit; /* its walk's */
    size_t from, to;
    struct axis_span *span; /* as of axis_blocks: counting leaves it to filling */
    uint32_t *cells;
};

/* Of kernel i of the lists. Kernels lie apart in memory where sheets are across x or y. */
static inline struct axis_span span_at(const struct run *run, size_t i)
{
    const struct axis_lists *lists = run->lists;
    if (i + AHEAD < run->to)
        __builtin_prefetch(&lists->span[lists->order[i + AHEAD]]);
    struct axis_span r = lists->span[lists->order[i]];
    r.x0 /= AXIS_BLOCK_WIDTH;
    r.x1 /= AXIS_BLOCK_WIDTH;
    r.y0 /= AXIS_BLOCK_HEIGHT;
    r.y1 /= AXIS_BLOCK_HEIGHT;
    return r;
}

/* Counts from their differences across x and y: four of them a kernel, however many its blocks. */
static void count_run(const struct run *run)
{
    const struct axis_lists *lists = run->lists;
    const size_t stride = (size_t)lists->blocks_x + 1;
    uint32_t *cell = run->cells, *column = cell + stride * lists->blocks_y;
    memset(cell, 0, cells_of(lists->blocks_x, lists->blocks_y) * sizeof *cell);
    for (size_t i = run->from; i < run->to; i++) {
        struct axis_span r = run->span[i] = span_at(run, i);
        uint32_t *top = cell + r.y0 * stride, *below = cell + (r.y1 + (size_t)1) * stride;
        top[r.x0]++;
        top[r.x1 + 1]--;
        below[r.x0]--;
        below[r.x1 + 1]++;
    }
    memset(column, 0, stride * sizeof *column); /* of no block: takes the sums down to a row */
    for (uint32_t y = 0; y < lists->blocks_y; y++) {
        const uint8_t *open = lists->open + (size_t)y * lists->blocks_x;
        uint32_t *row = cell + y * stride, across = 0;
        for (uint32_t x = 0; x < lists->blocks_x; x++) {
            across += row[x];
            column[x] += across;
            row[x] = open[x] >> run->bit & 1 ? column[x] : 0;
        }
    }
}

static void fill_run(const struct run *run, uint32_t *restrict entry)
{
    const struct axis_lists *lists = run->lists;
    const size_t stride = (size_t)lists->blocks_x + 1;
    for (size_t i = run->from; i < run->to; i++) {
        struct axis_span r = run->span[i];
        uint32_t kernel = lists->order[i];
        for (uint32_t y = r.y0; y <= r.y1; y++) {
            const uint8_t *open = lists->open + (size_t)y * lists->blocks_x;
            uint32_t *row = run->cells + y * stride;
            for (uint32_t x = r.x0; x <= r.x1; x++)
                if (open[x] >> run->bit & 1)
                    entry[row[x]++] = kernel;
        }
    }
}

static void enter_runs(void *context, size_t begin, size_t end, unsigned)
{
    const struct blocking *b = context;
    for (size_t n = begin; n < end; n++) {
        const struct axis_walk *walk = &b->lists->walk[n / RUNS];
        size_t length = (walk->count + RUNS - 1) / RUNS, run = n % RUNS;
        size_t from = run * length < walk->count ? run * length : walk->count;
        size_t to = from + length < walk->count ? from + length : walk->count;
        const struct run r = {
            b->lists,           axis_walk_bit(walk),
            walk->first + from, walk->first + to,
            b->blocks->span,    b->blocks->cursor + n * cells_of(b->blocks->across, b->blocks->down)
        };
        if (b->entry)
            fill_run(&r, b->entry);
        else
            count_run(&r);
    }
}

/* Counts to places, block by block and run by run within a block. */
static void place_runs(struct axis_blocks *blocks, size_t walks)
{
    size_t count = (size_t)blocks->across * blocks->down;
    size_t cells = cells_of(blocks->across, blocks->down);
    blocks->count = blocks->longest = blocks->fullest = 0;
    for (size_t n = 0; n < walks * count; n++) {
        size_t before = blocks->count, block = n % count;
        size_t cell = block + block / blocks->across; /* a row of cells is one longer */
        blocks->first[n] = (uint32_t)before;
        for (size_t run = 0; run < RUNS; run++) {
            uint32_t *cursor = &blocks->cursor[(n / count * RUNS + run) * cells + cell];
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

static enum stp_result make_span_room(const struct stp_env *env, struct axis_blocks *blocks,
                                      size_t count)
{
    if (count <= blocks->spans)
        return STP_OK;
    mem_free(blocks->span);
    blocks->span = mem_alloc(count, sizeof *blocks->span);
    blocks->spans = blocks->span ? count : 0;
    return blocks->span ? STP_OK
                        : log_no_memory(env, count * sizeof *blocks->span, "the blocks' lists");
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
        result = make_span_room(env, blocks, lists->count);
    if (result == STP_OK)
        result = make_room(env, &blocks->cursor, &blocks->cursors,
                           walks * RUNS * cells_of(blocks->across, blocks->down));
    if (result != STP_OK)
        return result;
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

void axis_blocks_trim(struct axis_blocks *blocks)
{
    mem_free(blocks->cursor);
    mem_free(blocks->span);
    blocks->cursor = NULL;
    blocks->span = NULL;
    blocks->cursors = blocks->spans = 0;
}

void axis_blocks_release(struct axis_blocks *blocks)
{
    mem_free(blocks->first);
    mem_free(blocks->entry);
    mem_free(blocks->cursor);
    mem_free(blocks->span);
    *blocks = (struct axis_blocks){ 0 };
}
