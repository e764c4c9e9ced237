/* Ellipsoids of range images by both paths, against the lists' order composited in float64, in
 * every hard view, and against the exact order. */
#include "drawn.h"
#include "ranges.h"
#include "walks.h"

enum { W = 48, H = 40 };

static void expect_lists_order(struct device *device, const struct stp_scene *scene,
                               const struct stp_camera *camera, enum stp_path path,
                               enum stp_axis_merge merge)
{
    struct stp_render_params params = { .method = STP_METHOD_AXIS,
                                        .path = path,
                                        .axis_merge = merge };
    struct stp_image *image = device_render(device, scene, camera, &params);
    struct axis_lists lists;
    struct drawn drawn;
    drawn_make(scene, camera, &params, &drawn);
    assert_int_equal(lists_of_view(NULL, scene, camera, merge, 0.85, &lists), STP_OK);
    for (uint32_t y = 1; y < H; y += 3)
        for (uint32_t x = 2; x < W; x += 4) {
            double sum[5];
            drawn_merge(&drawn, &lists, x, y, 0, sum);
            drawn_expect(sum, image, x, y, 3e-3, 0.04, 1e-3);
        }
    axis_lists_release(&lists);
    drawn_release(&drawn);
    stp_image_destroy(&image);
}

/* Flat ones, round ones, and ones that are longer than the scene. */
static void every_shape_in_every_view(void **state)
{
    static const double sigmas[] = { 1e-4, 0.03, 0.8 };
    struct device device;
    device_open(&device, 0);
    for (int v = 0; v < VIEWS; v++) {
        struct range range = random_range(11 + (uint32_t)v, 3, 9, sigmas[v % 3]);
        range.by_views = v % 2;
        struct stp_scene *scene = range_scene(&range);
        struct stp_camera camera = hard_view(v, W, H);
        expect_lists_order(&device, scene, &camera, STP_PATH_COMPUTE, (enum stp_axis_merge)(v % 4));
        expect_lists_order(&device, scene, &camera, STP_PATH_RASTER, STP_AXIS_BLEND);
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* 10^6 : 1, seen along and across: by either path what the reference sees. */
static void a_million_to_one(void **state)
{
    struct device device;
    struct range range = wall_range(1, 1, 1e4, 1, 55);
    struct stp_scene *scene = range_scene(&range);
    device_open(&device, 0);
    for (int v = 0; v < 2; v++) {
        struct stp_camera camera = plain_camera(W, H, v ? 20 : 4e4);
        camera.near_depth = 0.01;
        if (v)
            look_at(&camera, v3(2, 0.3, -1), v3(0, 0, -1));
        struct stp_render_params params = { .method = STP_METHOD_REFERENCE };
        struct stp_image *truth = render_volume(scene, &camera, &params);
        for (int path = STP_PATH_RASTER; path <= STP_PATH_COMPUTE; path++) {
            params = (struct stp_render_params){ .method = STP_METHOD_AXIS,
                                                 .path = (enum stp_path)path };
            struct stp_image *image = device_render(&device, scene, &camera, &params);
            for (uint32_t y = 0; y < H; y++)
                for (uint32_t x = 0; x < W; x++)
                    close_to((double)value(image, "A", x, y), (double)value(truth, "A", x, y),
                             0.02);
            stp_image_destroy(&image);
        }
        stp_image_destroy(&truth);
    }
    device_close(&device);
    stp_scene_destroy(&scene);
}

/* Two frames of a wall from a new view: the lists' order is near enough to the exact one. */
static void near_the_exact_order(void **state)
{
    struct device device;
    struct range range = wall_range(64, 48, 50, 2, 0.02);
    struct stp_scene *scene = range_scene(&range);
    struct stp_camera camera = plain_camera(W, H, 60);
    struct stp_render_params params = { .method = STP_METHOD_REFERENCE };
    look_at(&camera, v3(0.3, 0.2, -0.1), v3(0, 0, -2));
    struct stp_image *truth = render_volume(scene, &camera, &params);
    params.method = STP_METHOD_AXIS;
    device_open(&device, 0);
    struct stp_image *image = device_render(&device, scene, &camera, &params);
    struct stp_comparison errors;
    assert_int_equal(stp_compare(NULL, image, truth, NULL, &errors), STP_OK);
    assert_true(errors.covered.psnr > 45);
    stp_image_destroy(&image);
    stp_image_destroy(&truth);
    device_close(&device);
    stp_scene_destroy(&scene);
}

/* The same bits run after run, whatever cuts the picture in tiles, without shuffles and texels. */
static void the_same_bits(void **state)
{
    struct device device;
    struct range range = random_range(5, 3, 16, 0.05);
    struct stp_scene *scene = range_scene(&range);
    struct stp_camera camera = hard_view(0, W, H);
    struct stp_render_params params = { .method = STP_METHOD_AXIS };
    device_open(&device, 0);
    struct stp_image *a = device_render(&device, scene, &camera, &params);
    for (int n = 0; n < 4; n++) {
        static const unsigned masks[] = { 0, 0, STP_FEATURE_SUBGROUP_SHUFFLE,
                                          STP_FEATURE_TEXEL_BUFFERS };
        struct stp_plan *plan = NULL;
        params.memory_limit = n == 1 ? 60000 : 0;
        params.mask_features = masks[n];
        assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
        assert_true((plan->tile_count > 1) == (n == 1));
        struct stp_image *b = device_render_plan(&device, scene, plan);
        expect_same_bits(a, b, (const char *[]){ "again", "tiles", "no shuffles", "no texels" }[n]);
        stp_image_destroy(&b);
        stp_plan_destroy(&plan);
    }
    stp_image_destroy(&a);
    device_close(&device);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_shape_in_every_view),
        cmocka_unit_test(a_million_to_one),
        cmocka_unit_test(near_the_exact_order),
        cmocka_unit_test(the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
