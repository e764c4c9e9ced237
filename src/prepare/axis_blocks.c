#include "prepare/axis_blocks.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/axis_region.h"

#define RUNS                                                                                       \
    16 /* of a walk's list, counted and filled apart; a block's entries are theirs in turn */

struct blocking {
    const struct axis_lists *lists;
    const struct axis_walk *walk;
    struct axis_view view;
    struct axis_region region;
    bool everywhere; /* the walk serves every pixel */
    struct axis_blocks *blocks;
    uint8_t *open;  /* of each block: the walk has a weight in it */
    size_t *cursor; /* RUNS x blocks: counts, then where to write next */
    bool fill;
};

static void enter(const struct blocking *b, size_t run, uint32_t place)
{
    struct axis_blocks *blocks = b->blocks;
    size_t *cursor = b->cursor + run * blocks->across * blocks->down;
    struct axis_rectangle r;
    struct axis_kernel kernel;
    axis_kernel(&b->view, b->lists->order[place], &kernel);
    if (!axis_pixels(kernel.view, kernel.centre, &r))
        return;
    for (int64_t y = r.y0 / AXIS_BLOCK; y <= r.y1 / AXIS_BLOCK; y++)
        for (int64_t x = r.x0 / AXIS_BLOCK; x <= r.x1 / AXIS_BLOCK; x++) {
            size_t block = (size_t)y * blocks->across + (size_t)x;
            if (!b->open[block])
                continue;
            if (b->fill)
                blocks->entry[cursor[block]] = place;
            cursor[block]++;
        }
}

static void enter_runs(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct blocking *b = context;
    size_t length = (b->walk->count + RUNS - 1) / RUNS;
    for (size_t run = begin; run < end; run++)
        for (size_t i = run * length; i < (run + 1) * length && i < b->walk->count; i++)
            enter(b, run, b->walk->first + (uint32_t)i);
}

static void open_blocks(struct blocking *b)
{
    const struct axis_blocks *blocks = b->blocks;
    for (size_t i = 0; i < (size_t)blocks->across * blocks->down; i++) {
        int64_t x = (int64_t)(i % blocks->across) * AXIS_BLOCK;
        int64_t y = (int64_t)(i / blocks->across) * AXIS_BLOCK;
        const struct axis_rectangle r = { x, x + AXIS_BLOCK - 1, y, y + AXIS_BLOCK - 1 };
        b->open[i] = b->everywhere || axis_region_reaches(&b->region, &r);
    }
}

/* Counts to places, block by block and run by run within a block. */
static void place_runs(struct blocking *b, size_t walk)
{
    struct axis_blocks *blocks = b->blocks;
    size_t count = (size_t)blocks->across * blocks->down;
    for (size_t i = 0; i < count; i++) {
        size_t before = blocks->count;
        blocks->first[walk * count + i] = (uint32_t)before;
        for (size_t run = 0; run < RUNS; run++) {
            size_t *cursor = &b->cursor[run * count + i], own = *cursor;
            *cursor = blocks->count;
            blocks->count += own;
        }
        if (blocks->count - before > blocks->longest)
            blocks->longest = (uint32_t)(blocks->count - before);
    }
    blocks->first[(walk + 1) * count] = (uint32_t)blocks->count;
}

static enum stp_result build_walk(const struct stp_env *env, struct blocking *b, size_t walk)
{
    struct axis_blocks *blocks = b->blocks;
    size_t cursors = RUNS * (size_t)blocks->across * blocks->down;
    b->fill = false;
    for (size_t i = 0; i < cursors; i++)
        b->cursor[i] = 0;
    open_blocks(b);
    parallel_for(env, RUNS, 1, enter_runs, b);
    place_runs(b, walk);
    if (blocks->count > UINT32_MAX)
        return log_error(env, STP_ERROR_MEMORY, "%zu splats in the blocks' lists: at most 2^32 - 1",
                         blocks->count);
    uint32_t *grown = mem_realloc(blocks->entry, blocks->count, sizeof *grown);
    if (!grown)
        return log_no_memory(env, blocks->count * sizeof *grown, "the blocks' lists");
    blocks->entry = grown;
    b->fill = true;
    parallel_for(env, RUNS, 1, enter_runs, b);
    return STP_OK;
}

static enum stp_result build(const struct stp_env *env, struct blocking *b)
{
    struct axis_blocks *blocks = b->blocks;
    size_t count = (size_t)blocks->across * blocks->down;
    blocks->first = mem_zalloc(b->lists->walk_count * count + 1, sizeof *blocks->first);
    b->cursor = mem_alloc(RUNS * count, sizeof *b->cursor);
    b->open = mem_alloc(count, 1);
    if (!blocks->first || !b->cursor || !b->open)
        return log_no_memory(env, RUNS * count * sizeof *b->cursor, "the blocks' lists");
    struct axis_rays rays = axis_rays(b->view.camera);
    enum stp_result result = STP_OK;
    for (size_t walk = 0; result == STP_OK && walk < b->lists->walk_count; walk++) {
        b->walk = &b->lists->walk[walk];
        b->region = axis_region(&rays, b->lists, b->walk);
        result = build_walk(env, b, walk);
    }
    return result;
}

enum stp_result axis_blocks_build(const struct stp_env *env, const struct stp_scene *scene,
                                  const struct stp_camera *camera, const struct axis_lists *lists,
                                  struct axis_blocks *blocks)
{
    struct axis_blocks made = { .across = (camera->width + AXIS_BLOCK - 1) / AXIS_BLOCK,
                                .down = (camera->height + AXIS_BLOCK - 1) / AXIS_BLOCK };
    struct blocking b = { .lists = lists,
                          .view = axis_view(scene, camera),
                          .everywhere =
                              lists->merge == STP_AXIS_SINGLE || lists->merge == STP_AXIS_SORT,
                          .blocks = &made };
    enum stp_result result = build(env, &b);
    mem_free(b.cursor);
    mem_free(b.open);
    if (result == STP_OK)
        *blocks = made;
    else
        axis_blocks_release(&made);
    return result;
}

void axis_blocks_release(struct axis_blocks *blocks)
{
    mem_free(blocks->first);
    mem_free(blocks->entry);
    *blocks = (struct axis_blocks){ 0 };
}
