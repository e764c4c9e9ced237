/* The camera in OpenEXR's own convention (docs/exr.md). */
#ifndef STP_WRITE_EXR_CAMERA_H
#define STP_WRITE_EXR_CAMERA_H

#include <stipple/view.h>

/* Left-handed (+X right, +Y up, +Z forward), for row vectors: p' = p M, m[4 * row + column].
 * Both take positions relative to `origin`. */
void exr_world_to_camera(const struct stp_camera *camera, const double origin[3], double m[16]);

/* To x and y in [0, 1] over the picture, y down, after the division by w. The third coordinate is
 * 0 at the near and 1 at the far plane; towards 1 when far is infinite (for an orthographic
 * camera with an infinite far plane: the depth beyond near). */
void exr_world_to_ndc(const struct stp_camera *camera, const double origin[3], double m[16]);

/* The window at depth 1: its width, its centre, and the pixel's width over its height. */
struct exr_screen {
    double width, center[2], pixel_aspect;
};
struct exr_screen exr_screen_window(const struct stp_camera *camera);

#endif
