/* What a file held becomes splats that can be ordered. */
#ifndef STP_PREPARE_COLLECT_H
#define STP_PREPARE_COLLECT_H

#include "load/cloud.h"
#include "scene/splats.h"

/* Moves the cloud's arrays into *splats (no copy) and releases the rest. Drops points with a
 * coordinate that is not finite or whose square float32 cannot hold (counted in not_finite), and
 * those outside the clip box. Normals become unit, or 0 where they are not usable; unusable radii
 * become 0; opacities are clamped to [0, 1] (NaN: 1); colour components that are not finite become
 * 0 (NaN) or 65504. Ellipses that cannot be used become discs (u = 0, counted in bad_phong); radius
 * is the larger of the others' two. input is the index in this cloud, NULL when nothing was
 * dropped. */
enum stp_result collect_cloud(const struct stp_env *env, struct cloud *cloud,
                              const double *clip_box, struct splats *splats,
                              struct stp_facts *facts);

#endif
