/* Blocks of 8 x 8 pixels and the splats of each walk that may touch them, in the order of the
 * walk's list. */
#ifndef STP_PREPARE_AXIS_BLOCKS_H
#define STP_PREPARE_AXIS_BLOCKS_H

#include "prepare/axis_lists.h"

#define AXIS_BLOCK 8 /* pixels a side */

struct axis_blocks {
    uint32_t across, down;
    uint32_t *first; /* of walk w and block b at w * across * down + b; one more at the end */
    uint32_t *entry; /* places in axis_lists.order, ascending within a block */
    size_t count;
    uint32_t longest; /* entries of one walk in one block */
};

/* A splat is entered where the rectangle of its pixels meets a block in which its walk has a
 * weight. Release with axis_blocks_release. */
enum stp_result axis_blocks_build(const struct stp_env *env, const struct stp_scene *scene,
                                  const struct stp_camera *camera, const struct axis_lists *lists,
                                  struct axis_blocks *blocks);
void axis_blocks_release(struct axis_blocks *blocks);

#endif
