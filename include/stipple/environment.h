/* What is around a scene, and how its surfaces mirror and bend it (docs/glass.md). */
#ifndef STIPPLE_ENVIRONMENT_H
#define STIPPLE_ENVIRONMENT_H

#include <stipple/result.h>

#ifdef __cplusplus
extern "C" {
#endif

struct stp_scene;

/* How a surface meets the environment's light; a scene without an environment has no use for it.
 * Three numbers are of red, green and blue. Every field: 0 is not set and means the default,
 * a negative number means 0. */
struct stp_optics {
    float ior[3];         /* inside over outside, 0.05 to 20; default 1.5. 1: no interface */
    float reflectance[3]; /* of a mirror, face on, [0, 1] (Schlick); where one of the three is above
                             0 they take the place of what a dielectric of `ior` reflects */
    float roughness;      /* [0, 1]; default 0, sharp */
    float absorption[3];  /* transparent: a layer of thickness t lets exp(-absorption t) pass */
    float thickness;      /* of a layer; default 1 */
};

struct stp_environment_params {
    double rotation; /* radians about the scene's up, counter-clockwise seen from above */
    float intensity; /* multiplies; 0: 1 */
};

/* A latitude-longitude map: OpenEXR (any compression; scanlines or tiles) or Radiance .hdr. Its top
 * is the scene's up; its centre is where `--view front` looks, and what is right of the centre is
 * on that view's right. Before or after stp_scene_prepare; it takes the place of an earlier one. */
STP_API enum stp_result stp_scene_load_environment(const struct stp_env *env,
                                                   struct stp_scene *scene, const char *path,
                                                   const struct stp_environment_params *params);
/* The same from memory, linear, rows from the top; borrowed for the call only. texel NULL: takes
 * the environment away. */
STP_API enum stp_result stp_scene_set_environment(const struct stp_env *env,
                                                  struct stp_scene *scene, uint32_t width,
                                                  uint32_t height, const float (*texel)[3],
                                                  const struct stp_environment_params *params);

#ifdef __cplusplus
}
#endif
#endif
