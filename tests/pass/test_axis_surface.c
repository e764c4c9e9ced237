/* Surfaces by the axis method against the same order composited in float64 by the reference's
 * splats, in every hard view; and against every ray's own order. */
#include "drawn.h"
#include "ellipses.h"

enum { W = 48, H = 40 };

static void expect_lists_order(struct device *device, const struct stp_scene *scene,
                               const struct stp_camera *camera, struct stp_render_params params,
                               double h)
{
    params.method = STP_METHOD_AXIS;
    params.axis_h = h == 0 ? -1 : h;
    struct stp_image *image = device_render(device, scene, camera, &params);
    struct axis_lists lists = { .merge = params.axis_merge, .h = h };
    struct drawn drawn;
    size_t asked = 0, clear = 0;
    drawn_make(scene, camera, &params, &drawn);
    lists.look = (struct axis_look){ drawn.view.cull_back, drawn.view.min_splat };
    assert_int_equal(axis_lists_update(NULL, scene, camera, &lists), STP_OK);
    for (uint32_t y = 1; y < H; y += 3)
        for (uint32_t x = 2; x < W; x += 4) {
            double sum[5];
            asked++;
            if (!drawn_merge(&drawn, &lists, x, y, 2e-3, sum))
                continue;
            clear++;
            drawn_expect(sum, image, x, y, 2e-3, 2e-2, 2e-3);
        }
    if (clear < asked / 2)
        fail_msg("%zu of %zu pixels could be judged", clear, asked);
    axis_lists_release(&lists);
    drawn_release(&drawn);
    stp_image_destroy(&image);
}

