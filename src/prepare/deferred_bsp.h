/* ZP 5.2.1: a BSP tree over the members of each transparent group, built once; a frame walks it
 * back to front. The tree is a kd-tree without pointers: the root of nodes [low, high) is the
 * middle one, what is below its plane lies before it, what is above after it. */
#ifndef STP_PREPARE_DEFERRED_BSP_H
#define STP_PREPARE_DEFERRED_BSP_H

#include "scene/splats.h"

/* Puts the ids of each group, ascending, into the order of its tree. groups->first is set. The
 * planes go through the centres: two discs closer than their radii may come in either order. */
enum stp_result bsp_build(const struct stp_env *env, const struct splats *splats,
                          struct cover_groups *groups, const uint32_t *member);

/* Ids in back-to-front order as seen from `eye` (relative to the splats' origin), group k's at
 * out[first[k]]. Of two points on one ray the farther comes first. An orthographic view has its eye
 * at -+INFINITY along each axis, against the view direction. Allocates nothing. */
void bsp_order(const struct stp_env *env, const struct cover_groups *groups, const double eye[3],
               uint32_t *out);

#endif
