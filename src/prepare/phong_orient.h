/* Consistent sides of fitted splats, where their samples' normals have none. */
#ifndef STP_PREPARE_PHONG_ORIENT_H
#define STP_PREPARE_PHONG_ORIENT_H

#include "prepare/phong_cover.h"

/* Turns the splats (the first set->count are the patches') as orient_normals turns points, splats
 * being neighbours that hold the same site, or sites that are neighbours. BSK 5: only the splats
 * need a consistent side, not the samples. */
enum stp_result splats_orient(const struct stp_env *env, const struct fit_cloud *cloud,
                              const struct patch_set *set, struct vec3 up, struct splats *splats);

#endif
