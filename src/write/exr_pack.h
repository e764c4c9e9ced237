/* Scanline chunks packed and compressed on all cores, written in order. */
#ifndef STP_WRITE_EXR_PACK_H
#define STP_WRITE_EXR_PACK_H

#include <stipple/image.h>

#include "write/exr_io.h"

/* After exr_write_header, for part 0. The bytes do not depend on the number of threads. */
exr_result_t exr_pack_image(const struct stp_env *env, exr_context_t context,
                            const struct stp_image *image);

#endif
