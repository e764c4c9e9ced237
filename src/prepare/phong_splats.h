/* Patches to splats: BSK Eq. 1-4. */
#ifndef STP_PREPARE_PHONG_SPLATS_H
#define STP_PREPARE_PHONG_SPLATS_H

#include "prepare/phong_cover.h"

/* How fields are fitted: constant ones, and each by itself. */
struct field_way {
    bool flat, alone;
};

/* One splat a patch, in the patches' order, then one for each sample that none of them covers when
 * its plane, ellipse and lines are what the floats say. *deviation: the largest distance of a
 * sample from the plane of the nearest splat that covers it. */
enum stp_result patches_to_splats(const struct stp_env *env, const struct fit_cloud *cloud,
                                  const struct patch_set *set, double tolerance,
                                  struct field_way way, struct splats *splats, double *deviation);

#endif
