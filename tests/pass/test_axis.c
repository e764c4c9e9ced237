/* The axis method against the same order composited in float64, in every hard view, and against the
 * exact order of the reference. */
#include "drawn.h"
#include "marched.h"
#include "walks.h"

enum { N = 9, W = 48, H = 40 };

static struct stp_scene *random_volume(uint32_t seed, const double spacing[3], bool unshaded)
{
    struct transfer_function f = { .count = 3,
                                   .point = { { 0, { 1, 0.2f, 0 }, 0.01f },
                                              { 0.9, { 0, 1, 0.3f }, 0.5f },
                                              { 1, { 0.1f, 0.2f, 1 }, 1 } } };
    struct stp_scene *scene = random_volume_scene(seed, (const uint32_t[]){ N, N, N }, spacing,
                                                  (const double[]){ 0, 0, 0 }, &f);
    if (!unshaded) {
        struct stp_volume_params params = { .transfer_function = "hot" };
        assert_int_equal(stp_scene_set_transfer_function(NULL, scene, &params), STP_OK);
    }
    return scene;
}

/* The views of the fixture, then borders of two and three axes. */
#define MORE_VIEWS 3
static struct stp_camera view_of_index(int index)
{
    static const struct vec3 eyes[MORE_VIEWS] = { { 0, 0, 4 }, { 3, 0, 3 }, { 3, 3, 3 } };
    if (index < VIEWS)
        return hard_view(index, W, H);
    struct stp_camera c = plain_camera(W, H, 1.2 * H);
    look_at(&c, eyes[index - VIEWS], v3(0, 0, 0));
    return c;
}

static void expect_lists_order(struct device *device, const struct stp_scene *scene,
                               const struct stp_camera *camera, enum stp_path path,
                               enum stp_axis_merge merge, double h)
{
    struct stp_render_params params = {
        .method = STP_METHOD_AXIS, .path = path, .axis_merge = merge, .axis_h = h == 0 ? -1 : h
    };
    struct stp_image *image = device_render(device, scene, camera, &params);
    struct axis_lists lists;
    struct drawn drawn;
    drawn_make(scene, camera, &params, &drawn);
    assert_int_equal(lists_of_view(NULL, scene, camera, merge, h, &lists), STP_OK);
    for (uint32_t y = 1; y < H; y += 6)
        for (uint32_t x = 2; x < W; x += 7) {
            double sum[5];
            drawn_merge(&drawn, &lists, x, y, 0, sum);
            drawn_expect(sum, image, x, y, 6e-4, 1e-2, 1e-3);
        }
    axis_lists_release(&lists);
    drawn_release(&drawn);
    stp_image_destroy(&image);
}

