/* HM 5: the lists of a view. Which walks its rays ask for, and, of each, the kernels that it draws,
 * from the farthest to the nearest. All in double, so that counts are exact. */
#ifndef STP_PREPARE_AXIS_LISTS_H
#define STP_PREPARE_AXIS_LISTS_H

#include <stipple/plan.h>

#include "base/vec.h"
#include "scene/scene.h"
#include "scene/volume.h"

#define AXIS_WALKS 6 /* three axes, both ways */

/* Clip: rays whose two largest components differ by less take either list. */
#define AXIS_CLIP_MARGIN (1.0 / 1048576)

/* Rays go along +axis, or along -axis where backwards. */
struct axis_walk {
    uint8_t axis;
    bool backwards;
    uint32_t first, count; /* of axis_lists.order */
};

/* Kernels by their sheets across an axis: the same for every view, made when one first asks.
 * Ellipsoids and surface splats are one sheet, ascending along the axis. */
struct axis_sheets {
    uint32_t *first;  /* of each sheet, and the end; NULL: nobody has asked yet */
    uint32_t *kernel; /* ascending within a sheet; NULL: the kernels' own order, as across z */
};

/* Pixels whose centres lie within a kernel's box, all included. */
struct axis_span {
    uint16_t x0, x1, y0, y1;
};

/* How surface splats are looked at: back faces left out, and the least diameter in pixels. */
struct axis_look {
    bool cull_back;
    double floor; /* 0: none */
};

struct axis_lists {
    enum stp_axis_merge merge;
    double h;
    struct axis_look look;
    unsigned walk_count;
    struct axis_walk walk[AXIS_WALKS];
    uint32_t *order; /* kernels of all walks, one walk after the other, each far to near */
    size_t count;
    size_t visible; /* kernels in any list */
    /* What the next view takes over: of each kernel the walks that draw it, by axis_walk_bit, and,
     * where there are any, its pixels; of each block of pixels the walks with a weight in it. */
    uint8_t *mask;
    struct axis_span *span;
    size_t masks[1 << AXIS_WALKS]; /* kernels of each mask */
    uint32_t blocks_x, blocks_y;
    uint8_t *open;
    size_t room; /* of order */
    struct axis_sheets sheets[3];
};

/* Blocks of pixels: what a list is cut into, and what is asked at once of the walks' regions. */
#define AXIS_BLOCK_WIDTH  4
#define AXIS_BLOCK_HEIGHT 4

/* The lists of a view. A kernel is in a walk's list when it has a fragment at a pixel on which the
 * walk has a weight (HM 5.2); lists without kernels are left out. Of merge single there is one walk
 * along the axis nearest to the view's; of sort one list, by distance from the eye (orthographic:
 * by depth). Begin with lists that are 0 but for merge and h, which is in [0, 1); from then on a
 * changed camera is all they take: what does not depend on the view, and memory, are kept. On
 * failure they are empty. Release with axis_lists_release. */
enum stp_result axis_lists_update(const struct stp_env *env, const struct stp_scene *scene,
                                  const struct stp_camera *camera, struct axis_lists *lists);
void axis_lists_release(struct axis_lists *lists);

/* Walks by their bits in axis_lists.mask and .open. */
static inline unsigned axis_walk_bit(const struct axis_walk *walk)
{
    return 2u * walk->axis + walk->backwards;
}

/* axis_sift.c: mask, masks, span and open of a view; lists->room and the rest stay. */
enum stp_result axis_sift(const struct stp_env *env, const struct stp_scene *scene,
                          const struct stp_camera *camera, struct axis_lists *lists);
unsigned axis_dominant(struct vec3 v); /* the first of equal ones */

#endif
