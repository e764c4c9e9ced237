/* Lines of a deep picture packed and compressed on all cores, written in order. */
#ifndef STP_WRITE_EXR_DEEP_PACK_H
#define STP_WRITE_EXR_DEEP_PACK_H

#include <stipple/image.h>

#include "write/exr_io.h"

/* After exr_write_header, for part 0, whose channels are A B G R (half, or float) and Z ZBack
 * (float), a line a chunk. zip: ZIPS, else no compression. The bytes do not depend on the number of
 * threads. */
struct exr_deep {
    const struct stp_deep *deep;
    uint32_t width, height;
    bool half, zip;
};
exr_result_t exr_pack_deep(const struct stp_env *env, exr_context_t context,
                           const struct exr_deep *picture);

/* Of a layer, packed. */
size_t exr_deep_bytes(bool half);

#endif
