/* Patches that overlap no more than they must: each site to its nearest holders. */
#ifndef STP_PREPARE_PHONG_SHARE_H
#define STP_PREPARE_PHONG_SHARE_H

#include "prepare/phong_cover.h"

/* Every site stays in the nearest of the patches that hold it, measured from their middles in
 * ellipses of their spread, and in those that are next to as near (the planes of two splats differ
 * in height: without some overlap slanting rays would pass between), and leaves the others. Patches
 * at sharp edges keep all they hold, for their lines were found with it, and so do those that bend
 * by more than 60 degrees. A patch's plane is fitted anew where that keeps to the tolerance. On
 * failure the set is as it was. */
enum stp_result patches_share(const struct stp_env *env, const struct fit_cloud *cloud,
                              double tolerance, struct patch_set *set);

#endif
