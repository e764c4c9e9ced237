#include "write/exr_pack.h"

#include <string.h>

#include "base/memory.h"
#include "base/thread.h"
#include "write/half.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "EXR data are little-endian");

/* Unpacked bytes in flight: bounds the memory, and keeps every core busy between writes. */
#define BATCH_BYTES ((uint64_t)4 << 20)

/* One chunk in flight. */
struct slot {
    exr_encode_pipeline_t pipe;
    bool started;
    exr_result_t result;
};

struct packer {
    const struct stp_image *image;
    const struct stp_channel **plane; /* in the file's order of channels */
    exr_context_t context;
    size_t line_bytes;
    int32_t lines; /* a chunk */
    uint32_t first_line;
    size_t slot_count;
    struct slot *slot;
};

static size_t channel_bytes(const struct stp_channel *channel)
{
    return channel->type == STP_CHANNEL_FLOAT && channel->half ? 2 : 4;
}

static unsigned char *pack_line(const struct stp_channel *channel, size_t offset, uint32_t width,
                                unsigned char *out)
{
    if (channel_bytes(channel) == 4) {
        memcpy(out, channel->data.u + offset, 4 * (size_t)width);
        return out + 4 * (size_t)width;
    }
    const float *in = channel->data.f + offset;
    for (uint32_t x = 0; x < width; x++) {
        uint16_t half = half_from_float(in[x]);
        memcpy(out + 2 * (size_t)x, &half, sizeof half);
    }
    return out + 2 * (size_t)width;
}

static exr_result_t start_slot(struct packer *p, struct slot *slot, const exr_chunk_info_t *info)
{
    if (slot->started)
        return exr_encoding_update(p->context, 0, info, &slot->pipe);
    exr_result_t result = exr_encoding_initialize(p->context, 0, info, &slot->pipe);
    if (result != EXR_ERR_SUCCESS)
        return result;
    slot->started = true;
    slot->pipe.packed_buffer = mem_alloc((size_t)p->lines, p->line_bytes);
    if (!slot->pipe.packed_buffer)
        return EXR_ERR_OUT_OF_MEMORY;
    slot->pipe.packed_alloc_size = (size_t)p->lines * p->line_bytes;
    return exr_encoding_choose_default_routines(p->context, 0, &slot->pipe);
}

/* The core's exr_encoding_run holds the context's lock while it packs, so we pack, and call only
 * its compressor. */
static exr_result_t pack_chunk(struct packer *p, struct slot *slot, uint32_t line)
{
    exr_chunk_info_t info;
    exr_result_t result = exr_write_scanline_chunk_info(p->context, 0, (int)line, &info);
    if (result == EXR_ERR_SUCCESS)
        result = start_slot(p, slot, &info);
    if (result != EXR_ERR_SUCCESS)
        return result;
    unsigned char *out = slot->pipe.packed_buffer;
    uint32_t width = p->image->width;
    for (uint32_t y = line; y < line + (uint32_t)info.height; y++)
        for (unsigned c = 0; c < p->image->channel_count; c++)
            out = pack_line(p->plane[c], (size_t)y * width, width, out);
    slot->pipe.packed_bytes = (uint64_t)(out - (unsigned char *)slot->pipe.packed_buffer);
    return slot->pipe.compress_fn ? slot->pipe.compress_fn(&slot->pipe) : EXR_ERR_SUCCESS;
}

static void pack_chunks(void *context, size_t begin, size_t end, unsigned)
{
    struct packer *p = context;
    for (size_t i = begin; i < end; i++)
        p->slot[i].result =
            pack_chunk(p, &p->slot[i], p->first_line + (uint32_t)i * (uint32_t)p->lines);
}

static exr_result_t write_slot(struct packer *p, const struct slot *slot, uint32_t line)
{
    bool packed = slot->pipe.compress_fn != NULL;
    if (slot->result != EXR_ERR_SUCCESS)
        return slot->result;
    return exr_write_scanline_chunk(
        p->context, 0, (int)line, packed ? slot->pipe.compressed_buffer : slot->pipe.packed_buffer,
        packed ? slot->pipe.compressed_bytes : slot->pipe.packed_bytes);
}

static exr_result_t run_batches(const struct stp_env *env, struct packer *p)
{
    uint32_t height = p->image->height, lines = (uint32_t)p->lines;
    exr_result_t result = EXR_ERR_SUCCESS;
    for (p->first_line = 0; p->first_line < height && result == EXR_ERR_SUCCESS;) {
        size_t left = (height - p->first_line + lines - 1) / lines;
        size_t count = left < p->slot_count ? left : p->slot_count;
        parallel_for(env, count, 1, pack_chunks, p);
        for (size_t i = 0; i < count && result == EXR_ERR_SUCCESS; i++)
            result = write_slot(p, &p->slot[i], p->first_line + (uint32_t)i * lines);
        p->first_line += (uint32_t)count * lines;
    }
    return result;
}

/* The core sorts channels by name; ours may come in any order. */
static exr_result_t sort_planes(struct packer *p)
{
    const exr_attr_chlist_t *list;
    exr_result_t result = exr_get_channels(p->context, 0, &list);
    for (int i = 0; i < list->num_channels && result == EXR_ERR_SUCCESS; i++) {
        p->plane[i] = NULL;
        for (unsigned c = 0; c < p->image->channel_count; c++)
            if (strcmp(p->image->channels[c].name, list->entries[i].name.str) == 0)
                p->plane[i] = &p->image->channels[c];
        p->line_bytes += channel_bytes(p->plane[i]) * p->image->width;
    }
    return result;
}

static size_t slots_wanted(const struct stp_env *env, const struct packer *p)
{
    size_t chunks = (p->image->height + (size_t)p->lines - 1) / (size_t)p->lines;
    size_t wanted = BATCH_BYTES / (p->line_bytes * (size_t)p->lines), threads = thread_count(env);
    if (wanted < threads)
        wanted = threads;
    return wanted < chunks ? wanted : chunks;
}

exr_result_t exr_pack_image(const struct stp_env *env, exr_context_t context,
                            const struct stp_image *image)
{
    struct packer p = { .image = image, .context = context };
    exr_result_t result = exr_get_scanlines_per_chunk(context, 0, &p.lines);
    if (result != EXR_ERR_SUCCESS)
        return result;
    p.plane = mem_alloc(image->channel_count, sizeof *p.plane);
    if (!p.plane)
        return EXR_ERR_OUT_OF_MEMORY;
    result = sort_planes(&p);
    if (result == EXR_ERR_SUCCESS) {
        p.slot_count = slots_wanted(env, &p);
        p.slot = mem_zalloc(p.slot_count, sizeof *p.slot);
        result = p.slot ? run_batches(env, &p) : EXR_ERR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; p.slot && i < p.slot_count; i++)
        if (p.slot[i].started)
            exr_encoding_destroy(context, &p.slot[i].pipe);
    mem_free(p.slot);
    mem_free(p.plane);
    return result;
}
