/* Large splats, drawn block by block, have the bits that they have when a workgroup each draws
 * them: as it does on a device that fetches no texels. */
#include "ellipses.h"
#include "group_device.h"

/* bins: whether it takes them; else one workgroup a large splat. */
static struct stp_image *draw(const struct stp_scene *scene, const struct stp_camera *camera,
                              struct stp_render_params params, bool bins)
{
    struct stp_plan *plan = NULL;
    params.mask_features |= bins ? 0 : STP_FEATURE_TEXEL_BUFFERS;
    assert_int_equal(device_plan(&device, scene, camera, &params, &plan), STP_OK);
    assert_int_equal(plan->constant[PLAN_BINS], bins);
    struct stp_image *image = device_render_plan(&device, scene, plan);
    stp_plan_destroy(&plan);
    return image;
}

static void expect_same(const struct stp_scene *scene, const struct stp_camera *camera,
                        const struct stp_render_params *params, const char *what)
{
    struct stp_image *one = draw(scene, camera, *params, true);
    struct stp_image *other = draw(scene, camera, *params, false);
    expect_same_bits(one, other, what);
    stp_image_destroy(&one);
    stp_image_destroy(&other);
}

/* With 64-bit atomics for what is not binned, and without. */
static void expect_both_same(const struct stp_scene *scene, const struct stp_camera *camera,
                             struct stp_render_params params, const char *what)
{
    params.method = STP_METHOD_TWO_PASS;
    params.path = STP_PATH_COMPUTE;
    expect_same(scene, camera, &params, what);
    params.mask_features = STP_FEATURE_INT64_ATOMICS;
    expect_same(scene, camera, &params, what);
}

/* Ellipses from every hard view, orthographic ones too, some across the near plane: with clip
 * lines; with colours, two sides and a floor. Pictures of odd sizes, whose last blocks are cut. */
static void test_views(void **state)
{
    for (int i = 0; i < VIEWS; i++) {
        int k = i % 2;
        struct stp_scene *scene = random_scene(21 + (uint32_t)i, 100, !k);
        struct stp_camera camera = hard_view(i, 143, 101);
        struct stp_render_params p = { .min_splat = k ? 2 : -1,
                                       .cull = k ? 0 : STP_CULL_BACK,
                                       .aovs = k ? STP_AOV_ALBEDO | STP_AOV_FRAGMENTS : 0 };
        scene->facts.two_sided = k;
        char what[20];
        snprintf(what, sizeof what, "view %d", i);
        if (i < 2) {
            expect_both_same(scene, &camera, p, what);
        } else {
            p.method = STP_METHOD_TWO_PASS;
            p.path = STP_PATH_COMPUTE;
            expect_same(scene, &camera, &p, what);
        }
        stp_scene_destroy(&scene);
    }
}

/* Discs alone, some as wide as the picture: their records are shorter. */
static void test_discs(void **state)
{
    struct stp_scene *scene = scene_make(12, 2, 0.05);
    struct stp_camera camera = plain_camera(150, 130, 150);
    uint32_t seed = 9;
    for (int i = 0; i < 12; i++) {
        struct vec3 p = v3_add(random_point(&seed, 1), v3(0, 0, -3));
        size_t at = scene_add(scene, p, random_point(&seed, 1), 0.05 * pow(20, uniform(&seed)));
        scene_assign(scene, at, i % 2);
        scene_paint(scene, at, (float)uniform(&seed), 0.5f, 1);
    }
    scene_finish(scene);
    expect_both_same(scene, &camera, (struct stp_render_params){ .min_splat = -1 }, "discs");
    struct stp_render_params p = {
        .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE, .samples = 4, .min_splat = -1
    };
    expect_same(scene, &camera, &p, "samples");
    p.samples = 1;
    p.shade = STP_SHADE_SPLAT;
    expect_same(scene, &camera, &p, "splats that are shaded");
    p.shade = STP_SHADE_FLAT;
    expect_same(scene, &camera, &p, "flat splats");
    stp_scene_destroy(&scene);
}

