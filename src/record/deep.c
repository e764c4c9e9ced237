/* Layers of a deep picture, as a tile's rays leave them: a window of them at a time (docs/exr.md).
 */
#include "record/record.h"

#include "base/log.h"
#include "base/memory.h"

_Static_assert(STP_DEEP_WINDOW >= RECORD_TURNS, "a part leaves no more layers of a mended ray");

enum stp_result record_deep_create(const struct stp_env *env, const struct stp_plan *plan,
                                   struct record_deep *deep)
{
    size_t pixels = plan_pixels(plan);
    *deep = (struct record_deep){ 0 };
    if (!plan->constant[PLAN_DEEP])
        return STP_OK;
    deep->taken = mem_alloc(pixels, sizeof *deep->taken);
    return deep->taken ? STP_OK : log_no_memory(env, pixels * sizeof *deep->taken, "layers");
}

void record_deep_destroy(struct record_deep *deep)
{
    deep_list_release(&deep->list);
    mem_free(deep->taken);
    *deep = (struct record_deep){ 0 };
}

void record_deep_begin(struct record_deep *deep, const struct plan_tile *tile)
{
    size_t across = (tile->width + STP_BLOCK - 1) / STP_BLOCK;
    size_t down = (tile->height + STP_BLOCK - 1) / STP_BLOCK;
    for (size_t i = 0; i < across * down * STP_GROUP; i++)
        deep->taken[i] = 0;
    deep->first = 0;
    deep->more = false;
}

/* Where the device has pixel (x, y) of the tile: glsl/lib/pixel.glsl. */
static size_t place_of(const struct plan_tile *tile, uint32_t x, uint32_t y)
{
    size_t across = (tile->width + STP_BLOCK - 1) / STP_BLOCK;
    size_t block = (size_t)(y / STP_BLOCK) * across + x / STP_BLOCK;
    return block * STP_GROUP + (size_t)(y % STP_BLOCK) * STP_BLOCK + x % STP_BLOCK;
}

static struct stp_deep_layer layer_at(const float *layers, size_t place, uint32_t layer)
{
    size_t rank = place / STP_GROUP * STP_DEEP_WINDOW + layer % STP_DEEP_WINDOW;
    const float *f = layers + (rank * STP_GROUP + place % STP_GROUP) * STP_DEEP_FLOATS;
    return (struct stp_deep_layer){ f[0], { f[1], f[2], f[3] }, f[4] };
}

/* What of one pixel is new. A mended ray has new layers after each part that loops; another has the
 * window's, after the part that resolves it. */
static enum stp_result take_pixel(struct record_deep *deep, size_t place, uint32_t pixel,
                                  uint32_t count, bool loops)
{
    bool mended = (count & STP_DEEP_MENDED) != 0;
    uint32_t layers = count & ~STP_DEEP_MENDED, end = layers, *taken = &deep->taken[place];
    enum stp_result result = STP_OK;
    if (mended != loops)
        return STP_OK;
    if (!mended && end > deep->first + STP_DEEP_WINDOW) {
        end = deep->first + STP_DEEP_WINDOW;
        deep->more = true;
    }
    for (; result == STP_OK && *taken < end; ++*taken) {
        struct stp_deep_layer layer = layer_at(deep->layers, place, *taken);
        result = deep_add(&deep->list, pixel, &layer);
    }
    return result;
}

enum stp_result record_deep_take(const struct stp_env *env, struct record_frame *frame,
                                 const struct plan_tile *tile, bool loops)
{
    struct record_deep *deep = frame->deep;
    enum stp_result result = record_invalidate(env, frame);
    if (result != STP_OK)
        return result;
    deep->layers = record_output(frame, PLAN_DEEP_LAYERS);
    const uint32_t *counts = record_output(frame, PLAN_DEEP_COUNTS);
    for (uint32_t y = tile->keep[1]; result == STP_OK && y < tile->keep[3]; y++)
        for (uint32_t x = tile->keep[0]; result == STP_OK && x < tile->keep[2]; x++) {
            size_t place = place_of(tile, x - tile->x, y - tile->y);
            uint32_t pixel = y * frame->plan->camera.width + x;
            result = take_pixel(deep, place, pixel, counts[place], loops);
        }
    return result == STP_OK ? STP_OK
                            : log_no_memory(env, 2 * deep->list.room * sizeof *deep->list.entry,
                                            "layers of a deep picture");
}

bool record_deep_next(struct record_deep *deep)
{
    bool more = deep->more;
    deep->first += STP_DEEP_WINDOW;
    deep->more = false;
    return more;
}

enum stp_result record_deep_finish(const struct stp_env *env, const struct record_deep *deep,
                                   struct stp_image *image)
{
    return deep_build(env, &deep->list, 1, (size_t)image->width * image->height, &image->deep);
}
