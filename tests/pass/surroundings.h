/* Environments for tests of shading: analytic maps, and scenes whose optics are set by hand. */
#ifndef TEST_SURROUNDINGS_H
#define TEST_SURROUNDINGS_H

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "scene/optics.h"

/* The light from a direction of the map's frame: right of its centre, up, its centre. */
typedef struct vec3 (*sky_fn)(struct vec3 d);

static inline struct vec3 smooth_sky(struct vec3 d)
{
    return v3(1 + 0.6 * d.x + 0.2 * d.y * d.z, 0.8 + 0.5 * d.y * d.y, 0.7 - 0.4 * d.z + 0.2 * d.x);
}

/* A lamp of 1e4 ahead and to the right, on a dim sky. */
static inline struct vec3 lamp_sky(struct vec3 d)
{
    double lamp = exp(60 * (0.5 * d.x + 0.3 * d.y + 0.8124 * d.z - 1));
    return v3(0.1 + 1e4 * lamp, 0.2 + 8e3 * lamp, 0.4 + 5e3 * lamp);
}

static inline void surround(struct stp_scene *scene, uint32_t width, uint32_t height, sky_fn sky,
                            const struct stp_environment_params *params)
{
    const double pi = 3.14159265358979323846;
    float(*texel)[3] = malloc((size_t)width * height * sizeof *texel);
    assert_non_null(texel);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            double longitude = ((x + 0.5) / width * 2 - 1) * pi, polar = (y + 0.5) / height * pi;
            struct vec3 c =
                sky(v3(sin(polar) * sin(longitude), cos(polar), sin(polar) * cos(longitude)));
            float *t = texel[(size_t)y * width + x];
            t[0] = (float)c.x;
            t[1] = (float)c.y;
            t[2] = (float)c.z;
        }
    assert_int_equal(
        stp_scene_set_environment(NULL, scene, width, height, (const float(*)[3])texel, params),
        STP_OK);
    free(texel);
}

/* Before the environment is set. */
static inline void set_optics(struct stp_scene *scene, unsigned object,
                              const struct stp_optics *optics)
{
    assert_int_equal(optics_check(NULL, optics), STP_OK);
    scene->objects[object].optics = optics_resolve(optics);
}

#endif