static void every_merge_in_every_view(void **state)
{
    struct device device;
    const double even[3] = { 0.2, 0.2, 0.2 }, flat[3] = { 0.05, 0.05, 0.5 };
    device_open(&device, 0);
    for (int v = 0; v < VIEWS + MORE_VIEWS; v++) {
        struct stp_scene *scene = random_volume(11 + (uint32_t)v, v % 3 ? even : flat, v % 2);
        struct stp_camera camera = view_of_index(v);
        enum stp_path path = v % 2 ? STP_PATH_RASTER : STP_PATH_COMPUTE;
        enum stp_path other = v % 2 ? STP_PATH_COMPUTE : STP_PATH_RASTER;
        expect_lists_order(&device, scene, &camera, path, STP_AXIS_BLEND, 0.85);
        expect_lists_order(&device, scene, &camera, other,
                           (enum stp_axis_merge)(STP_AXIS_BLEND + v % 4), v % 3 ? 0 : 0.99);
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* A smooth ball: the lists' order is near enough to the exact one. */
static void near_the_exact_order(void **state)
{
    enum { M = 24 };
    static float values[M * M * M];
    struct device device;
    struct stp_volume volume = { .dims = { M, M, M },
                                 .spacing = { 1, 1, 1 },
                                 .origin = { -11.5, -11.5, -11.5 },
                                 .value = values };
    for (int i = 0; i < M * M * M; i++) {
        double x = i % M - 11.5, y = i / M % M - 11.5, z = i / M / M - 11.5;
        values[i] = (float)fmax(0, 1 - sqrt(x * x + y * y + z * z) / 11);
    }
    struct transfer_function f = { .count = 3,
                                   .point = { { 0, { 1, 0.2f, 0 }, 0 },
                                              { 0.5, { 0.2f, 1, 0 }, 0.1f },
                                              { 1, { 0.1f, 0.2f, 1 }, 0.9f } } };
    struct stp_scene *scene = volume_scene(&volume, &f);
    struct stp_camera camera = plain_camera(64, 64, 90);
    look_at(&camera, v3(20, 26, 30), v3(0, 0, 0));
    struct stp_render_params params = { .method = STP_METHOD_AXIS };
    struct stp_image *truth = render_volume(scene, &camera, &params);
    device_open(&device, 0);
    for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge++) {
        params.axis_merge = (enum stp_axis_merge)merge;
        struct stp_image *image = device_render(&device, scene, &camera, &params);
        struct stp_comparison c;
        const struct stp_compare_params how = { 0 };
        assert_int_equal(stp_compare(NULL, image, truth, &how, &c), STP_OK);
        if (!(c.covered.psnr > (merge == STP_AXIS_SORT ? 60 : 40)))
            fail_msg("merge %d: %.1f dB", merge, c.covered.psnr);
        stp_image_destroy(&image);
    }
    device_close(&device);
    stp_image_destroy(&truth);
    stp_scene_destroy(&scene);
}

/* Tiles show the same bits; a background lies behind; what nobody sees is empty. */
static void tiles_background_and_nothing(enum stp_path path)
{
    struct device device;
    static const float background[] = { 0.2f, 0.4f, 0.6f, 0.5f };
    struct stp_scene *scene = random_volume(5, (double[]){ 0.2, 0.2, 0.2 }, false);
    struct stp_camera camera = view_of_index(0);
    struct stp_render_params params = { .method = STP_METHOD_AXIS, .path = path };
    device_open(&device, 0);
    struct stp_image *whole = device_render(&device, scene, &camera, &params);
    params.memory_limit = 200000;
    struct stp_image *tiled = device_render(&device, scene, &camera, &params);
    expect_same_bits(whole, tiled, "tiles");
    params = (struct stp_render_params){ .method = STP_METHOD_AXIS,
                                         .path = path,
                                         .background = background };
    struct stp_image *behind = device_render(&device, scene, &camera, &params);
    for (uint32_t y = 0; y < H; y += 3)
        for (uint32_t x = 0; x < W; x += 3) {
            double a = (double)value(whole, "A", x, y), c = (double)value(whole, "G", x, y);
            close_to((double)value(behind, "G", x, y), c + (1 - a) * 0.5 * 0.4, 1e-6);
            close_to((double)value(behind, "A", x, y), a + (1 - a) * 0.5, 1e-6);
        }
    look_at(&camera, v3(0, 0, 50), v3(0, 0, 100));
    struct stp_image *nothing = device_render(&device, scene, &camera, &params);
    assert_true(value(nothing, "A", 3, 3) == 0.5f && isinf(value(nothing, "Z", 3, 3)));
    stp_image_destroy(&whole);
    stp_image_destroy(&tiled);
    stp_image_destroy(&behind);
    stp_image_destroy(&nothing);
    device_close(&device);
    stp_scene_destroy(&scene);
}

static void by_the_rasteriser(void **state)
{
    tiles_background_and_nothing(STP_PATH_RASTER);
}

static void by_compute(void **state)
{
    tiles_background_and_nothing(STP_PATH_COMPUTE);
}

/* More splats on 4 x 4 pixels than one pass takes, as texels and by address. */
static void long_lists_go_on(void **state)
{
    static const unsigned masks[] = { 0, STP_FEATURE_TEXEL_BUFFERS };
    struct stp_scene *scene =
        block_scene((uint32_t[]){ 5, 5, 10600 }, (double[]){ 1, 1, 1 }, 0.0012);
    struct stp_camera camera = plain_camera(4, 4, 40000);
    look_at(&camera, v3(0, 0, 40000), v3(0, 0, 0));
    struct stp_render_params params = { .method = STP_METHOD_AXIS, .path = STP_PATH_COMPUTE };
    struct stp_image *truth = render_volume(scene, &camera, &params);
    for (int m = 0; m < 2; m++) {
        struct device device;
        struct stp_plan *plan = NULL;
        device_open(&device, 0);
        params.mask_features = masks[m];
        assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
        if (plan->axis_blocks.longest <= STP_AXIS_PART)
            fail_msg("%zu entries in a block", plan->axis_blocks.longest);
        assert_int_equal(plan->pass_count, 2 + 2);
        struct stp_image *image = device_render_plan(&device, scene, plan);
        for (uint32_t i = 0; i < 16; i++)
            close_to((double)value(image, "A", i % 4, i / 4),
                     (double)value(truth, "A", i % 4, i / 4), 1e-4);
        stp_image_destroy(&image);
        stp_plan_destroy(&plan);
        device_close(&device);
    }
    stp_image_destroy(&truth);
    stp_scene_destroy(&scene);
}

/* A device without shuffles has the same bits, and one without texels has them by addresses. Odd
 * sizes leave threads outside of the picture. */
static void without_shuffles_or_texels(void **state)
{
    static const unsigned masks[] = { STP_FEATURE_SUBGROUP_SHUFFLE, STP_FEATURE_TEXEL_BUFFERS };
    struct device device;
    struct stp_scene *scene = random_volume(17, (double[]){ 0.2, 0.2, 0.2 }, false);
    device_open(&device, 0);
    for (int v = 0; v < VIEWS + MORE_VIEWS; v += 2) {
        struct stp_camera camera = view_of_index(v);
        camera.width -= (uint32_t)v;
        camera.height -= 3;
        struct stp_render_params params = { .method = STP_METHOD_AXIS, .axis_h = 0.5 };
        struct stp_image *shuffled = device_render(&device, scene, &camera, &params);
        for (int m = 0; m < 2; m++) {
            params.mask_features = masks[m];
            struct stp_image *other = device_render(&device, scene, &camera, &params);
            expect_same_bits(other, shuffled, stp_feature_name((enum stp_feature)masks[m]));
            stp_image_destroy(&other);
        }
        stp_image_destroy(&shuffled);
    }
    device_close(&device);
    stp_scene_destroy(&scene);
}

/* A plan made for a device with shuffles is refused by one without. */
static void plan_of_another_device(void **state)
{
    struct device device, lacking;
    struct stp_scene *scene = random_volume(17, (double[]){ 0.2, 0.2, 0.2 }, false);
    struct stp_camera camera = view_of_index(0);
    struct stp_render_params params = { .method = STP_METHOD_AXIS };
    struct stp_plan *plan = NULL;
    struct stp_image *image = NULL;
    device_open(&device, 0);
    assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
    device_open(&lacking, STP_FEATURE_SUBGROUP_SHUFFLE);
    assert_int_equal(stp_render(&lacking.env, lacking.context, scene, plan, 0, &image, NULL),
                     STP_ERROR_FEATURE);
    assert_null(image);
    assert_non_null(strstr(lacking.last, "the plan uses subgroup-shuffle"));
    device_close(&lacking);
    stp_plan_destroy(&plan);
    device_close(&device);
    stp_scene_destroy(&scene);
}

/* Alpha is the same in every order: against the reference, by two of the eight merges and paths. */
static void expect_alpha(struct device *device, const struct stp_scene *scene,
                         const struct stp_camera *camera, int which, const char *what)
{
    struct stp_render_params params = { .method = STP_METHOD_AXIS };
    struct stp_image *truth = render_volume(scene, camera, &params);
    for (int n = 2 * which; n < 2 * which + 2; n++) {
        params.axis_merge = (enum stp_axis_merge)(STP_AXIS_BLEND + n / 2 % 4);
        params.path = n % 2 ? STP_PATH_RASTER : STP_PATH_COMPUTE;
        struct stp_image *image = device_render(device, scene, camera, &params);
        for (uint32_t i = 0; i < camera->width * camera->height; i++) {
            uint32_t x = i % camera->width, y = i / camera->width;
            double a = (double)value(image, "A", x, y), b = (double)value(truth, "A", x, y);
            if (!(fabs(a - b) <= 4e-4))
                fail_msg("%s, merge %d, path %d, pixel %u %u: %g, not %g", what, params.axis_merge,
                         params.path, x, y, a, b);
        }
        stp_image_destroy(&image);
    }
    stp_image_destroy(&truth);
}

static void slabs_at_angles(void **state)
{
    struct device device;
    device_open(&device, 0);
    for (int n = 0; n < 6; n++) {
        double angle = n / 2 * M_PI / 6;
        bool flat = n % 2;
        struct stp_scene *scene = block_scene((uint32_t[]){ 24, 24, flat ? 2 : 6 },
                                              (double[]){ 1, 1, flat ? 10 : 1 }, 0.15);
        struct stp_camera camera = flat_camera(24, 18, 2);
        look_at(&camera, v3(60 * sin(angle), 0, 60 * cos(angle)), v3(0, 0, 0));
        expect_alpha(&device, scene, &camera, n, "slab");
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* By compute a walk ends when what it can still add, by its share, is no more than `end`; it can
 * add but the light that is left there less what comes through everything. */
static double ended(const struct stp_render_params *params, const double share[4], double left)
{
    double end = ldexp(1, params->axis_merge == STP_AXIS_SORT ? -20 : -17), sum = 0;
    for (int n = 0; n < 4 && params->path == STP_PATH_COMPUTE; n++)
        sum += share[n] > 0 ? fmax(0, end - share[n] * left) : 0;
    return sum;
}

/* A second opinion: rays marched through the sum of the Gaussians (march.h). Every merge has its
 * alpha but for floats and what ended walks leave out, and its colours within what the order of
 * whole kernels may change of them besides; of colours those never came to more than 4e-5. */
static void a_marched_volume(void **state)
{
    static const char *const names[] = { "R", "G", "B" };
    static struct march m;
    static struct march_ray ray;
    struct device device;
    device_open(&device, 0);
    for (int n = 0; n < 2 * MARCH_VIEWS; n++) {
        struct stp_camera camera = march_view(&m, n / 2, 26, 20);
        struct stp_scene *scene = march_scene(&m);
        struct stp_render_params params = { .method = STP_METHOD_AXIS,
                                            .axis_merge = (enum stp_axis_merge)(
                                                STP_AXIS_BLEND + (n / 2 + 2 * (n % 2)) % 4),
                                            .path = n % 2 ? STP_PATH_RASTER : STP_PATH_COMPUTE };
        struct stp_image *image = device_render(&device, scene, &camera, &params);
        for (uint32_t i = 0; i < 26 * 20; i++) {
            double through[5], most[4], off[2], share[4];
            march_pixel(&m, &camera, i % 26, i / 26, &ray);
            march_through(ray.found, ray.count, ray.depth, through);
            march_merge(&ray, &camera, params.axis_merge, most, off, share);
            double end = ended(&params, share, march_left(&ray));
            close_to((double)value(image, "A", i % 26, i / 26), through[3], off[1] + end);
            for (int c = 0; c < 3; c++)
                close_to((double)value(image, names[c], i % 26, i / 26), through[c],
                         most[c] + fmin(4e-5, off[0] + end));
        }
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* Warm frames make their lists again: the same picture, and a time of its own for them. */
static void lists_are_timed(void **state)
{
    struct device device;
    struct stp_scene *scene = random_volume(18, (double[]){ 0.2, 0.2, 0.2 }, false);
    struct stp_camera camera = view_of_index(1);
    struct stp_render_params params = { .method = STP_METHOD_AXIS };
    device_open(&device, 0);
    for (int path = STP_PATH_RASTER; path <= STP_PATH_COMPUTE; path++) {
        struct stp_render_stats stats;
        struct stp_image *image = NULL;
        struct stp_plan *plan = NULL;
        params.path = (enum stp_path)path;
        assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
        assert_int_equal(stp_render(&device.env, device.context, scene, plan, 2, &image, &stats),
                         STP_OK);
        assert_int_equal(stats.pass_count, plan->pass_count + 1);
        const struct stp_pass_time *last = &stats.pass[plan->pass_count];
        assert_string_equal(last->name, "lists, on the CPU");
        assert_true(last->milliseconds > 0 && stats.frame_ms_max >= stats.frame_ms_min);
        stp_image_destroy(&image);
        stp_plan_destroy(&plan);
    }
    device_close(&device);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_merge_in_every_view), cmocka_unit_test(near_the_exact_order),
        cmocka_unit_test(by_the_rasteriser),         cmocka_unit_test(by_compute),
        cmocka_unit_test(long_lists_go_on),          cmocka_unit_test(without_shuffles_or_texels),
        cmocka_unit_test(plan_of_another_device),    cmocka_unit_test(slabs_at_angles),
        cmocka_unit_test(a_marched_volume),          cmocka_unit_test(lists_are_timed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
