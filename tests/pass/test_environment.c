/* Surfaces that mirror an environment, and the environment behind them, against the reference. */
#include "group_device.h"
#include "surroundings.h"

#include "plan/offer.h"

static struct stp_scene *sheet(unsigned objects)
{
    struct stp_scene *scene = scene_sheet(objects, 5);
    scene_finish(scene);
    return scene;
}

/* Two sizes of error: what float32 leaves of a sharp map, and what a level's grid does. */
static const struct tolerance sharp = { 1e-3, 2e-4, 1e-3, 80, 0.05 };
static const struct tolerance rough = { 6e-3, 2e-4, 1e-3, 60, 0.05 };
static const struct tolerance packed = { 8e-3, 1e-2, 4e-3, 60, 0.05 };

static void every_way(struct stp_scene *scene, const struct stp_camera *camera,
                      struct stp_render_params params, const struct tolerance *tolerance,
                      const char *what)
{
    scene_own_groups(scene);
    for (int path = STP_PATH_RASTER; path <= STP_PATH_COMPUTE; path++) {
        params.path = (enum stp_path)path;
        params.method = STP_METHOD_TWO_PASS;
        expect_reference(&device, scene, camera, &params, tolerance, what);
        params.method = STP_METHOD_DEFERRED;
        params.payload = STP_PAYLOAD_ID;
        expect_reference(&device, scene, camera, &params, tolerance, what);
    }
    params.method = STP_METHOD_EXACT;
    expect_reference(&device, scene, camera, &params, &packed, what);
    params.payload = STP_PAYLOAD_PACKED;
    expect_reference(&device, scene, camera, &params, &packed, what);
    stp_scene_destroy(&scene);
}

static void test_sharp(void **state)
{
    const struct stp_render_params params = { .min_splat = -1 };
    const struct stp_environment_params around = { .rotation = 0.7, .intensity = 1.5f };
    for (int flat = 0; flat < 2; flat++) {
        struct stp_scene *scene = sheet(1);
        struct stp_camera camera = flat ? flat_camera(33, 33, 15) : plain_camera(33, 33, 30);
        look_at(&camera, v3(0.1, 0.2, flat ? 1 : 0), v3(0, 0, -2));
        set_optics(scene, 0, &(struct stp_optics){ .ior = { 1.3f, 1.5f, 2.4f } });
        surround(scene, 128, 64, smooth_sky, &around);
        if (!flat) {
            every_way(scene, &camera, params, &sharp, "a dielectric");
            continue;
        }
        expect_reference(&device, scene, &camera, &params, &packed, "a dielectric, orthographic");
        stp_scene_destroy(&scene);
    }
}

static void test_mirrors(void **state)
{
    const struct stp_render_params params = { .min_splat = -1, .environment_behind = true };
    struct stp_camera camera = plain_camera(33, 33, 30);
    struct stp_scene *scene = sheet(3);
    set_optics(scene, 0, &(struct stp_optics){ .reflectance = { 0.9f, 0.6f, 0.2f } });
    set_optics(scene, 1,
               &(struct stp_optics){ .reflectance = { 0.5f, 0.5f, 0.5f }, .roughness = 0.4f });
    set_optics(scene, 2, &(struct stp_optics){ .ior = { 1, 1, 1 } });
    surround(scene, 32, 16, smooth_sky, NULL);
    every_way(scene, &camera, params, &rough, "mirrors, sharp, rough and none");
}

/* Where rough light is mirrored auto looks it up as the device does, and what levels are off it
 * adds. */
static void test_estimate(void **state)
{
    static const struct probe_sample every = { .cells = 100000, .alone = true };
    const struct stp_render_params params = { .min_splat = -1, .method = STP_METHOD_TWO_PASS };
    struct stp_camera camera = plain_camera(33, 33, 30);
    struct stp_scene *scene = sheet(1);
    struct stp_plan *plan = NULL;
    struct stp_image *truth = NULL;
    struct stp_comparison comparison;
    struct survey survey;
    struct probe probe;
    struct probe_error error;
    set_optics(scene, 0,
               &(struct stp_optics){ .reflectance = { 0.9f, 0.9f, 0.9f }, .roughness = 0.4f });
    surround(scene, 128, 64, smooth_sky, NULL);
    assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
    struct stp_image *image = device_render_plan(&device, scene, plan);
    assert_int_equal(reference_render(&device.env, scene, &camera, &params, &truth), STP_OK);
    assert_int_equal(stp_compare(&device.env, image, truth, NULL, &comparison), STP_OK);
    assert_int_equal(survey_make(NULL, scene, &camera, &params, &survey), STP_OK);
    assert_int_equal(probe_make(NULL, scene, &camera, &params, &survey, &every, &probe), STP_OK);
    assert_int_equal(plan_judge(NULL, &probe, plan, NULL, false, &error), STP_OK);
    double levels = probe_levels_error(&device.env, &probe.view);
    double actual = comparison.covered.mean_absolute,
           rounded = error.rounding + plan_rounding(plan);
    assert_true(levels > 0 && levels < 5e-3);
    assert_true(error.mean < 1e-6 && actual > error.mean + rounded); /* the levels show */
    assert_true(actual <= error.mean + rounded + levels);
    probe_release(&probe);
    survey_release(&survey);
    stp_image_destroy(&image);
    stp_image_destroy(&truth);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
}

