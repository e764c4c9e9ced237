/* Axis lists of one view, that nothing is kept from. */
#ifndef TEST_REFERENCE_WALKS_H
#define TEST_REFERENCE_WALKS_H

#include "prepare/axis_lists.h"

static inline enum stp_result lists_of_view(const struct stp_env *env,
                                            const struct stp_scene *scene,
                                            const struct stp_camera *camera,
                                            enum stp_axis_merge merge, double h,
                                            struct axis_lists *lists)
{
    *lists = (struct axis_lists){ .merge = merge, .h = h };
    return axis_lists_update(env, scene, camera, lists);
}

#endif
