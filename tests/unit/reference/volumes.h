/* Volumes made in code, prepared, for the tests of media. */
#ifndef TEST_REFERENCE_VOLUMES_H
#define TEST_REFERENCE_VOLUMES_H

#include "fixture.h"
#include "prepare/volume.h"
#include "reference/volume.h"

/* A scene of the values, with the transfer function's text; unshaded. */
static inline struct stp_scene *volume_scene(const struct stp_volume *volume,
                                             const struct transfer_function *function)
{
    struct stp_scene *scene = NULL;
    struct stp_env env = { .threads = 2 };
    struct stp_volume_params params = { .transfer_function = "grey", .unshaded = true };
    assert_int_equal(stp_scene_create(&env, &scene), STP_OK);
    assert_int_equal(stp_scene_set_volume(&env, scene, volume, &params), STP_OK);
    scene->volume->transfer = *function;
    assert_int_equal(stp_scene_prepare(&env, scene, NULL), STP_OK);
    return scene;
}

/* Opacity `opacity` and one colour for every value. */
static inline struct transfer_function constant_function(double opacity)
{
    return (struct transfer_function){
        .name = "constant",
        .count = 1,
        .point = { { 0, { 1, 0.5f, 0.25f }, (float)opacity } },
    };
}

/* Every voxel 1, centred on 0. */
static inline struct stp_scene *block_scene(const uint32_t dims[3], const double spacing[3],
                                            double opacity)
{
    size_t count = (size_t)dims[0] * dims[1] * dims[2];
    float *value = malloc(count * sizeof *value);
    struct stp_volume volume = { .value = value };
    assert_non_null(value);
    for (size_t i = 0; i < count; i++)
        value[i] = 1;
    for (int axis = 0; axis < 3; axis++) {
        volume.dims[axis] = dims[axis];
        volume.spacing[axis] = spacing[axis];
        volume.origin[axis] = -0.5 * (dims[axis] - 1) * spacing[axis];
    }
    struct transfer_function function = constant_function(opacity);
    struct stp_scene *scene = volume_scene(&volume, &function);
    free(value);
    return scene;
}

/* A grid of the dims about `middle`, of random values from 0 to 1; of many voxels three in ten are
 * empty. */
static inline struct stp_scene *random_volume_scene(uint32_t seed, const uint32_t dims[3],
                                                    const double spacing[3], const double middle[3],
                                                    const struct transfer_function *function)
{
    size_t count = (size_t)dims[0] * dims[1] * dims[2];
    float *value = malloc(count * sizeof *value);
    struct stp_volume volume = { .value = value };
    assert_non_null(value);
    for (size_t i = 0; i < count; i++)
        value[i] = count > 64 && uniform(&seed) < 0.3 ? NAN : (float)uniform(&seed);
    for (int axis = 0; axis < 3; axis++) {
        volume.dims[axis] = dims[axis];
        volume.spacing[axis] = spacing[axis];
        volume.origin[axis] = middle[axis] - 0.5 * (dims[axis] - 1) * spacing[axis];
    }
    struct stp_scene *scene = volume_scene(&volume, function);
    free(value);
    return scene;
}

static inline struct stp_image *render_volume(const struct stp_scene *scene,
                                              const struct stp_camera *camera,
                                              const struct stp_render_params *params)
{
    struct stp_env env = { .threads = 2 };
    struct stp_image *image = NULL;
    assert_int_equal(reference_render(&env, scene, camera, params, &image), STP_OK);
    return image;
}

#endif
