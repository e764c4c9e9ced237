#include "reference/bins.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

/* Blocks of consecutive splats count and fill apart; a tile's list is theirs in order. */
#define BLOCKS 16

struct binning {
    const struct view *view;
    struct bins *bins;
    size_t *cursor; /* BLOCKS x tiles: counts, then where to write next */
    bool fill;
};

bool cells_touched(double min, double max, double cell, uint32_t begin, uint32_t end,
                   uint32_t *first, uint32_t *last)
{
    double lo = fmax(floor(min / cell), begin), hi = fmin(floor(max / cell), (double)end - 1);
    if (!(lo <= hi))
        return false;
    *first = (uint32_t)lo;
    *last = (uint32_t)hi;
    return true;
}

static void bin_splat(const struct binning *binning, size_t block, uint32_t id)
{
    struct bins *bins = binning->bins;
    size_t *cursor = binning->cursor + block * bins->across * bins->down;
    struct disc disc;
    uint32_t x0, x1, y0, y1;
    if (!disc_setup(binning->view, id, &disc) ||
        !cells_touched(disc.x_min, disc.x_max, TILE, 0, bins->across, &x0, &x1) ||
        !cells_touched(disc.y_min, disc.y_max, TILE, 0, bins->down, &y0, &y1))
        return;
    for (uint32_t y = y0; y <= y1; y++)
        for (uint32_t x = x0; x <= x1; x++) {
            size_t *next = &cursor[(size_t)y * bins->across + x];
            if (binning->fill)
                bins->splat[*next] = id;
            ++*next;
        }
}

static void bin_blocks(void *context, size_t begin, size_t end, unsigned)
{
    const struct binning *binning = context;
    size_t count = binning->view->scene->splats.count, length = (count + BLOCKS - 1) / BLOCKS;
    for (size_t block = begin; block < end; block++)
        for (size_t i = block * length; i < (block + 1) * length && i < count; i++)
            bin_splat(binning, block, (uint32_t)i);
}

/* Counts to places: tile by tile, and block by block within a tile. */
static void place(struct binning *binning)
{
    struct bins *bins = binning->bins;
    size_t tiles = (size_t)bins->across * bins->down, total = 0;
    for (size_t tile = 0; tile < tiles; tile++) {
        bins->first[tile] = total;
        for (size_t block = 0; block < BLOCKS; block++) {
            size_t *cursor = &binning->cursor[block * tiles + tile], count = *cursor;
            *cursor = total;
            total += count;
        }
    }
    bins->first[tiles] = total;
}

static enum stp_result build(const struct stp_env *env, struct binning *binning)
{
    struct bins *bins = binning->bins;
    size_t tiles = (size_t)bins->across * bins->down;
    bins->first = mem_alloc(tiles + 1, sizeof *bins->first);
    binning->cursor = mem_zalloc(BLOCKS * tiles, sizeof *binning->cursor);
    if (!bins->first || !binning->cursor)
        return log_no_memory(env, (BLOCKS + 1) * tiles * sizeof(size_t), "the tiles' lists");
    parallel_for(env, BLOCKS, 1, bin_blocks, binning);
    place(binning);
    bins->splat = mem_alloc(bins->first[tiles], sizeof *bins->splat);
    if (!bins->splat)
        return log_no_memory(env, bins->first[tiles] * sizeof *bins->splat, "the tiles' splats");
    binning->fill = true;
    parallel_for(env, BLOCKS, 1, bin_blocks, binning);
    return STP_OK;
}

enum stp_result bins_build(const struct stp_env *env, const struct view *view, struct bins *bins)
{
    struct bins built = { .across = (view->width + TILE - 1) / TILE,
                          .down = (view->height + TILE - 1) / TILE };
    struct binning binning = { .view = view, .bins = &built };
    enum stp_result result = build(env, &binning);
    mem_free(binning.cursor);
    if (result == STP_OK)
        *bins = built;
    else
        bins_release(&built);
    return result;
}

void bins_release(struct bins *bins)
{
    mem_free(bins->first);
    mem_free(bins->splat);
    *bins = (struct bins){ 0 };
}
