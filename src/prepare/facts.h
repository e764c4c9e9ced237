/* What is known of the prepared splats. */
#ifndef STP_PREPARE_FACTS_H
#define STP_PREPARE_FACTS_H

#include "prepare/bounds.h"
#include "scene/scene.h"

/* Fills the bounds, origin, radii, colour, transparency and outwardness of *facts, splats->origin,
 * and core (scene.h), from splats. */
enum stp_result facts_measure(const struct stp_env *env, struct splats *splats,
                              struct stp_facts *facts, double core[6]);

/* core from every step-th position of the canonical order, an axis an array of n (reordered): the
 * box of the 1st to the 99th percentile along each axis, grown by its diagonal on every side. */
size_t facts_core_step(size_t count);
void facts_core(double *sample[3], size_t n, const struct bounds *all, double core[6]);
/* 0 where the coordinates are no larger than a few times the scene, so that float32 input stays
 * exact on the device; else the middle of the core, rounded to a multiple of the power of two below
 * its extent, so that differences stay as exact as can be. */
void facts_origin(const double core[6], double origin[3]);

/* The two sums of splats, of r^2 n.(p - centroid) and r^2 |p - centroid|, whose quotient is
 * facts.outwardness. */
enum stp_result facts_flux(const struct stp_env *env, const struct splats *splats,
                           const double centroid[3], double flux[2]);

/* STP_ERROR_NO_POINTS, and the line that says where they all went. */
enum stp_result facts_no_points(const struct stp_env *env, const struct stp_facts *facts);

#endif
