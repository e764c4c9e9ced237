/* Sizes, extents and depths at their limits, by every method and path against the reference. */
#include "group_device.h"

static const struct stp_render_params floor_off = { .min_splat = -1 };

static void test_sizes(void **state)
{
    static const uint32_t sizes[][2] = { { 1, 1 }, { 1, 37 }, { 41, 1 }, { 8, 8 }, { 63, 65 } };
    struct stp_scene *scene = scene_random(11, 60, 0.05);
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        char what[32];
        struct stp_camera camera = hard_view(0, sizes[i][0], sizes[i][1]);
        camera.cx = camera.width / 2.0;
        camera.cy = camera.height / 2.0;
        snprintf(what, sizeof what, "%u x %u", camera.width, camera.height);
        expect_everywhere(&device, scene, &camera, &floor_off, what);
    }
    stp_scene_destroy(&scene);
}

/* Boxes of 31 to 33 pixels a side: on both sides of STP_LARGE_AREA. And far beyond the picture. */
static void test_large_splats(void **state)
{
    static const double radii[] = { 15.9, 16.4, 40, 1e6 }; /* pixels */
    for (unsigned i = 0; i < sizeof radii / sizeof *radii; i++) {
        struct stp_scene *scene = scene_make(3, 1, 0.1);
        struct stp_camera camera = plain_camera(50, 47, 40);
        scene_add(scene, v3(0.1, 0, -2), v3(0.1, 0.2, 1), radii[i] * 2 / 40);
        scene_add(scene, v3(-0.3, 0.1, -2.05), v3(0, 0, 1), radii[i] * 2 / 40);
        scene_add(scene, v3(0.3, -0.1, -1.5), v3(0.3, 0, 1), 0.1);
        scene_finish(scene);
        scene_own_groups(scene);
        expect_everywhere(&device, scene, &camera, &floor_off, "large splats");
        stp_scene_destroy(&scene);
    }
}

/* The ground below the eye: from the near plane to the horizon. */
static void test_ground(void **state)
{
    for (int near = 0; near < 3; near++) {
        struct stp_scene *scene = scene_make(3, 1, 0.5);
        struct stp_camera camera = plain_camera(48, 48, 20);
        camera.near_depth = near == 0 ? 1e-6 : near == 1 ? 0.1 : 2.9;
        scene_add(scene, v3(0, -1, -1), v3(0, 1, 0), 1e4);
        scene_add(scene, v3(0.5, 2, 0.5), v3(0, -1, 0.02), 50);
        scene_add(scene, v3(1.5, 0, -0.001), v3(1, 0.3, 0.1), 2);
        scene_finish(scene);
        scene_own_groups(scene);
        expect_everywhere(&device, scene, &camera, &floor_off, "ground and ceiling");
        stp_scene_destroy(&scene);
    }
}

