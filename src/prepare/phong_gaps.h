/* The surface between the samples: splats grow over the gaps that their neighbours leave. */
#ifndef STP_PREPARE_PHONG_GAPS_H
#define STP_PREPARE_PHONG_GAPS_H

#include "prepare/phong_cover.h"

/* Of three neighbouring samples that no fourth one comes between, the point that is as far from
 * each (a corner of their Voronoi cells) is where the surface is farthest from any sample. Where
 * the disc of one of them reaches it, some splat is to hold it too: the one that has least to grow
 * for it does. The splats are those of the set's patches, in their order. depth: how far off its
 * plane a splat still shows a point. */
enum stp_result gaps_close(const struct stp_env *env, const struct fit_cloud *cloud,
                           const struct patch_set *set, double depth, struct splats *splats);

#endif
