/* The environment in float64, from the map itself (docs/glass.md). */
#ifndef STP_REFERENCE_ENVIRONMENT_H
#define STP_REFERENCE_ENVIRONMENT_H

#include "reference/disc.h"

/* The light from direction d (camera frame, unit): bilinear where the roughness is 0, else the
 * whole lobe summed over every texel of the map, milliseconds a call; or, where view.leveled, what
 * the device sees: levels that were summed beforehand, for estimates. */
struct vec3 environment_light(const struct view *view, struct vec3 d, double roughness);

#endif
