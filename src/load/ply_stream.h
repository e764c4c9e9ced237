/* Points of a binary PLY that stay in the file: any of its rows, read when they are wanted. */
#ifndef STP_LOAD_PLY_STREAM_H
#define STP_LOAD_PLY_STREAM_H

#include "load/load.h"

struct ply_stream {
    struct file_bytes bytes; /* mapped; owned */
    char *path;
    struct load_options options;
    char format[32];              /* as in struct cloud */
    struct cloud_object object;   /* what the file says of the one it holds */
    size_t offset, stride, count; /* of the rows */
    char *head, *tail; /* header of a file of such vertices: what comes before their count, after */
};

/* Takes *bytes over (they are zeroed) where rows can be read alone, and nothing of them depends on
 * the others: a binary PLY, not inflated, of scalars only, with normals, with radii unless others
 * are given (radius), colours of one byte a component, no opacities. Else *why says what stands
 * against it (NULL: it is no PLY, or the reader of whole files has to speak), and the result is
 * STP_OK. */
enum stp_result ply_stream_open(const struct stp_env *env, const char *path,
                                struct file_bytes *bytes, const struct load_options *options,
                                bool radius, struct ply_stream *stream, const char **why);
void ply_stream_close(struct ply_stream *stream);

/* A buffer for `count` rows, to be copied to `rows`; to be freed with mem_free(data). */
struct ply_rows {
    unsigned char *data, *rows;
    size_t size; /* of data */
};
enum stp_result ply_rows_begin(const struct stp_env *env, const struct ply_stream *stream,
                               size_t count, struct ply_rows *rows);
/* The rows as a file of their own would be read. Frees the buffer. */
enum stp_result ply_rows_read(const struct stp_env *env, const struct ply_stream *stream,
                              struct ply_rows *rows, struct cloud *cloud);

static inline const unsigned char *ply_stream_row(const struct ply_stream *stream, size_t row)
{
    return stream->bytes.data + stream->offset + row * stream->stride;
}

/* The pages of these rows are not looked at again soon. */
void ply_stream_forget(const struct ply_stream *stream, size_t first, size_t count);

#endif
