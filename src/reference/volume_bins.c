#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "reference/bins.h"
#include "reference/volume.h"

#define BLOCKS 16 /* of consecutive kernels, counted and filled apart */

struct binning {
    const struct medium *medium;
    struct medium_bins *bins;
    size_t *cursor; /* BLOCKS x tiles: counts, then where to write next */
    bool fill;
};

static void bin_kernel(const struct binning *b, size_t block, uint32_t kernel)
{
    struct medium_bins *bins = b->bins;
    size_t *cursor = b->cursor + block * bins->across * bins->down;
    double bounds[4];
    uint32_t x0, x1, y0, y1;
    if (!medium_bounds(b->medium, kernel, medium_centre(b->medium, kernel), bounds) ||
        !cells_touched(bounds[0], bounds[1], VOLUME_TILE, 0, bins->across, &x0, &x1) ||
        !cells_touched(bounds[2], bounds[3], VOLUME_TILE, 0, bins->down, &y0, &y1))
        return;
    for (uint32_t y = y0; y <= y1; y++)
        for (uint32_t x = x0; x <= x1; x++) {
            size_t *next = &cursor[(size_t)y * bins->across + x];
            if (b->fill)
                bins->kernel[*next] = kernel;
            ++*next;
        }
}

static void bin_blocks(void *context, size_t begin, size_t end, unsigned)
{
    const struct binning *b = context;
    size_t count = b->medium->volume->kernels.count, length = (count + BLOCKS - 1) / BLOCKS;
    for (size_t block = begin; block < end; block++)
        for (size_t i = block * length; i < (block + 1) * length && i < count; i++)
            bin_kernel(b, block, (uint32_t)i);
}

static void place(struct binning *b)
{
    size_t tiles = (size_t)b->bins->across * b->bins->down, total = 0;
    for (size_t tile = 0; tile < tiles; tile++) {
        b->bins->first[tile] = total;
        for (size_t block = 0; block < BLOCKS; block++) {
            size_t *cursor = &b->cursor[block * tiles + tile], count = *cursor;
            *cursor = total;
            total += count;
        }
    }
    b->bins->first[tiles] = total;
}

static enum stp_result build(const struct stp_env *env, struct binning *b)
{
    struct medium_bins *bins = b->bins;
    size_t tiles = (size_t)bins->across * bins->down;
    bins->first = mem_alloc(tiles + 1, sizeof *bins->first);
    b->cursor = mem_zalloc(BLOCKS * tiles, sizeof *b->cursor);
    if (!bins->first || !b->cursor)
        return log_no_memory(env, (BLOCKS + 1) * tiles * sizeof(size_t), "the tiles' lists");
    parallel_for(env, BLOCKS, 1, bin_blocks, b);
    place(b);
    bins->kernel = mem_alloc(bins->first[tiles], sizeof *bins->kernel);
    if (!bins->kernel)
        return log_no_memory(env, bins->first[tiles] * sizeof *bins->kernel, "the tiles' kernels");
    b->fill = true;
    parallel_for(env, BLOCKS, 1, bin_blocks, b);
    return STP_OK;
}

enum stp_result medium_bins_build(const struct stp_env *env, const struct medium *medium,
                                  struct medium_bins *bins)
{
    struct medium_bins built = {
        .across = (medium->view->width + VOLUME_TILE - 1) / VOLUME_TILE,
        .down = (medium->view->height + VOLUME_TILE - 1) / VOLUME_TILE,
    };
    struct binning binning = { .medium = medium, .bins = &built };
    enum stp_result result = build(env, &binning);
    mem_free(binning.cursor);
    if (result == STP_OK)
        *bins = built;
    else
        medium_bins_release(&built);
    return result;
}

void medium_bins_release(struct medium_bins *bins)
{
    mem_free(bins->first);
    mem_free(bins->kernel);
    *bins = (struct medium_bins){ 0 };
}
