/* The environment's levels: what lobes of the scene's roughnesses receive (docs/glass.md). */
#ifndef STP_PREPARE_ENVIRONMENT_H
#define STP_PREPARE_ENVIRONMENT_H

#include "scene/scene.h"

/* Makes environment->level and ->texel for the scene's materials, from environment->map; nothing
 * without a map. The old levels are left to the caller. */
enum stp_result environment_build(const struct stp_env *env, const struct stp_scene *scene,
                                  struct scene_environment *environment);
/* What plans need to know of scene->environment, into `facts`. */
void environment_facts(const struct stp_scene *scene, struct stp_facts *facts);

/* Where a roughness lies among the levels: the whole part is a level, the rest the share of the
 * next one. */
float environment_level_at(const struct scene_environment *environment, float roughness);

/* environment_levels.c: the lobe of `level` over the map, into its texels; scale multiplies. */
enum stp_result environment_fill(const struct stp_env *env, const struct environment_map *map,
                                 const struct environment_level *level, float scale,
                                 float (*texel)[3]);
/* The size of a level of this roughness over a map of this size; level 0 has the map's own. */
void environment_level_size(const struct environment_map *map, float roughness, uint32_t *width,
                            uint32_t *height);

#endif
