/* Consistent sides for estimated normals. */
#ifndef STP_PREPARE_ORIENT_H
#define STP_PREPARE_ORIENT_H

#include "base/vec.h"
#include "prepare/surroundings.h"
#include "prepare/places.h"

/* Turns normals along a minimum spanning tree of the neighbour graph, edges weighing 1 - |n.n|
 * (Hoppe et al. 1992), then each connected component outward:
 *  - by the flux through it, sum r^2 n.(p - centroid), which for a closed surface is three times
 *    the volume whatever its shape (divergence theorem), so long as it is 5 % of what it could be;
 *  - else by the six extreme points of the component, whose outward normals look along the axes;
 *  - else (an open, nearly flat sheet) so that the mean normal looks up, or along the first axis
 *    that it has a component along.
 * all->spacing stands for r. Unknown normals (0) stay. Deterministic. */
enum stp_result orient_normals(const struct stp_env *env, const struct places *places,
                               struct surroundings *all, struct vec3 up);

#endif
