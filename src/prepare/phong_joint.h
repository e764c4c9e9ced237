/* BSK Eq. 3 and 4 for all splats together: where splats overlap a picture shows the mean of their
 * fields, and it is that mean which is to follow the samples' normals. */
#ifndef STP_PREPARE_PHONG_JOINT_H
#define STP_PREPARE_PHONG_JOINT_H

#include "prepare/phong_cover.h"

/* Fits the fields anew to the sites that each splat shows. The splats are those of the set's
 * patches, in their order; fields of single samples stay. depth: how far off its plane a splat
 * still shows a site. */
enum stp_result fields_fit_together(const struct stp_env *env, const struct fit_cloud *cloud,
                                    const struct patch_set *set, double depth, bool flat,
                                    struct splats *splats);

#endif
