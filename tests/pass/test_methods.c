/* Every method and path against the reference: random discs in views that are hard, with every
 * option in turn. */
#include "group_device.h"

#include "base/memory.h"

#define WIDTH  61
#define HEIGHT 45

/* The options of case `i`: every one comes up for every method, in one view or another. */
static struct stp_render_params options(int i)
{
    static const double floor_size[] = { -1, 0, 4 }; /* off, 1.5 pixels, 4 pixels */
    return (struct stp_render_params){
        .min_splat = floor_size[i % 3],
        .cull = i & 1 ? STP_CULL_BACK : STP_CULL_NONE,
        .kernel = i & 2 ? STP_KERNEL_GAUSS : STP_KERNEL_PARABOLA,
        .local_viewer = i & 4,
    };
}

static void in_every_view(struct stp_scene *scene, struct stp_render_params base,
                          const struct tolerance *tolerance, const char *name)
{
    for (int view = 0; view < VIEWS; view++) {
        int i = 5 * view + base.method + 3 * base.path;
        struct stp_camera camera = hard_view(view, WIDTH, HEIGHT);
        struct stp_render_params p = options(i);
        char what[96];
        p.method = base.method;
        p.path = base.path;
        p.payload = base.payload;
        scene->facts.two_sided = (i + view) % 3 != 0;
        snprintf(what, sizeof what, "%s, view %d, options %d", name, view, i);
        expect_reference(&device, scene, &camera, &p, tolerance, what);
    }
}

static void test_exact_packed(void **state)
{
    struct stp_scene *scene = scene_random(1, 160, 0.05);
    in_every_view(scene, (struct stp_render_params){ .method = STP_METHOD_EXACT },
                  &packed_tolerance, "coloured cloud");
    stp_scene_destroy(&scene);
}

static void test_exact_ids(void **state)
{
    struct stp_scene *scene = scene_random(2, 160, 0.05);
    in_every_view(
        scene, (struct stp_render_params){ .method = STP_METHOD_EXACT, .payload = STP_PAYLOAD_ID },
        &exact_tolerance, "coloured cloud");
    stp_scene_destroy(&scene);
}

static void test_two_pass_compute(void **state)
{
    struct stp_scene *scene = scene_random(3, 160, 0.05);
    in_every_view(
        scene,
        (struct stp_render_params){ .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE },
        &float_tolerance, "coloured cloud");
    stp_scene_destroy(&scene);
}

static void test_two_pass_raster(void **state)
{
    struct stp_scene *scene = scene_random(4, 160, 0.05);
    in_every_view(
        scene, (struct stp_render_params){ .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER },
        &float_tolerance, "coloured cloud");
    stp_scene_destroy(&scene);
}

/* A group of its own for every splat: nothing is lost, so that the reference must come out. */
static void test_deferred_own_groups(void **state)
{
    static const enum stp_path paths[] = { STP_PATH_COMPUTE, STP_PATH_RASTER };
    for (int i = 0; i < 2; i++) {
        struct stp_scene *scene = scene_random(5, 8, 0.05);
        scene_own_groups(scene);
        in_every_view(scene,
                      (struct stp_render_params){ .method = STP_METHOD_DEFERRED, .path = paths[i] },
                      &float_tolerance, "groups of one, coloured");
        stp_scene_destroy(&scene);
    }
}

static double psnr_of(const struct stp_scene *scene, const struct stp_camera *camera,
                      struct stp_render_params params)
{
    struct stp_comparison error;
    struct stp_compare_params compare = { 0 };
    struct stp_image *seen = device_render(&device, scene, camera, &params);
    params.method = STP_METHOD_REFERENCE;
    params.path = STP_PATH_AUTO;
    struct stp_image *truth = device_render(&device, scene, camera, &params);
    assert_int_equal(stp_compare(&device.env, seen, truth, &compare, &error), STP_OK);
    stp_image_destroy(&seen);
    stp_image_destroy(&truth);
    return error.covered.psnr;
}

/* Groups as the colouring makes them, none relaxed: at c = 1 discs of a group do not touch, so that
 * only discs that hide each other compete, and the nearer wins. Measured: 144 dB and more. */
static void test_deferred_grouped(void **state)
{
    static const int views[] = { 0, 1, 5, 6 };
    struct stp_group_params groups = { .overlap = 1, .relax = STP_RELAX_NONE };
    struct stp_scene *scene = scene_random(6, 160, 0.05);
    assert_int_equal(stp_scene_group(&device.env, scene, &groups), STP_OK);
    for (int i = 0; i < 8; i++) {
        struct stp_camera camera = hard_view(views[i / 2], WIDTH, HEIGHT);
        struct stp_render_params p = { .method = STP_METHOD_DEFERRED,
                                       .path = i % 2 ? STP_PATH_RASTER : STP_PATH_COMPUTE,
                                       .min_splat = -1 };
        double psnr = psnr_of(scene, &camera, p);
        if (psnr < 110)
            fail_msg("view %d, path %d: %.1f dB", views[i / 2], p.path, psnr);
        if (getenv("STP_TEST_VERDICTS"))
            print_message("grouped, view %d, path %d: %.1f dB\n", views[i / 2], p.path, psnr);
    }
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_packed),        cmocka_unit_test(test_exact_ids),
        cmocka_unit_test(test_two_pass_compute),    cmocka_unit_test(test_two_pass_raster),
        cmocka_unit_test(test_deferred_own_groups), cmocka_unit_test(test_deferred_grouped),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
