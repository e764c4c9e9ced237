/* OpenEXR's C core writes chunks of deep lines, but does not pack them: that is done here. */
#include "write/exr_deep_pack.h"

#include <string.h>
#include <zlib.h>

#include "base/memory.h"
#include "base/thread.h"
#include "write/exr_header.h"
#include "write/half.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "EXR data are little-endian");

#define BATCH 64 /* lines in flight */

/* Bytes of a chunk's part: as they are, and as they are written. */
struct packed {
    unsigned char *raw, *zipped;
    size_t raw_room, zipped_room;
    size_t raw_bytes, bytes;
    const unsigned char *data; /* one of the two */
};

struct line {
    struct packed counts, layers;
    unsigned char *mixed; /* while zipping */
    size_t mixed_room;
    exr_result_t result;
};

struct packer {
    const struct exr_deep *picture;
    exr_context_t context;
    uint32_t first_line;
    struct line line[BATCH];
};

size_t exr_deep_bytes(bool half)
{
    return (half ? 4 * 2 : 4 * 4) + 2 * 4;
}

/* Room for so many bytes, whose contents may go. */
static bool make_room(unsigned char **buffer, size_t *room, size_t bytes)
{
    if (bytes <= *room)
        return true;
    mem_free(*buffer);
    *buffer = mem_alloc(bytes, 1);
    *room = *buffer ? bytes : 0;
    return *buffer != NULL;
}

/* What EXR does before zlib: even bytes before odd ones, then differences. */
static void mix(const unsigned char *in, size_t count, unsigned char *out)
{
    size_t evens = (count + 1) / 2;
    for (size_t i = 0; i < count; i++)
        out[i % 2 ? evens + i / 2 : i / 2] = in[i];
    for (size_t i = count; i-- > 1;)
        out[i] = (unsigned char)(out[i] - out[i - 1] + 128);
}

/* Takes what is smaller; readers tell the two by their sizes. */
static exr_result_t zip(struct line *line, struct packed *p)
{
    uLongf bytes = compressBound((uLong)p->raw_bytes);
    p->data = p->raw;
    p->bytes = p->raw_bytes;
    if (!make_room(&line->mixed, &line->mixed_room, p->raw_bytes) ||
        !make_room(&p->zipped, &p->zipped_room, bytes))
        return EXR_ERR_OUT_OF_MEMORY;
    mix(p->raw, p->raw_bytes, line->mixed);
    if (compress2(p->zipped, &bytes, line->mixed, (uLong)p->raw_bytes, EXR_ZIP_LEVEL) != Z_OK)
        return EXR_ERR_OUT_OF_MEMORY;
    if (bytes < p->raw_bytes) {
        p->data = p->zipped;
        p->bytes = bytes;
    }
    return EXR_ERR_SUCCESS;
}

static unsigned char *put(unsigned char *out, float value, bool half)
{
    uint16_t small = half_from_float(value);
    memcpy(out, half ? (const void *)&small : &value, half ? sizeof small : sizeof value);
    return out + (half ? sizeof small : sizeof value);
}

/* One channel after another, in the order of their names. */
static void pack_layers(const struct stp_deep_layer *layer, size_t count, bool half,
                        unsigned char *out)
{
    for (size_t i = 0; i < count; i++)
        out = put(out, layer[i].alpha, half);
    for (int c = 2; c >= 0; c--)
        for (size_t i = 0; i < count; i++)
            out = put(out, layer[i].color[c], half);
    for (int channel = 0; channel < 2; channel++) /* Z, and ZBack: a layer has no thickness */
        for (size_t i = 0; i < count; i++)
            out = put(out, layer[i].z, false);
}

static exr_result_t pack_line(const struct exr_deep *picture, uint32_t y, struct line *line)
{
    const size_t *first = picture->deep->first + (size_t)y * picture->width;
    size_t count = first[picture->width] - first[0];
    struct packed *counts = &line->counts, *layers = &line->layers;
    counts->raw_bytes = counts->bytes = (size_t)picture->width * 4;
    layers->raw_bytes = layers->bytes = count * exr_deep_bytes(picture->half);
    if (!make_room(&counts->raw, &counts->raw_room, counts->raw_bytes) ||
        !make_room(&layers->raw, &layers->raw_room, layers->raw_bytes + 1))
        return EXR_ERR_OUT_OF_MEMORY;
    for (uint32_t x = 0; x < picture->width; x++) {
        int32_t sum = (int32_t)(first[x + 1] - first[0]);
        memcpy(counts->raw + 4 * (size_t)x, &sum, sizeof sum);
    }
    pack_layers(picture->deep->layer + first[0], count, picture->half, layers->raw);
    counts->data = counts->raw;
    layers->data = layers->raw;
    exr_result_t result = picture->zip ? zip(line, counts) : EXR_ERR_SUCCESS;
    return result == EXR_ERR_SUCCESS && picture->zip && count ? zip(line, layers) : result;
}

static void pack_lines(void *context, size_t begin, size_t end, unsigned)
{
    struct packer *p = context;
    for (size_t i = begin; i < end; i++)
        p->line[i].result = pack_line(p->picture, p->first_line + (uint32_t)i, &p->line[i]);
}

static exr_result_t write_line(struct packer *p, uint32_t i)
{
    const struct line *line = &p->line[i];
    if (line->result != EXR_ERR_SUCCESS)
        return line->result;
    return exr_write_deep_scanline_chunk(p->context, 0, (int)(p->first_line + i), line->layers.data,
                                         line->layers.bytes, line->layers.raw_bytes,
                                         line->counts.data, line->counts.bytes);
}

static void release(struct packer *p)
{
    for (int i = 0; i < BATCH; i++) {
        mem_free(p->line[i].counts.raw);
        mem_free(p->line[i].counts.zipped);
        mem_free(p->line[i].layers.raw);
        mem_free(p->line[i].layers.zipped);
        mem_free(p->line[i].mixed);
    }
    mem_free(p);
}

exr_result_t exr_pack_deep(const struct stp_env *env, exr_context_t context,
                           const struct exr_deep *picture)
{
    exr_result_t result = EXR_ERR_SUCCESS;
    struct packer *p = mem_zalloc(1, sizeof *p);
    if (!p)
        return EXR_ERR_OUT_OF_MEMORY;
    p->picture = picture;
    p->context = context;
    while (result == EXR_ERR_SUCCESS && p->first_line < picture->height) {
        uint32_t left = picture->height - p->first_line, count = left < BATCH ? left : BATCH;
        parallel_for(env, count, 1, pack_lines, p);
        for (uint32_t i = 0; i < count && result == EXR_ERR_SUCCESS; i++)
            result = write_line(p, i);
        p->first_line += count;
    }
    release(p);
    return result;
}
