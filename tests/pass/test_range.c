/* Ellipsoids of range images by both paths, against the lists' order composited in float64, in
 * every hard view, and against the exact order. */
#include "ranges.h"

#include "device.h"
#include "reference/range.h"

enum { W = 48, H = 40 };

/* One walk's colour and premultiplied depth on a ray, from the far end of its list. */
static void walk_pixel(const struct medium *medium, const uint32_t *order, uint32_t count,
                       const struct ray *ray, double sum[5])
{
    memset(sum, 0, 5 * sizeof *sum);
    for (uint32_t i = 0; i < count; i++) {
        struct medium_fragment f;
        if (!ellipsoid_hit(medium, order[i], medium_centre(medium, order[i]), medium->tau[order[i]],
                           ray, &f))
            continue;
        const double *c = medium->shaded[order[i]];
        const double own[5] = { c[0], c[1], c[2], 1, f.depth };
        for (int n = 0; n < 5; n++)
            sum[n] = f.alpha * own[n] + (1 - f.alpha) * sum[n];
    }
}

/* Eq. 1 with the weights of the pixel's ray, then the surface's normalisation. */
static void expect_pixel(const struct medium *medium, const struct axis_lists *lists,
                         const struct stp_image *image, uint32_t x, uint32_t y)
{
    struct ray ray = eye_ray(&medium->view->eye, x + 0.5, y + 0.5);
    struct vec3 v = eye_direction_to_world(&medium->view->eye, ray.along);
    double sum[5] = { 0 }, weights = 0, one[5];
    for (unsigned w = 0; w < lists->walk_count; w++) {
        const struct axis_walk *walk = &lists->walk[w];
        double weight = pow(axis_weight(lists, walk, v), 2);
        weights += weight;
        walk_pixel(medium, lists->order + walk->first, walk->count, &ray, one);
        for (int n = 0; n < 5; n++)
            sum[n] += weight * one[n];
    }
    for (int n = 0; n < 5 && weights > 0; n++)
        sum[n] /= weights;
    double scale = sum[3] >= 0.5 ? 1 / sum[3] : 2;
    static const char *const names[] = { "R", "G", "B", "A" };
    for (int n = 0; n < 4; n++)
        close_to((double)value(image, names[n], x, y), sum[n] * scale, 3e-3);
    double z = (double)value(image, "Z", x, y);
    if (sum[3] > 0.02)
        close_to(z, sum[4] / sum[3], 1e-3 * fmax(1, sum[4] / sum[3]));
    assert_true(isfinite(z) == (value(image, "A", x, y) > 0));
}

static void expect_lists_order(struct device *device, const struct stp_scene *scene,
                               const struct stp_camera *camera, enum stp_path path,
                               enum stp_axis_merge merge)
{
    struct stp_render_params params = { .method = STP_METHOD_AXIS,
                                        .path = path,
                                        .axis_merge = merge };
    struct stp_image *image = device_render(device, scene, camera, &params);
    struct view view = { .scene = scene, .width = W, .height = H, .grid = 1 };
    struct axis_lists lists;
    struct medium medium;
    eye_init(&view.eye, camera, scene->splats.origin);
    assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
    assert_int_equal(axis_lists_build(NULL, scene, camera, merge, 0.85, &lists), STP_OK);
    for (uint32_t y = 1; y < H; y += 3)
        for (uint32_t x = 2; x < W; x += 4)
            expect_pixel(&medium, &lists, image, x, y);
    axis_lists_release(&lists);
    medium_release(&medium);
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

/* The same bits whatever cuts the picture in tiles, and run after run. */
static void the_same_bits(void **state)
{
    struct device device;
    struct range range = random_range(5, 3, 16, 0.05);
    struct stp_scene *scene = range_scene(&range);
    struct stp_camera camera = hard_view(0, W, H);
    struct stp_render_params params = { .method = STP_METHOD_AXIS };
    device_open(&device, 0);
    struct stp_image *a = device_render(&device, scene, &camera, &params);
    struct stp_image *b = device_render(&device, scene, &camera, &params);
    expect_same_bits(a, b, "again");
    stp_image_destroy(&a);
    stp_image_destroy(&b);
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
