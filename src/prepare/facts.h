/* What is known of the prepared splats. */
#ifndef STP_PREPARE_FACTS_H
#define STP_PREPARE_FACTS_H

#include "scene/scene.h"

/* Fills the bounds, origin, radii, colour, transparency and outwardness of *facts, splats->origin,
 * and core (scene.h), from splats. */
enum stp_result facts_measure(const struct stp_env *env, struct splats *splats,
                              struct stp_facts *facts, double core[6]);

#endif