/* Behind the eye, beside the picture, before near, beyond far, edge-on, seen from behind. */
static void test_nothing_to_see(void **state)
{
    struct stp_scene *scene = scene_make(6, 1, 0.1);
    struct stp_camera camera = plain_camera(16, 16, 16);
    struct stp_render_params p = { .min_splat = -1, .cull = STP_CULL_BACK };
    camera.near_depth = 1;
    camera.far_depth = 5;
    scene_add(scene, v3(0, 0, 2), v3(0, 0, 1), 0.5);
    scene_add(scene, v3(9, 0, -2), v3(0, 0, 1), 0.5);
    scene_add(scene, v3(0, 0, -0.9), v3(0, 0, 1), 0.5);
    scene_add(scene, v3(0, 0, -5.1), v3(0, 0, 1), 0.5);
    scene_add(scene, v3(0, 0, -2), v3(1, 0, 0), 0.5);
    scene_add(scene, v3(0, 0, -2), v3(0, 0, -1), 0.5);
    scene_finish(scene);
    scene_own_groups(scene);
    expect_everywhere(&device, scene, &camera, &p, "nothing to see");
    struct stp_image *image = device_render(&device, scene, &camera, &p);
    for (unsigned i = 0; i < 16 * 16; i++) {
        assert_true(stp_image_find(image, "A")->data.f[i] == 0);
        assert_true(stp_image_find(image, "Z")->data.f[i] == INFINITY);
    }
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

/* A wall before a wall: merged when the gap is below epsilon, hidden when above. */
static void test_two_sheets(void **state)
{
    static const double gaps[] = { 0.5, 0.98, 1.02, 3 };
    for (unsigned g = 0; g < sizeof gaps / sizeof *gaps; g++)
        for (int flat = 0; flat < 2; flat++) {
            struct stp_scene *scene = scene_make(18, 1, 0.1);
            struct stp_camera camera = flat ? flat_camera(40, 40, 20) : plain_camera(40, 40, 40);
            for (int i = 0; i < 18; i++) {
                double x = i % 3 * 0.6 - 0.6, y = i / 3 % 3 * 0.6 - 0.6;
                double z = i < 9 ? -2 : -2 - gaps[g] * 0.1;
                size_t at = scene_add(scene, v3(x, y, z), v3(0, 0, 1), 0.5);
                scene_paint(scene, at, i < 9, 0.5f, i >= 9);
            }
            scene_finish(scene);
            expect_everywhere(&device, scene, &camera, &floor_off, "two sheets");
            stp_scene_destroy(&scene);
        }
}

/* Splats of far less than a pixel: nothing lost with the floor, at 1.5 and at 4 pixels. */
static void test_tiny_splats(void **state)
{
    static const double floors[] = { 0, 4, -1 };
    struct stp_scene *scene = scene_make(400, 1, 0.01);
    struct stp_camera camera = plain_camera(32, 32, 64);
    uint32_t seed = 5;
    for (int i = 0; i < 400; i++) {
        struct vec3 p = random_point(&seed, 1);
        scene_add(scene, v3_add(p, v3(0, 0, -4)), random_point(&seed, 1),
                  pow(10, -4 + 3 * uniform(&seed)));
    }
    scene_finish(scene);
    for (int i = 0; i < 3; i++) {
        struct stp_render_params p = { .min_splat = floors[i], .cull = STP_CULL_BACK };
        expect_everywhere(&device, scene, &camera, &p, "tiny splats");
    }
    stp_scene_destroy(&scene);
}

/* Edge-on discs that the floor keeps: up to 2800 pixels long and 1.5 or 8 thin. One tip of each
 * lies in the picture, where the squares of its form differ by eight decimals. */
static void test_long_floored_splats(void **state)
{
    static const double radii[] = { 0.3, 1, 2 }, floors[] = { 1.5, 8 };
    struct stp_camera camera = plain_camera(64, 56, 1400);
    uint32_t seed = 77;
    for (int i = 0; i < 6; i++) {
        struct stp_scene *scene = scene_make(24, 1, 0.05);
        struct stp_render_params p = { .min_splat = floors[i % 2] };
        for (int k = 0; k < 24; k++) {
            double turn = k * M_PI / 12, r = radii[i / 2], tilt = 1e-8 * uniform(&seed);
            struct vec3 u = v3(cos(turn), sin(turn), 0), tip = random_point(&seed, 0.035);
            struct vec3 c = v3_sub(v3(tip.x, tip.y, -2 - 0.1 * k), v3_scale(u, r));
            struct vec3 n = v3_unit(v3_cross(u, c));
            scene_add(scene, c, v3_sub(n, v3_scale(v3_unit(c), tilt)), r);
        }
        scene_finish(scene);
        scene_own_groups(scene);
        expect_everywhere(&device, scene, &camera, &p, "long floored splats");
        stp_scene_destroy(&scene);
    }
}

/* 2048 x 2048 is the largest tile, and one splat covers it whole: 65536 blocks. */
static void test_a_splat_over_the_largest_tile(void **state)
{
    struct stp_scene *scene = scene_make(1, 1, 0.1);
    struct stp_camera camera = plain_camera(2048, 2048, 2048);
    struct stp_render_params p = { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE };
    scene_add(scene, v3(0, 0, -1), v3(0, 0, 1), 4);
    scene_finish(scene);
    struct stp_image *image = device_render(&device, scene, &camera, &p);
    const float *z = stp_image_find(image, "Z")->data.f;
    size_t covered = 0;
    for (size_t i = 0; i < 2048 * 2048; i++)
        covered += z[i] == 1;
    assert_int_equal(covered, 2048 * 2048);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_large_splats),
        cmocka_unit_test(test_ground),
        cmocka_unit_test(test_nothing_to_see),
        cmocka_unit_test(test_two_sheets),
        cmocka_unit_test(test_tiny_splats),
        cmocka_unit_test(test_long_floored_splats),
        cmocka_unit_test(test_a_splat_over_the_largest_tile),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
