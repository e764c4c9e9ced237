#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "write/exr_read.h"

/* One a thread. */
struct decoder {
    exr_decode_pipeline_t pipe;
    bool started;
    unsigned char *pixels; /* channels of a chunk, one after the other, 4 bytes a value */
};

struct unpacker {
    const struct exr_source *source;
    struct stp_image *image;
    struct decoder *decoder;
    exr_result_t *result; /* of each chunk */
};

static size_t plane_bytes(const struct exr_source *s)
{
    return (size_t)s->chunk_width * (size_t)s->chunk_height * 4;
}

static exr_result_t chunk_info(const struct exr_source *s, size_t chunk, exr_chunk_info_t *info)
{
    int column = (int)(chunk % (size_t)s->columns), row = (int)(chunk / (size_t)s->columns);
    if (s->tiled)
        return exr_read_tile_chunk_info(s->context, 0, column, row, 0, 0, info);
    return exr_read_scanline_chunk_info(s->context, 0, s->data.min.y + row * s->chunk_height, info);
}

static void aim(const struct exr_source *s, struct decoder *d)
{
    for (int c = 0; c < d->pipe.channel_count; c++) {
        exr_coding_channel_info_t *channel = &d->pipe.channels[c];
        bool integer = channel->data_type == EXR_PIXEL_UINT;
        channel->user_bytes_per_element = 4;
        channel->user_data_type = integer ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = s->chunk_width * 4;
        channel->decode_to_ptr = s->plane[c] ? d->pixels + (size_t)c * plane_bytes(s) : NULL;
    }
}

/* Zeroed: a damaged chunk that inflates to too little must not show what the heap held. */
static void *allocate(exr_transcoding_pipeline_buffer_id_t, size_t bytes)
{
    return mem_zalloc(bytes, 1);
}
static void release(exr_transcoding_pipeline_buffer_id_t, void *pointer)
{
    mem_free(pointer);
}

static exr_result_t decode(const struct exr_source *s, struct decoder *d,
                           const exr_chunk_info_t *info)
{
    exr_result_t result;
    if (d->started) {
        result = exr_decoding_update(s->context, 0, info, &d->pipe);
    } else {
        result = exr_decoding_initialize(s->context, 0, info, &d->pipe);
        d->started = result == EXR_ERR_SUCCESS;
        d->pipe.alloc_fn = allocate;
        d->pipe.free_fn = release;
        d->pixels = mem_zalloc((size_t)s->list->num_channels, plane_bytes(s));
        if (!d->pixels)
            result = EXR_ERR_OUT_OF_MEMORY;
    }
    if (result != EXR_ERR_SUCCESS)
        return result;
    aim(s, d);
    result = exr_decoding_choose_default_routines(s->context, 0, &d->pipe);
    return result == EXR_ERR_SUCCESS ? exr_decoding_run(s->context, 0, &d->pipe) : result;
}

/* [begin, end) of a row of `count` values at `at`, kept inside [0, size). */
struct span {
    int64_t begin, end;
};
static struct span clip(int64_t at, int64_t count, int64_t size)
{
    struct span span = { at < 0 ? -at : 0, at + count > size ? size - at : count };
    return span;
}

static void place(const struct unpacker *u, const struct decoder *d, size_t chunk)
{
    const struct exr_source *s = u->source;
    int64_t x = s->data.min.x - (int64_t)s->display.min.x +
                (int64_t)(chunk % (size_t)s->columns) * s->chunk_width;
    int64_t y = s->data.min.y - (int64_t)s->display.min.y +
                (int64_t)(chunk / (size_t)s->columns) * s->chunk_height;
    struct span across = clip(x, d->pipe.chunk.width, u->image->width);
    struct span down = clip(y, d->pipe.chunk.height, u->image->height);
    if (across.begin >= across.end)
        return;
    for (int c = 0; c < s->list->num_channels; c++)
        for (int64_t line = down.begin; s->plane[c] && line < down.end; line++)
            memcpy(s->plane[c]->data.u + (y + line) * u->image->width + x + across.begin,
                   d->pixels + (size_t)c * plane_bytes(s) +
                       4 * (size_t)(line * s->chunk_width + across.begin),
                   4 * (size_t)(across.end - across.begin));
}

static void unpack_chunks(void *context, size_t begin, size_t end, unsigned worker)
{
    struct unpacker *u = context;
    struct decoder *d = &u->decoder[worker];
    for (size_t i = begin; i < end; i++) {
        exr_chunk_info_t info;
        u->result[i] = chunk_info(u->source, i, &info);
        if (u->result[i] == EXR_ERR_SUCCESS)
            u->result[i] = decode(u->source, d, &info);
        if (u->result[i] == EXR_ERR_SUCCESS)
            place(u, d, i);
    }
}

/* The first chunk that failed, so that the message does not depend on the threads. */
static enum stp_result first_failure(const struct stp_env *env, const struct unpacker *u,
                                     size_t chunks)
{
    const struct exr_source *s = u->source;
    for (size_t i = 0; i < chunks; i++) {
        if (u->result[i] == EXR_ERR_OUT_OF_MEMORY)
            return exr_io_failed(env, s->io, u->result[i], "read");
        if (u->result[i] != EXR_ERR_SUCCESS)
            return log_error(env, STP_ERROR_FORMAT, "%s: cannot read chunk %zu of %zu: %s",
                             s->io->path, i, chunks, exr_get_default_error_message(u->result[i]));
    }
    return STP_OK;
}

enum stp_result exr_unpack_image(const struct stp_env *env, const struct exr_source *source,
                                 struct stp_image *image)
{
    unsigned threads = thread_count(env);
    size_t chunks = (size_t)source->columns * (size_t)source->rows;
    struct unpacker u = { .source = source, .image = image };
    u.decoder = mem_zalloc(threads, sizeof *u.decoder);
    u.result = mem_zalloc(chunks, sizeof *u.result);
    enum stp_result result = STP_OK;
    if (u.decoder && u.result) {
        /* The first one alone: it reads the table of chunks. */
        unpack_chunks(&u, 0, 1, 0);
        if (u.result[0] == EXR_ERR_SUCCESS)
            parallel_for(env, chunks, 1, unpack_chunks, &u);
        result = first_failure(env, &u, chunks);
    } else {
        result = log_no_memory(env, chunks * sizeof *u.result, source->io->path);
    }
    for (unsigned i = 0; u.decoder && i < threads; i++) {
        if (u.decoder[i].started)
            exr_decoding_destroy(source->context, &u.decoder[i].pipe);
        mem_free(u.decoder[i].pixels);
    }
    mem_free(u.decoder);
    mem_free(u.result);
    return result;
}
