/* Blocks of pixels and the splats of each walk that may touch them, in the order of the
 * walk's list. */
#ifndef STP_PREPARE_AXIS_BLOCKS_H
#define STP_PREPARE_AXIS_BLOCKS_H

#include "prepare/axis_lists.h"

struct axis_blocks {
    uint32_t across, down; /* of AXIS_BLOCK_WIDTH x AXIS_BLOCK_HEIGHT */
    uint32_t *first;       /* of walk w and block b at w * across * down + b; one more at the end */
    uint32_t *entry;       /* kernels, far to near within a block */
    size_t count;
    size_t longest, fullest;            /* entries in one block: of one walk; of all */
    uint32_t *cursor;                   /* of runs of the lists: where to write next */
    struct axis_span *span;             /* of the lists' kernels in their order, in blocks */
    size_t lists, room, cursors, spans; /* what first, entry, cursor and span have place for */
};

/* A splat is entered where the rectangle of its pixels meets a block in which its walk has a
 * weight. What blocks holds, zero or a former view's, is used again; on failure it is empty.
 * Release with axis_blocks_release. */
enum stp_result axis_blocks_update(const struct stp_env *env, const struct axis_lists *lists,
                                   struct axis_blocks *blocks);
/* In two steps: all but the entries; then these, once, to where the caller has place for
 * blocks->count of them, which need not be blocks->entry. */
enum stp_result axis_blocks_count(const struct stp_env *env, const struct axis_lists *lists,
                                  struct axis_blocks *blocks);
void axis_blocks_fill(const struct stp_env *env, const struct axis_lists *lists,
                      struct axis_blocks *blocks, uint32_t *entry);
/* Leaves out what only the next update would use. */
void axis_blocks_trim(struct axis_blocks *blocks);
void axis_blocks_release(struct axis_blocks *blocks);

#endif
