/* A cloud that stays in its file (scene/stream.h). */
#ifndef STP_PREPARE_STREAM_H
#define STP_PREPARE_STREAM_H

#include "prepare/bounds.h"
#include "scene/scene.h"

/* Fills scene->facts and scene->core, and cuts the points into chunks; the facts are those of the
 * scene in memory (outwardness to rounding). *whole: points lack what only neighbours tell, so that
 * the cloud has to be read whole; then the scene is as it was, and a warning was logged. */
enum stp_result prepare_stream(const struct stp_env *env, struct stp_scene *scene,
                               const struct stp_prepare_params *params, bool *whole);

/* The points of one chunk, as they are in the scene in memory: canonical ids stream->chunk[chunk]
 * on. To be released. duplicates: may be NULL. */
enum stp_result stream_splats(const struct stp_env *env, const struct stp_scene *scene,
                              uint32_t chunk, struct splats *splats, size_t *duplicates);

/* stream_chunks.c: a count of points in each cell of a coarse grid, in canonical order. */
struct stream_cells {
    struct bounds box;
    size_t *count;          /* STREAM_CELLS */
    uint8_t *chunk_of_cell; /* made by stream_cut */
    double sum[3];          /* of the points' places in the box, in steps: whole numbers, exact */
    size_t points;
};
#define STREAM_CELLS ((size_t)1 << 18)

enum stp_result stream_cells_make(const struct stp_env *env, const struct bounds *box,
                                  struct stream_cells *cells);
void stream_cells_release(struct stream_cells *cells);
void stream_cells_add(struct stream_cells *cells, const struct splats *splats);
void stream_centroid(const struct stream_cells *cells, double centroid[3]);
/* Cells to chunks of at most `most` points, or of one cell; the rows of the splats to their
 * chunks'.
 */
void stream_cut(struct scene_stream *stream, struct stream_cells *cells, size_t most);
void stream_assign(struct scene_stream *stream, const struct stream_cells *cells, size_t first,
                   const struct splats *splats);

#endif
