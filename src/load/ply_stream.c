#include "load/ply_stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/ply.h"

static bool has_byte_colors(const struct table *table)
{
    for (unsigned i = 0; i < table->count; i++) {
        const struct column *c = &table->column[i];
        bool color = c->role == ROLE_RED || c->role == ROLE_GREEN || c->role == ROLE_BLUE;
        if (color && c->scale != SCALE_BYTE && c->scale != SCALE_LINEAR)
            return false;
    }
    return true;
}

static const char *judge_table(const struct table *table, bool radius)
{
    if (!table_has(table, ROLE_NX) || !table_has(table, ROLE_NY) || !table_has(table, ROLE_NZ))
        return "it has no normals, and estimating them takes neighbours";
    if (!table_has(table, ROLE_RADIUS) && !radius)
        return "it has no radii, and finding them takes neighbours (--radius gives one to all)";
    if (table_has(table, ROLE_OPACITY))
        return "it has opacities";
    if (!has_byte_colors(table))
        return "its colours are no bytes, and what they mean takes a look at all";
    return NULL;
}

static enum stp_result judge_vertices(const struct stp_env *env, const struct ply_header *header,
                                      const struct ply_element *vertex, bool radius,
                                      const char **why)
{
    struct table table = { .count = vertex->properties, .field = -1 };
    table.column = mem_zalloc(table.count, sizeof *table.column);
    if (!table.column)
        return log_no_memory(env, table.count * sizeof *table.column, "the columns of a PLY");
    ply_fill_columns(header, vertex, &table);
    table_name_roles(&table);
    *why = judge_table(&table, radius);
    mem_free(table.column);
    return STP_OK;
}

/* False: the reader of whole files has to say what is wrong. */
static bool find_rows(const struct stp_env *, const struct ply_header *header,
                      const struct ply_element *vertex, struct ply_stream *stream, bool *has_list)
{
    bool before;
    stream->count = vertex->count;
    stream->stride = ply_element_size(header, vertex, has_list);
    stream->offset = header->body;
    for (const struct ply_element *e = header->element; e < vertex; e++) {
        size_t size = ply_element_size(header, e, &before);
        *has_list |= before;
        if (size && e->count > (stream->bytes.size - stream->offset) / size)
            return false;
        stream->offset += e->count * size;
    }
    return stream->count > 0 && stream->stride > 0 &&
           stream->count <= (stream->bytes.size - stream->offset) / stream->stride;
}

/* A file of some of the rows. */
static void write_head(FILE *out, const struct ply_header *header)
{
    fprintf(out, "ply\nformat binary_%s_endian 1.0\n%selement vertex ",
            header->encoding == PLY_BIG ? "big" : "little",
            header->prepared ? "comment stipple prepared 1\n" : "");
}

static void write_tail(FILE *out, const struct ply_header *header, const struct ply_element *vertex)
{
    static const char *const types[] = { "",      "int8",   "uint8",   "int16",  "uint16",
                                         "int32", "uint32", "float32", "float64" };
    for (unsigned i = 0; i < vertex->properties; i++) {
        const struct ply_property *p = &header->property[vertex->first + i];
        fprintf(out, "\nproperty %s %.*s", types[p->type], (int)p->name.length, p->name.text);
    }
    fprintf(out, "\nend_header\n");
}

#define COUNT_DIGITS 20

/* Into memory of our own allocator, so that tests can make it fail. */
static char *text_of(const struct ply_header *header, const struct ply_element *vertex)
{
    char *text = NULL, *copy = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    if (vertex)
        write_tail(out, header, vertex);
    else
        write_head(out, header);
    if (fclose(out) == 0 && (copy = mem_alloc(size + 1, 1)))
        memcpy(copy, text, size + 1);
    free(text);
    return copy;
}

static enum stp_result keep_header(const struct stp_env *env, const char *path,
                                   const struct ply_header *header,
                                   const struct ply_element *vertex, struct ply_stream *stream)
{
    stream->path = mem_alloc(strlen(path) + 1, 1);
    stream->head = text_of(header, NULL);
    stream->tail = text_of(header, vertex);
    if (!stream->path || !stream->head || !stream->tail)
        return log_no_memory(env, strlen(path) + 1, "the header of a PLY");
    memcpy(stream->path, path, strlen(path) + 1);
    return STP_OK;
}

enum stp_result ply_rows_begin(const struct stp_env *env, const struct ply_stream *stream,
                               size_t count, struct ply_rows *rows)
{
    size_t head = strlen(stream->head), tail = strlen(stream->tail);
    char digits[COUNT_DIGITS + 1];
    rows->size = head + COUNT_DIGITS + tail + count * stream->stride;
    rows->data = mem_alloc(rows->size, 1);
    if (!rows->data)
        return log_no_memory(env, rows->size, stream->path);
    snprintf(digits, sizeof digits, "%0*zu", COUNT_DIGITS, count);
    memcpy(rows->data, stream->head, head);
    memcpy(rows->data + head, digits, COUNT_DIGITS);
    memcpy(rows->data + head + COUNT_DIGITS, stream->tail, tail);
    rows->rows = rows->data + head + COUNT_DIGITS + tail;
    return STP_OK;
}

