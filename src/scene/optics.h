/* Optics of materials: checked, merged and resolved (docs/glass.md). */
#ifndef STP_SCENE_OPTICS_H
#define STP_SCENE_OPTICS_H

#include "base/json.h"
#include "scene/scene.h"

/* Fails with a line when a number is out of its range; NULL is fine. */
enum stp_result optics_check(const struct stp_env *env, const struct stp_optics *optics);
/* Defaults in the place of what is not set, 0 in the place of what is negative. */
struct stp_optics optics_resolve(const struct stp_optics *optics);
/* What `over` sets (it may be NULL), else what `under` says. */
struct stp_optics optics_merge(const struct stp_optics *under, const struct stp_optics *over);
/* Whether a surface of these (resolved) optics reflects, bends or absorbs anything. */
bool optics_matter(const struct stp_optics *optics);

#define OPTICS_KEYS "ior reflectance roughness absorption thickness"
/* Of a material in a scene .json: each a number, or one a channel where a channel has its own. */
enum stp_result optics_from_json(const struct json_at *at, const cJSON *material,
                                 struct stp_optics *optics);

#endif
