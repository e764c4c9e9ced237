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

struct axis_lists {
    enum stp_axis_merge merge;
    double h;
    unsigned walk_count;
    struct axis_walk walk[AXIS_WALKS];
    uint32_t *order; /* kernels of all walks, one walk after the other, each far to near */
    size_t count;
    size_t visible; /* kernels in any list */
};

/* The weight of a walk on a ray of world direction v (HM 5.2): (v_axis / max - h) / (1 - h), or 0.
 * Clip: 1 where it is the dominant one, the first of equal ones. */
double axis_weight(const struct axis_lists *lists, const struct axis_walk *walk, struct vec3 v);

/* h is in [0, 1). A kernel is in a walk's list when it has a
 * fragment at a pixel on which the walk has a weight; lists without kernels are left out. single:
 * one walk along the axis nearest to the view's; sort: one list, by distance from the eye
 * (orthographic: by depth). Release with axis_lists_release. */
enum stp_result axis_lists_build(const struct stp_env *env, const struct stp_scene *scene,
                                 const struct stp_camera *camera, enum stp_axis_merge merge,
                                 double h, struct axis_lists *lists);
void axis_lists_release(struct axis_lists *lists);

#endif
