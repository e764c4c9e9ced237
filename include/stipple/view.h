/* Cameras. Right-handed; the camera looks down -Z with y up (OpenGL); angles are radians. */
#ifndef STIPPLE_VIEW_H
#define STIPPLE_VIEW_H

#include <stipple/result.h>
#include <stipple/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A pixel (px, py), y down, corner-based (the first pixel's centre is 0.5, 0.5), of the camera
 * point (X, Y, Z), Z < 0 in front:   px = cx + fx X / -Z,   py = cy - fy Y / -Z,
 * and for an orthographic camera     px = cx + fx X,        py = cy - fy Y. */
struct stp_camera {
    double world_to_camera[16]; /* row-major, rigid */
    bool orthographic;
    double fx, fy, cx, cy; /* pixels; per scene unit when orthographic */
    uint32_t width, height;
    double near_depth; /* eye depth > 0 (orthographic: any); nothing nearer is drawn */
    double far_depth;  /* INFINITY: none */
};

/* near_depth of a camera file that says no `near`, scene units: as good as nothing. */
#define STP_DEFAULT_NEAR 1e-6

/* How to frame a scene when no camera is given. */
struct stp_frame_params {
    /* Radians. 0, 0 looks at the front: the camera sits on +Z when up is y, on -Y when up is z, on
     * -Z when up is x (+Y to its right) or -y. A positive azimuth moves it to its right (counter-
     * clockwise seen from above), a positive elevation upwards; pi/2 looks straight down, with
     * the front below. left is azimuth -pi/2, top is elevation pi/2. */
    double azimuth, elevation;
    enum stp_up up; /* AUTO: the scene's */
    double fov_y;   /* radians; 0: 30 degrees */
    bool orthographic;
    uint32_t width, height; /* 0: 1280 x 720 */
};

/* The azimuth and elevation of `iso`, the default view. */
#define STP_ISO_AZIMUTH   0.61086523819801535 /* 35 degrees */
#define STP_ISO_ELEVATION 0.43633231299858238 /* 25 degrees */

/* The nearest camera from that direction that holds every splat (as a sphere of its radius;
 * outliers apart) with a 5 % margin: |ndc| <= 0.95. The eye moves in all three directions, so that
 * the scene touches both margins of the side that binds and is centred along the other. near_depth
 * is 1e-4 of the depth of the nearest splat, far_depth INFINITY. The scene must be prepared. NULL
 * params: iso, 30 degrees, 1280 x 720. */
STP_API enum stp_result stp_camera_frame(const struct stp_env *env, const struct stp_scene *scene,
                                         const struct stp_frame_params *params,
                                         struct stp_camera *camera);

/* Reads frame `index` of a camera file: an object, or an array of them (a path). Sizes of 0 keep
 * the file's; others win over it and scale its intrinsics. *count, if not NULL, gets the length
 * of the path. */
STP_API enum stp_result stp_camera_load(const struct stp_env *env, const char *path, uint32_t index,
                                        uint32_t width, uint32_t height, struct stp_camera *camera,
                                        uint32_t *count);
/* A camera that stp_camera_load reads back bit for bit. */
STP_API enum stp_result stp_camera_save(const struct stp_env *env, const char *path,
                                        const struct stp_camera *camera);

/* The camera that came with a scene .json; false, and *camera untouched, when there is none.
 * width and height as in stp_camera_load. */
STP_API bool stp_scene_camera(const struct stp_scene *scene, uint32_t width, uint32_t height,
                              struct stp_camera *camera);

#ifdef __cplusplus
}
#endif
#endif
