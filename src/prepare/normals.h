/* Normals: given ones counted, single bad ones mended, missing ones estimated. */
#ifndef STP_PREPARE_NORMALS_H
#define STP_PREPARE_NORMALS_H

#include "prepare/surroundings.h"
#include "prepare/places.h"

bool normal_is_unknown(const float normal[3]);
size_t normals_unknown(const struct splats *splats); /* all of them where normal is NULL */

/* Bad normals (0) among good ones: a good one of the same place; else the average of the good ones
 * among the neighbours. Where they cancel, and farther from all good ones, the normal of the
 * least-squares plane, on the side of the neighbours that are known by then: in rounds from the
 * rims of what is bad inwards. What no good one is joined to faces away from the middle of all. */
enum stp_result normals_mend(const struct stp_env *env, struct splats *splats,
                             const struct places *places, const struct neighbour_tree *tree);

#endif