/* What there is to say of the file has been said of its first row. */
enum stp_result ply_rows_read(const struct stp_env *env, const struct ply_stream *stream,
                              struct ply_rows *rows, struct cloud *cloud)
{
    const struct stp_env silent = { .threads = env ? env->threads : 0, .log = log_nothing };
    const struct file_bytes bytes = { .data = rows->data, .size = rows->size };
    enum stp_result result = ply_read(&silent, stream->path, &bytes, &stream->options, cloud);
    mem_free(rows->data);
    rows->data = NULL;
    return result == STP_OK ? STP_OK : log_no_memory(env, rows->size, stream->path);
}

/* The first row, with its warnings; splats with normal fields are none of our points. */
static enum stp_result try_row(const struct stp_env *env, struct ply_stream *stream,
                               const char **why)
{
    struct ply_rows rows;
    struct cloud cloud = { 0 };
    enum stp_result result = ply_rows_begin(env, stream, 1, &rows);
    if (result != STP_OK)
        return result;
    memcpy(rows.rows, ply_stream_row(stream, 0), stream->stride);
    const struct file_bytes bytes = { .data = rows.data, .size = rows.size };
    result = ply_read(env, stream->path, &bytes, &stream->options, &cloud);
    mem_free(rows.data);
    if (result == STP_OK && cloud.phong)
        *why = "its splats carry normal fields";
    memcpy(stream->format, cloud.format, sizeof stream->format);
    cloud_release(&cloud);
    return result;
}

static enum stp_result open_vertices(const struct stp_env *env, const char *path,
                                     const struct ply_header *header, bool radius,
                                     struct ply_stream *stream, const char **why)
{
    const struct ply_element *vertex = ply_find_element(header, "vertex");
    bool has_list = false;
    if (!vertex || vertex->count == 0 || ply_is_gaussian(header, vertex))
        return STP_OK;
    if (header->encoding == PLY_ASCII || header->object_count > 1) {
        *why = header->object_count > 1 ? "it holds several objects" : "it is text";
        return STP_OK;
    }
    if (header->object_count)
        stream->object = header->objects[0];
    bool whole = find_rows(env, header, vertex, stream, &has_list);
    *why = has_list ? "it holds lists before or among its vertices" : NULL;
    if (*why || !whole)
        return STP_OK;
    enum stp_result result = judge_vertices(env, header, vertex, radius, why);
    return result == STP_OK && !*why ? keep_header(env, path, header, vertex, stream) : result;
}

enum stp_result ply_stream_open(const struct stp_env *env, const char *path,
                                struct file_bytes *bytes, const struct load_options *options,
                                bool radius, struct ply_stream *stream, const char **why)
{
    const struct stp_env silent = { .log = log_nothing };
    struct ply_stream made = { .bytes = *bytes, .options = *options };
    struct ply_header header;
    *why = NULL;
    if (!ply_probe(bytes))
        return STP_OK;
    if (bytes->inflated)
        *why = "it is compressed";
    else if (options->color_by && strcmp(options->color_by, "rgb") != 0)
        *why = "--color-by takes a look at all points";
    if (*why)
        return STP_OK;
    enum stp_result result = ply_header_read(&silent, path, bytes, &header);
    if (result == STP_ERROR_MEMORY)
        return log_no_memory(env, PLY_MAX_PROPERTIES * sizeof *header.property, path);
    if (result != STP_OK) /* the reader of whole files will say what is wrong */
        return STP_OK;
    made.options.color_by = NULL;
    result = open_vertices(env, path, &header, radius, &made, why);
    ply_header_release(&header);
    if (result == STP_OK && made.tail)
        result = try_row(env, &made, why);
    if (result == STP_OK && made.tail && !*why) {
        *stream = made;
        *bytes = (struct file_bytes){ 0 };
        return STP_OK;
    }
    made.bytes = (struct file_bytes){ 0 };
    ply_stream_close(&made);
    return result;
}

void ply_stream_close(struct ply_stream *stream)
{
    file_release(&stream->bytes);
    mem_free(stream->path);
    mem_free(stream->head);
    mem_free(stream->tail);
    *stream = (struct ply_stream){ 0 };
}

void ply_stream_forget(const struct ply_stream *stream, size_t first, size_t count)
{
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    uintptr_t begin = (uintptr_t)ply_stream_row(stream, first);
    uintptr_t end = begin + count * stream->stride;
    begin = (begin + page - 1) / page * page;
    end = end / page * page;
    if (stream->bytes.mapped && end > begin)
        madvise((void *)begin, end - begin, MADV_DONTNEED);
}
