/* Between exr_read.c (header and planes) and exr_unpack.c (pixels). */
#ifndef STP_WRITE_EXR_READ_H
#define STP_WRITE_EXR_READ_H

#include <stipple/image.h>

#include "write/exr_io.h"

/* Part 0 of a file that is open. */
struct exr_source {
    exr_context_t context;
    struct exr_io *io;
    exr_attr_box2i_t data, display;
    bool tiled;
    int32_t chunk_width, chunk_height; /* of a whole tile, or of a block of lines */
    int32_t columns, rows;             /* of chunks */
    const exr_attr_chlist_t *list;
    struct stp_channel **plane; /* in the file's order; NULL: not wanted */
};

/* Decodes every chunk, on all cores, into the planes, cut to the display window. */
enum stp_result exr_unpack_image(const struct stp_env *env, const struct exr_source *source,
                                 struct stp_image *image);

#endif
