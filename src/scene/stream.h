/* A cloud that stays in its file: points are read in blocks of rows, or in chunks that follow each
 * other in canonical order, and only method pyramid draws them. */
#ifndef STP_SCENE_STREAM_H
#define STP_SCENE_STREAM_H

#include "load/ply_stream.h"

#define STREAM_MOST_CHUNKS 128
#define STREAM_DROPPED     255 /* of chunk_of: not finite, or outside the clip box */

struct scene_stream {
    struct ply_stream file;
    size_t chunk_points; /* wanted in a chunk, at most; 0: as prepare sees fit */
    float radius;        /* of points that bring none; 0: all do */
    uint8_t *chunk_of;   /* a row; made by prepare */
    uint32_t chunk_count;
    uint32_t chunk[STREAM_MOST_CHUNKS + 1]; /* points [chunk[i], chunk[i + 1]) of canonical order */
    double clip_box[6];
    bool clipped;
};

void stream_release(struct scene_stream **stream);

/* Gives fn the rows of the file, a block after the other; it takes the cloud over, and ends the
 * walk where it fails. stage: of progress, from `begin` to `end`; NULL: none. */
typedef enum stp_result (*stream_block_fn)(const struct stp_env *env, void *context, size_t first,
                                           struct cloud *cloud);
enum stp_result stream_walk(const struct stp_env *env, const struct scene_stream *stream,
                            const char *stage, double begin, double end, stream_block_fn fn,
                            void *context);

struct stp_scene;
/* Reads the cloud into the scene's object after all; the stream is gone then. */
enum stp_result stream_read_whole(const struct stp_env *env, struct stp_scene *scene);

/* The points of one chunk, in the order of the file, and their rows (to be freed). */
enum stp_result stream_read(const struct stp_env *env, const struct scene_stream *stream,
                            uint32_t chunk, struct cloud *cloud, uint32_t **row);

#endif
