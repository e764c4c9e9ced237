/* OpenEXR's C core on our files, memory and log. */
#ifndef STP_WRITE_EXR_IO_H
#define STP_WRITE_EXR_IO_H

#include <openexr.h>

#include "base/file.h"

struct exr_io {
    const char *path;               /* for messages */
    int descriptor;                 /* writing */
    const struct file_bytes *bytes; /* reading */
    int error;                      /* errno of the first write that failed */
};

/* For exr_start_read / exr_start_write: the core reads from
 * io->bytes, writes to io->descriptor, and prints nothing. */
exr_context_initializer_t exr_io_initializer(struct exr_io *io);

/* The one line for a failed call of the core: errno, or what the core's code means. */
enum stp_result exr_io_failed(const struct stp_env *env, const struct exr_io *io, exr_result_t code,
                              const char *verb);

#endif
