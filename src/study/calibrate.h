/* Prices of the device: synthetic scenes, timed under every kind of plan, and fitted. */
#ifndef STP_STUDY_CALIBRATE_H
#define STP_STUDY_CALIBRATE_H

#include <stipple/render.h>

#include "plan/offer.h"

/* Spheres of discs, one inside the other. */
struct calibrate_scene {
    unsigned splats, size; /* pixels a side */
    double radius;         /* of a splat, pixels */
    double fill;           /* share of the picture's side that the largest sphere spans */
    unsigned shells;
    double overlap; /* of the groups; 0: none are made */
    bool color;     /* after those without: only what these have not measured is */
    double opacity; /* 0: opaque */
};
extern const struct calibrate_scene calibrate_scenes[];
extern const unsigned calibrate_scene_count;

/* Prepared and grouped, with the camera that sees it as said. */
enum stp_result calibrate_scene_make(const struct stp_env *env, const struct calibrate_scene *what,
                                     struct stp_scene **scene, struct stp_camera *camera);

/* Measures on these scenes: about a minute for all of them. */
enum stp_result calibrate_measure(const struct stp_env *env, struct stp_context *context,
                                  const struct calibrate_scene *scenes, unsigned count,
                                  struct stp_calibration *calibration);

/* cache.c: the file for this device, driver and version; to be freed with mem_free. NULL, with
 * STP_OK, where the user has no place for caches. */
enum stp_result calibrate_cache_path(const struct stp_env *env, const struct stp_limits *limits,
                                     char **path);
/* STP_OK and *found false: there is none. A file that is damaged, or of another device, is named
 * in one line and counts as none. */
enum stp_result calibrate_cache_read(const struct stp_env *env, const char *path,
                                     const struct stp_limits *limits,
                                     struct stp_calibration *calibration, bool *found);
/* Makes the folders. A failure is a warning: only time is lost. */
void calibrate_cache_write(const struct stp_env *env, const char *path,
                           const struct stp_limits *limits);

#endif