/* Tiles of one picture: each bins the splats that it shows. */
static void test_tiles(void **state)
{
    struct stp_scene *scene = random_scene(41, 80, false);
    struct stp_camera camera = hard_view(0, 263, 150);
    struct stp_render_params p = { .method = STP_METHOD_TWO_PASS,
                                   .path = STP_PATH_COMPUTE,
                                   .min_splat = -1 };
    struct stp_image *whole = draw(scene, &camera, p, true);
    p.memory_limit = 3000000;
    struct stp_image *tiles = draw(scene, &camera, p, true);
    expect_same_bits(whole, tiles, "tiles");
    stp_image_destroy(&whole);
    stp_image_destroy(&tiles);
    stp_scene_destroy(&scene);
}

/* `count` discs of the radius, in pixels, about the middle. */
static struct stp_scene *heap(size_t count, const struct stp_camera *camera, double radius)
{
    uint32_t seed = 51;
    struct stp_scene *scene = scene_make(count, 1, 0.05);
    for (size_t i = 0; i < count; i++) {
        struct vec3 p = v3(0.01 * uniform(&seed), 0.01 * uniform(&seed), -3 - 0.2 * uniform(&seed));
        struct vec3 n = v3_add(v3_scale(random_point(&seed, 1), 0.2), v3(0, 0, 1));
        scene_add(scene, p, n, radius * 3 / camera->fy);
    }
    scene_finish(scene);
    return scene;
}

/* 64 entries a block of 64 blocks, in the mean, are used up by the first of the 200 splats that
 * each take 64: the rest goes to workgroups. */
static void test_no_room(void **state)
{
    struct stp_camera camera = plain_camera(64, 64, 64);
    struct stp_scene *scene = heap(200, &camera, 200);
    expect_both_same(scene, &camera, (struct stp_render_params){ .min_splat = -1 }, "no room");
    stp_scene_destroy(&scene);
}

/* A block's list that is longer than what sums hold at once. */
static void test_long_lists(void **state)
{
    struct stp_camera camera = plain_camera(200, 200, 200);
    struct stp_scene *scene = heap(1500, &camera, 17);
    struct stp_render_params p = {
        .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE, .min_splat = -1, .epsilon = 0.3
    };
    expect_same(scene, &camera, &p, "long lists");
    p.aovs = STP_AOV_FRAGMENTS;
    struct stp_image *image = draw(scene, &camera, p, true);
    const float *fragments = stp_image_find(image, "fragments")->data.f;
    assert_true(fragments[100 * 200 + 100] == 1500);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

/* More large splats than there are records. */
static void test_many(void **state)
{
    struct stp_camera camera = plain_camera(760, 760, 760);
    size_t count = STP_BIN_SPLATS + 200;
    struct stp_scene *scene = scene_make(count, 1, 0.01);
    uint32_t seed = 61;
    for (size_t i = 0; i < count; i++)
        scene_add(scene, v3(0.7 * (2 * uniform(&seed) - 1), 0.7 * (2 * uniform(&seed) - 1), -2),
                  v3(0, 0, 1), 17.0 * 2 / 760);
    scene_finish(scene);
    struct stp_render_params p = { .method = STP_METHOD_TWO_PASS,
                                   .path = STP_PATH_COMPUTE,
                                   .min_splat = -1 };
    expect_same(scene, &camera, &p, "many");
    stp_scene_destroy(&scene);
}

/* Whatever is large, against the reference. */
static void test_reference(void **state)
{
    struct stp_scene *scene = random_scene(71, 40, true);
    struct stp_camera camera = hard_view(0, 181, 155);
    struct stp_render_params p = { .method = STP_METHOD_TWO_PASS,
                                   .path = STP_PATH_COMPUTE,
                                   .min_splat = -1 };
    struct stp_image *image = draw(scene, &camera, p, true);
    stp_image_destroy(&image);
    expect_reference(&device, scene, &camera, &p, &float_tolerance, "large ellipses");
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views),      cmocka_unit_test(test_discs),
        cmocka_unit_test(test_tiles),      cmocka_unit_test(test_no_room),
        cmocka_unit_test(test_long_lists), cmocka_unit_test(test_many),
        cmocka_unit_test(test_reference),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
