/* The environment in float64, from the map itself: no levels, no tables (docs/glass.md). */
#ifndef STP_REFERENCE_ENVIRONMENT_H
#define STP_REFERENCE_ENVIRONMENT_H

#include "reference/disc.h"

/* The light from direction d (camera frame, unit): bilinear where the roughness is 0, else the
 * whole lobe summed over every texel of the map. */
struct vec3 environment_light(const struct view *view, struct vec3 d, double roughness);

#endif
