#include "scene/stream.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "load/readers.h"
#include "scene/scene.h"

#define BLOCK ((size_t)1 << 20) /* rows that are converted at once */
#define GRAIN ((size_t)1 << 16) /* rows that a thread picks from at once */

void stream_release(struct scene_stream **stream)
{
    if (!*stream)
        return;
    ply_stream_close(&(*stream)->file);
    mem_free((*stream)->chunk_of);
    mem_free(*stream);
    *stream = NULL;
}

static enum stp_result convert(const struct stp_env *env, const struct scene_stream *stream,
                               struct ply_rows *rows, struct cloud *cloud)
{
    enum stp_result result = ply_rows_read(env, &stream->file, rows, cloud);
    if (result != STP_OK)
        return result;
    result = cloud_give_radius(env, stream->radius, cloud);
    if (result != STP_OK)
        cloud_release(cloud);
    return result;
}

static enum stp_result read_block(const struct stp_env *env, const struct scene_stream *stream,
                                  size_t first, size_t count, struct cloud *cloud)
{
    struct ply_rows rows;
    enum stp_result result = ply_rows_begin(env, &stream->file, count, &rows);
    if (result != STP_OK)
        return result;
    memcpy(rows.rows, ply_stream_row(&stream->file, first), count * stream->file.stride);
    ply_stream_forget(&stream->file, first, count);
    return convert(env, stream, &rows, cloud);
}

enum stp_result stream_walk(const struct stp_env *env, const struct scene_stream *stream,
                            const char *stage, double begin, double end, stream_block_fn fn,
                            void *context)
{
    size_t all = stream->file.count;
    for (size_t first = 0; first < all; first += BLOCK) {
        struct cloud cloud = { 0 };
        size_t count = all - first < BLOCK ? all - first : BLOCK;
        enum stp_result result = read_block(env, stream, first, count, &cloud);
        if (result == STP_OK)
            result = fn(env, context, first, &cloud);
        if (result != STP_OK)
            return result;
        if (stage)
            log_progress(env, stage, begin + (end - begin) * (double)(first + count) / (double)all);
    }
    return STP_OK;
}

/* Rows of one chunk, to their places: a thread takes GRAIN rows, whose first match has a place that
 * was counted before. */
struct picking {
    const struct scene_stream *stream;
    uint8_t chunk;
    size_t *place; /* a grain: of its first match */
    unsigned char *out;
    uint32_t *row;
};

static void count_grain(void *context, size_t begin, size_t end, unsigned)
{
    const struct picking *p = context;
    size_t all = p->stream->file.count;
    for (size_t g = begin; g < end; g++) {
        size_t last = (g + 1) * GRAIN < all ? (g + 1) * GRAIN : all, count = 0;
        for (size_t i = g * GRAIN; i < last; i++)
            count += p->stream->chunk_of[i] == p->chunk;
        p->place[g] = count;
    }
}

static void pick_grain(void *context, size_t begin, size_t end, unsigned)
{
    const struct picking *p = context;
    const struct ply_stream *file = &p->stream->file;
    for (size_t g = begin; g < end; g++) {
        size_t first = g * GRAIN, at = p->place[g];
        size_t last = first + GRAIN < file->count ? first + GRAIN : file->count;
        for (size_t i = first; i < last; i++) {
            if (p->stream->chunk_of[i] != p->chunk)
                continue;
            memcpy(p->out + at * file->stride, ply_stream_row(file, i), file->stride);
            p->row[at++] = (uint32_t)i;
        }
        ply_stream_forget(file, first, last - first);
    }
}

/* Counts to places. */
static void add_up(size_t *place, size_t grains)
{
    size_t sum = 0;
    for (size_t g = 0; g < grains; g++) {
        size_t count = place[g];
        place[g] = sum;
        sum += count;
    }
}

enum stp_result stream_read(const struct stp_env *env, const struct scene_stream *stream,
                            uint32_t chunk, struct cloud *cloud, uint32_t **row)
{
    size_t grains = (stream->file.count + GRAIN - 1) / GRAIN;
    size_t count = stream->chunk[chunk + 1] - stream->chunk[chunk];
    struct ply_rows rows = { 0 };
    struct picking p = { .stream = stream, .chunk = (uint8_t)chunk };
    p.place = mem_alloc(grains, sizeof *p.place);
    p.row = mem_alloc(count, sizeof *p.row);
    enum stp_result result = p.place && p.row
                                 ? ply_rows_begin(env, &stream->file, count, &rows)
                                 : log_no_memory(env, count * sizeof *p.row, "a chunk of points");
    if (result == STP_OK) {
        p.out = rows.rows;
        parallel_for(env, grains, 1, count_grain, &p);
        add_up(p.place, grains);
        parallel_for(env, grains, 1, pick_grain, &p);
        result = convert(env, stream, &rows, cloud);
    }
    mem_free(p.place);
    if (result == STP_OK)
        *row = p.row;
    else
        mem_free(p.row);
    return result;
}

enum stp_result stream_read_whole(const struct stp_env *env, struct stp_scene *scene)
{
    const struct ply_stream *file = &scene->stream->file;
    struct cloud cloud = { 0 };
    enum stp_result result = load_from_bytes(env, file->path, &file->bytes, &file->options, &cloud);
    if (result == STP_OK)
        result = cloud_give_radius(env, scene->stream->radius, &cloud);
    if (result != STP_OK) {
        cloud_release(&cloud);
        return result;
    }
    scene->objects[0].cloud = cloud;
    stream_release(&scene->stream);
    return STP_OK;
}