/* Discs, ellipses with fields, ellipses with clip lines; some transparent; floor and culling. */
static void every_merge_in_every_view(void **state)
{
    struct device device;
    device_open(&device, 0);
    for (int v = 0; v < VIEWS; v++) {
        struct stp_scene *scene = v % 3 == 0 ? scene_random(60 + (uint32_t)v, 250, 0.05)
                                             : random_scene(60 + (uint32_t)v, 200, v % 3 == 1);
        struct stp_camera camera = hard_view(v, W, H);
        struct stp_render_params params = { .path = v % 2 ? STP_PATH_RASTER : STP_PATH_COMPUTE,
                                            .axis_merge = STP_AXIS_BLEND,
                                            .min_splat = v % 4 < 2 ? -1 : 3,
                                            .cull = v % 2 ? STP_CULL_BACK : STP_CULL_NONE };
        scene->facts.two_sided = v % 3 > 0;
        expect_lists_order(&device, scene, &camera, params, 0.85);
        params.path = v % 2 ? STP_PATH_COMPUTE : STP_PATH_RASTER;
        params.axis_merge = (enum stp_axis_merge)(STP_AXIS_BLEND + v % 4);
        expect_lists_order(&device, scene, &camera, params, v % 3 ? 0 : 0.99);
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* Opacities of their own, objects, colours and lights: not divided by alpha. */
static void transparent_splats(void **state)
{
    struct device device;
    device_open(&device, 0);
    for (int path = STP_PATH_RASTER; path <= STP_PATH_COMPUTE; path++) {
        uint32_t seed = 5;
        struct stp_scene *scene = scene_make(200, 2, 0.05);
        for (size_t i = 0; i < 200; i++) {
            size_t at = scene_add(scene, random_point(&seed, 1), random_point(&seed, 1), 0.2);
            scene_paint(scene, at, (float)uniform(&seed), 0.5f, 0.25f);
            scene_assign(scene, at, i % 2);
            scene_fade(scene, at, i % 7 ? (float)uniform(&seed) : i % 2 ? 1 : 0);
        }
        scene->objects[1].material.diffuse = 0.3f;
        scene->lights[0] = (struct stp_light){ .positional = true,
                                               .position = { 2, 3, 1 },
                                               .color = { 1, 0.5f, 0.25f } };
        scene_finish(scene);
        struct stp_camera camera = hard_view(0, W, H);
        struct stp_render_params params = { .path = (enum stp_path)path,
                                            .axis_merge = STP_AXIS_BLEND,
                                            .local_viewer = true };
        scene->facts.positional_lights = true;
        expect_lists_order(&device, scene, &camera, params, 0.5);
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* A ball of `count` discs. */
static struct stp_scene *ball(size_t count, double radius)
{
    struct stp_scene *scene = scene_make(count, 1, radius);
    for (size_t i = 0; i < count; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)count, angle = 2.399963229728653 * (double)i;
        double r = sqrt(1 - z * z);
        struct vec3 p = v3(r * cos(angle), r * sin(angle), z);
        scene_add(scene, p, p, radius);
    }
    scene_finish(scene);
    return scene;
}

/* A smooth surface: the order within it matters little. */
static void near_every_rays_order(void **state)
{
    struct device device;
    struct stp_scene *scene = ball(3000, 0.07);
    struct stp_camera camera = plain_camera(64, 64, 80);
    look_at(&camera, v3(2.1, 1.7, 2.4), v3(0, 0, 0));
    struct stp_render_params params = { .method = STP_METHOD_AXIS,
                                        .axis_merge = STP_AXIS_REFERENCE,
                                        .cull = STP_CULL_BACK };
    device_open(&device, 0);
    struct stp_image *truth = device_render(&device, scene, &camera, &params);
    for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge++) {
        params.axis_merge = (enum stp_axis_merge)merge;
        struct stp_image *image = device_render(&device, scene, &camera, &params);
        struct stp_comparison c;
        const struct stp_compare_params how = { 0 };
        assert_int_equal(stp_compare(NULL, image, truth, &how, &c), STP_OK);
        if (!(c.covered.psnr > 40))
            fail_msg("merge %d: %.1f dB", merge, c.covered.psnr);
        stp_image_destroy(&image);
    }
    device_close(&device);
    stp_image_destroy(&truth);
    stp_scene_destroy(&scene);
}

/* Tiles show the same bits, with and without texels and shuffles; a background lies behind, and
 * behind the eye dome too. */
static void tiles_and_background(void **state)
{
    static const float background[] = { 0.2f, 0.4f, 0.6f, 0.5f };
    struct device device;
    struct stp_scene *scene = random_scene(9, 200, true);
    struct stp_camera camera = hard_view(0, W, H);
    device_open(&device, 0);
    for (int n = 0; n < 4; n++) {
        struct stp_render_params params = { .method = STP_METHOD_AXIS,
                                            .path = n % 2 ? STP_PATH_RASTER : STP_PATH_COMPUTE };
        scene->facts.eye_dome = n / 2;
        struct stp_image *whole = device_render(&device, scene, &camera, &params);
        struct stp_plan *plan = NULL;
        params.memory_limit = n % 2 ? 160000 : 70000;
        assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
        assert_true(plan->tile_count > 1);
        struct stp_image *tiled = device_render_plan(&device, scene, plan);
        stp_plan_destroy(&plan);
        expect_same_bits(whole, tiled, "tiles");
        params.memory_limit = 0;
        for (int m = 0; m < 2; m++) {
            params.mask_features = m ? STP_FEATURE_TEXEL_BUFFERS : STP_FEATURE_SUBGROUP_SHUFFLE;
            struct stp_image *other = device_render(&device, scene, &camera, &params);
            expect_same_bits(whole, other, m ? "no texels" : "no shuffles");
            stp_image_destroy(&other);
        }
        params.background = background;
        struct stp_image *behind = device_render(&device, scene, &camera, &params);
        for (uint32_t i = 0; i < W * H; i++) {
            uint32_t x = i % W, y = i / W;
            double a = (double)value(whole, "A", x, y), c = (double)value(whole, "G", x, y);
            close_to((double)value(behind, "G", x, y), c + (1 - a) * 0.5 * 0.4, 3e-6);
            close_to((double)value(behind, "A", x, y), a + (1 - a) * 0.5, 3e-6);
        }
        stp_image_destroy(&whole);
        stp_image_destroy(&tiled);
        stp_image_destroy(&behind);
    }
    device_close(&device);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_merge_in_every_view),
        cmocka_unit_test(transparent_splats),
        cmocka_unit_test(near_every_rays_order),
        cmocka_unit_test(tiles_and_background),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
