/* ZP 5.2.1: a BSP tree over the members of each transparent group, built once; a frame walks it
 * back to front. The tree is one without pointers: the root of nodes [low, high) is the middle one,
 * what is below its plane lies before it, what is above after it. Planes are at right angles to an
 * axis or halfway between two, whichever cuts the fewest discs. */
#ifndef STP_PREPARE_DEFERRED_BSP_H
#define STP_PREPARE_DEFERRED_BSP_H

#include "scene/splats.h"

/* Puts the ids of each group, ascending, into the order of its tree. groups->first is set. The
 * planes go through the centres: two discs that the same plane cuts may come in either order. */
enum stp_result bsp_build(const struct stp_env *env, const struct splats *splats,
                          struct cover_groups *groups, const uint32_t *member);

/* Ids in back-to-front order as seen from `eye` (relative to the splats' origin; its last component
 * 1), group k's at out[first[k]]. Of two points on one ray the farther comes first. Of an
 * orthographic view, `eye` is the direction towards it, and the last component 0.
 *
 * What a plane near the root parts is ordered by distance instead where the plane is seen edge-on:
 * a disc of a near sheet that reaches across it would come before what lies behind on its other
 * side. Scratch memory: 24 bytes a member of such a part, none else. */
enum stp_result bsp_order(const struct stp_env *env, const struct cover_groups *groups,
                          const double eye[4], uint32_t *out);

#endif
