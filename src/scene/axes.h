/* The axes of a scene by what is up: the front looks along -forward, right = forward x up.
 *   up y:  right +x, up +y, towards the viewer of the front +z
 *   up z:  right +x, up +z, towards the viewer -y
 *   up x:  right +y, up +x, towards the viewer -z   (a right-handed turn of the first)
 *   up -y: right +x, up -y, towards the viewer -z   (an RGB-D camera, seen as it saw) */
#ifndef STP_SCENE_AXES_H
#define STP_SCENE_AXES_H

#include <stipple/scene.h>

#include "base/vec.h"

struct scene_axes {
    struct vec3 right, up, viewer; /* right-handed: viewer = right x up */
};

static inline struct scene_axes scene_axes(enum stp_up up)
{
    switch (up) {
    case STP_UP_X:
        return (struct scene_axes){ { 0, 1, 0 }, { 1, 0, 0 }, { 0, 0, -1 } };
    case STP_UP_Z:
        return (struct scene_axes){ { 1, 0, 0 }, { 0, 0, 1 }, { 0, -1, 0 } };
    case STP_UP_NEG_Y:
        return (struct scene_axes){ { 1, 0, 0 }, { 0, -1, 0 }, { 0, 0, -1 } };
    default:
        return (struct scene_axes){ { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    }
}

#endif
