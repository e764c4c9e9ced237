/* Glass on a device: what transparent layers mirror, bend and absorb, against the reference. */
#include "group_device.h"
#include "surroundings.h"

/* The sky is smooth: what a normal is off, colours are off by as much. */
static const struct tolerance tolerance = { 2e-2, 2e-2, 8e-3, 60, 0.08 };

static const struct stp_optics kinds[] = {
    { .ior = { 1.3f, 1.5f, 1.8f }, .absorption = { 0.2f, 0.5f, 1 }, .thickness = 0.5f },
    { .ior = { 0.7f, 0.8f, 0.9f } }, /* total reflection */
    { .reflectance = { 0.5f, 0.2f, 0.1f }, .roughness = 0.6f },
    { .ior = { 1, 1, 1 } }, /* no interface: as without an environment */
};

/* Overlapping sheets of one ball of splats, in two objects; every seventh opaque when mixed. */
static struct stp_scene *ball(size_t count, float opacity, bool mixed, const struct stp_optics *a,
                              const struct stp_optics *b)
{
    struct stp_scene *scene = scene_make(count, 2, 0.05);
    for (size_t i = 0; i < count; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)count, angle = (double)i * 2.39996322972865332;
        struct vec3 n = v3(sqrt(1 - z * z) * cos(angle), sqrt(1 - z * z) * sin(angle), z);
        size_t at = scene_add(scene, v3_add(v3_scale(n, i % 2 ? 1 : 0.6), v3(0, 0, -3)), n, 0.3);
        scene_assign(scene, at, (unsigned)i % 2);
        scene_fade(scene, at, mixed && i % 7 == 0 ? 1 : opacity);
    }
    scene_finish(scene);
    set_optics(scene, 0, a);
    set_optics(scene, 1, b);
    surround(scene, 64, 32, smooth_sky, NULL);
    return scene;
}

static void expect_glass(struct stp_scene *scene, struct stp_render_params params, const char *what)
{
    struct stp_camera camera = plain_camera(33, 33, 42);
    params.transparency = STP_TRANSPARENCY_EXACT;
    params.min_splat = -1;
    expect_reference(&device, scene, &camera, &params, &tolerance, what);
    stp_scene_destroy(&scene);
}

static void test_layers(void **state)
{
    const struct stp_render_params multi = { .aovs = STP_AOV_LAYERS };
    const struct stp_render_params single = { .layers = STP_LAYERS_SINGLE };
    expect_glass(ball(120, 0.2f, false, &kinds[0], &kinds[1]), multi, "multi");
    expect_glass(ball(120, 0.2f, false, &kinds[0], &kinds[1]), single, "single");
}

static void test_mixed(void **state)
{
    const float backdrop[4] = { 1e4f, 0, 10, 1 };
    const struct stp_render_params params = { .background = backdrop };
    const struct stp_render_params around = { .environment_behind = true };
    expect_glass(ball(120, 0.4f, true, &kinds[2], &kinds[3]), params, "mixed, before 1e4");
    expect_glass(ball(120, 1e-6f, true, &kinds[0], &kinds[3]), around, "clear, among opaque ones");
}

/* More fragments than slots, and more layers than anybody counts. */
static void test_many(void **state)
{
    const struct stp_optics *o = &kinds[0];
    struct stp_scene *scene = scene_make(300, 1, 1e-3);
    for (int i = 0; i < 300; i++) {
        size_t at = scene_add(scene, v3(0, 0, -2 - 0.01 * i), v3(0.3, 0.1, 1), 1.5);
        scene_fade(scene, at, 0.01f);
    }
    scene_finish(scene);
    set_optics(scene, 0,
               &(struct stp_optics){ .ior = { 1.01f, 1.02f, 0.99f },
                                     .absorption = { 0.01f, 0, 0.02f },
                                     .thickness = o->thickness });
    surround(scene, 64, 32, smooth_sky, NULL);
    expect_glass(scene, (struct stp_render_params){ .aovs = STP_AOV_LAYERS }, "300 layers");
}

/* The eye within a closed surface whose normals face away from it. */
static void test_inside(void **state)
{
    struct stp_scene *scene = ball(200, 0.3f, false, &kinds[0], &kinds[1]);
    struct stp_camera camera = plain_camera(33, 33, 16);
    struct stp_render_params params = { .min_splat = -1 };
    look_at(&camera, v3(0.1, 0.2, -3), v3(1, 0.3, -3.5));
    expect_reference(&device, scene, &camera, &params, &tolerance, "from inside");
    stp_scene_destroy(&scene);
}

/* Glass shows the environment, so that no background does; where nothing is the picture is open. */
static void test_alpha(void **state)
{
    const float white[4] = { 1, 1, 1, 1 };
    struct stp_scene *scene = ball(200, 0.1f, false, &kinds[0], &kinds[0]);
    struct stp_camera camera = plain_camera(33, 33, 30);
    struct stp_render_params params = { .min_splat = -1 };
    struct stp_image *over_none = device_render(&device, scene, &camera, &params);
    params.background = white;
    struct stp_image *over_white = device_render(&device, scene, &camera, &params);
    unsigned covered = 0;
    for (size_t i = 0; i < 33 * 33; i++) {
        float a = stp_image_find(over_none, "A")->data.f[i];
        assert_true(a == 0 || a == 1);
        assert_true(stp_image_find(over_white, "R")->data.f[i] ==
                    (a == 1 ? stp_image_find(over_none, "R")->data.f[i] : 1));
        covered += a == 1;
    }
    assert_true(covered > 300 && covered < 33 * 33);
    stp_image_destroy(&over_none);
    stp_image_destroy(&over_white);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layers), cmocka_unit_test(test_mixed), cmocka_unit_test(test_many),
        cmocka_unit_test(test_inside), cmocka_unit_test(test_alpha),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
