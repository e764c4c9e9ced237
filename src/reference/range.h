/* Ellipsoids of range images, as a medium of the reference (reference/volume.h). */
#ifndef STP_REFERENCE_RANGE_H
#define STP_REFERENCE_RANGE_H

#include "reference/volume.h"

/* Half the sides of the box around an ellipsoid's reach, camera frame. */
struct vec3 ellipsoid_half(const struct medium *medium, uint32_t kernel);
/* As medium_hit. */
bool ellipsoid_hit(const struct medium *medium, uint32_t kernel, struct vec3 centre, double tau,
                   const struct ray *ray, struct medium_fragment *fragment);
/* Fills medium->shaded and medium->tau. Fails for lack of memory only. */
enum stp_result ellipsoids_look(const struct stp_env *env, struct medium *medium);

#endif
