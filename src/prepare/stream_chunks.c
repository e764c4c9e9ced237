/* Chunks of a cloud that stays in its file: runs of the canonical order, which begins with a Morton
 * code, so that cells of its first bits are whole runs. */
#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/order.h"
#include "prepare/stream.h"

#define CELL_SHIFT 45 /* of 63 bits 18 are left: 64 cells an axis */
#define STEPS      1048576.0

enum stp_result stream_cells_make(const struct stp_env *env, const struct bounds *box,
                                  struct stream_cells *cells)
{
    struct stream_cells made = { .box = *box };
    made.count = mem_zalloc(STREAM_CELLS, sizeof *made.count);
    made.chunk_of_cell = mem_zalloc(STREAM_CELLS, sizeof *made.chunk_of_cell);
    if (!made.count || !made.chunk_of_cell) {
        stream_cells_release(&made);
        return log_no_memory(env, STREAM_CELLS * sizeof *made.count, "cells of points");
    }
    *cells = made;
    return STP_OK;
}

void stream_cells_release(struct stream_cells *cells)
{
    mem_free(cells->count);
    mem_free(cells->chunk_of_cell);
    *cells = (struct stream_cells){ 0 };
}

static double steps_per_unit(const struct stream_cells *cells)
{
    double extent = bounds_extent(&cells->box);
    return extent > 0 && STEPS / extent < INFINITY ? STEPS / extent : 0;
}

void stream_cells_add(struct stream_cells *cells, const struct splats *splats)
{
    double scale = steps_per_unit(cells);
    for (size_t i = 0; i < splats->count; i++) {
        cells->count[order_code(splats->position[i], &cells->box) >> CELL_SHIFT]++;
        for (int axis = 0; axis < 3; axis++)
            cells->sum[axis] += rint((splats->position[i][axis] - cells->box.low[axis]) * scale);
    }
    cells->points += splats->count;
}

void stream_centroid(const struct stream_cells *cells, double centroid[3])
{
    double scale = steps_per_unit(cells);
    for (int axis = 0; axis < 3; axis++) {
        double mean = cells->sum[axis] / (double)cells->points;
        centroid[axis] = cells->box.low[axis] + (scale > 0 ? mean / scale : 0);
    }
}

void stream_cut(struct scene_stream *stream, struct stream_cells *cells, size_t most)
{
    size_t least = cells->points / (STREAM_MOST_CHUNKS / 2 - 2) + 1, points = 0;
    most = most > least ? most : least; /* two chunks in a row hold more than that */
    stream->chunk_count = 1;
    for (size_t cell = 0; cell < STREAM_CELLS; cell++) {
        uint32_t first = stream->chunk[stream->chunk_count - 1];
        if (points > first && points - first + cells->count[cell] > most)
            stream->chunk[stream->chunk_count++] = (uint32_t)points;
        cells->chunk_of_cell[cell] = (uint8_t)(stream->chunk_count - 1);
        points += cells->count[cell];
    }
    stream->chunk[stream->chunk_count] = (uint32_t)points;
}

void stream_assign(struct scene_stream *stream, const struct stream_cells *cells, size_t first,
                   const struct splats *splats)
{
    for (size_t i = 0; i < splats->count; i++) {
        size_t row = first + (splats->input ? splats->input[i] : i);
        uint64_t cell = order_code(splats->position[i], &cells->box) >> CELL_SHIFT;
        stream->chunk_of[row] = cells->chunk_of_cell[cell];
    }
}
