/* Cameras in JSON: camera files, and the camera of a scene .json (docs/scene.md). */
#ifndef STP_SCENE_CAMERA_JSON_H
#define STP_SCENE_CAMERA_JSON_H

#include <stipple/view.h>

#include "base/json.h"

struct camera_json {
    struct stp_camera camera; /* at the file's size, or at 1280 x 720 */
    bool sized;               /* the file said width and height */
    bool intrinsics;          /* a new size scales both axes; else the field of view stays */
};

enum stp_result camera_from_json(const struct json_at *at, const cJSON *object,
                                 struct camera_json *camera);

/* fx = fy, in pixels, of fov_y_deg or, orthographic, of ortho_height. */
double camera_focal(bool orthographic, double lens, uint32_t height);

/* To another size; 0 keeps that side. Intrinsics scale with their own side. Otherwise fy and fx
 * scale with the height and the centre stays the picture's. */
void camera_resize(struct stp_camera *camera, bool intrinsics, uint32_t width, uint32_t height);

#endif