/* 1e4 in a picture: relative to the larger of 1 and the channel. */
static void test_lamp(void **state)
{
    const struct stp_render_params params = { .min_splat = -1, .environment_behind = true };
    const struct tolerance bright = { 2e-3, 1e-3, 1e-3, 80, 0.2 };
    struct stp_camera camera = plain_camera(33, 33, 30);
    struct stp_scene *scene = sheet(1);
    set_optics(scene, 0, &(struct stp_optics){ .reflectance = { 0.9f, 0.9f, 0.9f } });
    surround(scene, 256, 128, lamp_sky, NULL);
    expect_reference(&device, scene, &camera, &params, &bright, "a lamp of 1e4");
    stp_scene_destroy(&scene);
}

/* The whole sphere of directions: both poles, the seam, every turn of the camera, no splat near. */
static void test_all_around(void **state)
{
    const struct stp_render_params params = { .min_splat = -1, .environment_behind = true };
    const struct vec3 at[] = {
        { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { -1, 0, 0.01 }, { 1, 0.2, 0 }
    };
    const struct tolerance tight = { 1e-5, 0, 0, 90, 0 };
    for (int i = 0; i < 5; i++) {
        struct stp_scene *scene = scene_make(1, 1, 0.1);
        struct stp_camera camera = plain_camera(40, 40, 10);
        scene_add(scene, v3_scale(at[i], -5), at[i], 0.1);
        scene_finish(scene);
        scene->facts.up = (enum stp_up)(STP_UP_X + i % 4);
        surround(scene, 16, 8, smooth_sky, NULL);
        look_at(&camera, v3(0, 0, 0), at[i]);
        expect_reference(&device, scene, &camera, &params, &tight, "all around");
        stp_scene_destroy(&scene);
    }
}

static void test_samples(void **state)
{
    const struct stp_render_params params = { .min_splat = -1,
                                              .environment_behind = true,
                                              .samples = 9 };
    struct stp_camera camera = plain_camera(33, 33, 30);
    struct stp_scene *scene = sheet(1);
    set_optics(scene, 0, &(struct stp_optics){ .reflectance = { 0.9f, 0.9f, 0.9f } });
    surround(scene, 64, 32, smooth_sky, NULL);
    expect_reference(&device, scene, &camera, &params, &packed, "nine samples");
    stp_scene_destroy(&scene);
}

/* More roughnesses than levels: mixed levels stay near what the lobe itself would be. */
static void test_between_levels(void **state)
{
    const struct stp_render_params params = { .min_splat = -1 };
    const struct tolerance mixed = { 0.03, 2e-2, 4e-3, 40, 0.1 };
    struct stp_camera camera = plain_camera(33, 33, 30);
    struct stp_scene *scene = sheet(8);
    scene->objects = realloc(scene->objects, 20 * sizeof *scene->objects);
    assert_non_null(scene->objects);
    for (unsigned i = 0; i < 20; i++) {
        scene->objects[i] = scene->objects[i % 8];
        set_optics(scene, i,
                   &(struct stp_optics){ .reflectance = { 0.9f, 0.9f, 0.9f },
                                         .roughness = 0.2f + 0.035f * (float)i });
    }
    scene->object_count = 20;
    surround(scene, 64, 32, smooth_sky, NULL);
    scene->object_count = 8;
    assert_true(scene->facts.between_levels);
    expect_reference(&device, scene, &camera, &params, &mixed, "between levels");
    stp_scene_destroy(&scene);
}

/* The same bits in tiles as in one piece. */
static void test_tiles(void **state)
{
    struct stp_render_params params = { .min_splat = -1, .environment_behind = true };
    struct stp_camera camera = plain_camera(70, 50, 40);
    struct stp_scene *scene = sheet(1);
    surround(scene, 64, 32, smooth_sky, NULL);
    struct stp_image *whole = device_render(&device, scene, &camera, &params);
    params.memory_limit = 1 << 20;
    struct stp_image *tiles = device_render(&device, scene, &camera, &params);
    expect_same_bits(whole, tiles, "an environment in tiles");
    stp_image_destroy(&whole);
    stp_image_destroy(&tiles);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sharp),          cmocka_unit_test(test_mirrors),
        cmocka_unit_test(test_estimate),       cmocka_unit_test(test_lamp),
        cmocka_unit_test(test_all_around),     cmocka_unit_test(test_samples),
        cmocka_unit_test(test_between_levels), cmocka_unit_test(test_tiles),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
