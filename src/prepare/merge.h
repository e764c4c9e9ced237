/* Splats of several objects become one set. */
#ifndef STP_PREPARE_MERGE_H
#define STP_PREPARE_MERGE_H

#include "scene/splats.h"

/* Moves `count` sets (released as they are copied) into *merged, with object ids and with input
 * indices counted on from first_input[i]; unordered. All have normals, radii and inputs; all or
 * none have colours; opacity is 1, and a splat a disc, where they are missing. */
enum stp_result merge_splats(const struct stp_env *env, struct splats *sets, unsigned count,
                             const size_t *first_input, struct splats *merged);

#endif
