/* Plans in words, compared with the files of tests/plan/golden to the byte. To renew them after a
 * change that is meant:   STP_WRITE_GOLDENS=1 meson test -C build --suite plan   and read the
 * difference. */
#include "base/memory.h"
#include "plans.h"

static void expect_golden(struct inputs *in, const char *name)
{
    char path[512];
    struct stp_plan *plan = plan_of(in);
    char *text = stp_plan_print(plan), *golden = calloc(1, 1 << 16);
    assert_true(text && golden);
    snprintf(path, sizeof path, "%s/%s.txt", GOLDENS, name);
    bool write = getenv("STP_WRITE_GOLDENS") != NULL;
    FILE *file = fopen(path, write ? "w" : "r");
    if (!file)
        fail_msg("%s is missing; see the top of test_golden.c", path);
    if (write)
        fputs(text, file);
    else if (fread(golden, 1, (1 << 16) - 1, file) == 0 || strcmp(golden, text) != 0)
        fail_msg("the plan differs from %s; it is now:\n%s", path, text);
    assert_int_equal(fclose(file), 0);
    free(text);
    free(golden);
    stp_plan_destroy(&plan);
    release_inputs(in);
}

static void test_exact(void **state)
{
    struct inputs in = plain_inputs();
    expect_golden(&in, "exact");
}

static void test_exact_colored(void **state)
{
    struct inputs in = plain_inputs();
    color_inputs(&in);
    in.params.aovs = 127;
    expect_golden(&in, "exact_colored_aovs");
}

static void test_exact_without_atomics(void **state)
{
    struct inputs in = plain_inputs();
    in.params.mask_features = STP_FEATURE_INT64_ATOMICS | STP_FEATURE_FLOAT64;
    expect_golden(&in, "exact_without_atomics");
}

static void test_deferred_packed(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_DEFERRED;
    expect_golden(&in, "deferred_packed");
}

static void test_deferred_ids(void **state)
{
    struct inputs in = plain_inputs();
    color_inputs(&in);
    in.params.method = STP_METHOD_DEFERRED;
    expect_golden(&in, "deferred_ids");
}

static void test_deferred_voronoi_exact(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_DEFERRED;
    in.params.voronoi = STP_VORONOI_EXACT;
    expect_golden(&in, "deferred_voronoi_exact");
}

static void test_deferred_raster(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_DEFERRED;
    in.params.path = STP_PATH_RASTER;
    expect_golden(&in, "deferred_raster");
}

static void test_deferred_raster_layered(void **state)
{
    struct inputs in = plain_inputs();
    color_inputs(&in);
    in.params.method = STP_METHOD_DEFERRED;
    in.params.path = STP_PATH_RASTER;
    in.limits.processor = STP_PROCESSOR_GPU;
    expect_golden(&in, "deferred_raster_layered");
}

static void test_two_pass(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_TWO_PASS;
    expect_golden(&in, "two_pass_compute");
    in = plain_inputs();
    in.params.method = STP_METHOD_TWO_PASS;
    in.params.mask_features = STP_FEATURE_INT64_ATOMICS;
    expect_golden(&in, "two_pass_without_atomics");
    in = plain_inputs();
    in.params.method = STP_METHOD_TWO_PASS;
    in.params.path = STP_PATH_RASTER;
    color_inputs(&in);
    expect_golden(&in, "two_pass_raster_colored");
}

static void test_tiled_eye_dome_background(void **state)
{
    static const float background[] = { 1, 1, 1, 1 };
    struct inputs in = plain_inputs();
    in.camera = flat_camera(1000, 700, 100);
    in.scene->facts.eye_dome = in.scene->facts.two_sided = true;
    in.scene->facts.no_normal = 100;
    in.params.background = background;
    in.params.min_splat = -1;
    in.params.kernel = STP_KERNEL_GAUSS;
    in.params.cull = STP_CULL_BACK;
    in.params.memory_limit = 16 << 20;
    expect_golden(&in, "tiled_eye_dome_background");
}

static void test_layers(void **state)
{
    struct inputs in = plain_inputs();
    fade_inputs(&in, false);
    expect_golden(&in, "layers");
    in = plain_inputs();
    fade_inputs(&in, false);
    in.params.deep = true;
    expect_golden(&in, "layers_deep");
    in = plain_inputs();
    fade_inputs(&in, true);
    in.params.samples = 4;
    in.params.aovs = STP_AOV_LAYERS;
    expect_golden(&in, "layers_mixed_samples");
}

static void test_pyramid(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_PYRAMID;
    expect_golden(&in, "pyramid");
    in = plain_inputs();
    color_inputs(&in);
    in.params.method = STP_METHOD_PYRAMID;
    in.params.aovs = 127;
    in.params.samples = 4;
    expect_golden(&in, "pyramid_colored_aovs");
}

static void test_transparent(void **state)
{
    static const char *const names[] = { "transparent_fast", "transparent_nearest",
                                         "transparent_peel", "transparent_peel_raster",
                                         "transparent_peel_mixed" };
    for (int i = 0; i < 5; i++) {
        struct inputs in = plain_inputs();
        fade_inputs(&in, i == 1 || i >= 3);
        cover_inputs(&in);
        in.params.transparency = (enum stp_transparency)(STP_TRANSPARENCY_FAST + (i < 3 ? i : 2));
        in.params.path = i == 3 ? STP_PATH_RASTER : STP_PATH_AUTO;
        in.params.peel_layers = 5;
        expect_golden(&in, names[i]);
    }
}

static void test_reference(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_REFERENCE;
    expect_golden(&in, "reference");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),
        cmocka_unit_test(test_exact_colored),
        cmocka_unit_test(test_exact_without_atomics),
        cmocka_unit_test(test_deferred_packed),
        cmocka_unit_test(test_deferred_ids),
        cmocka_unit_test(test_deferred_voronoi_exact),
        cmocka_unit_test(test_deferred_raster),
        cmocka_unit_test(test_deferred_raster_layered),
        cmocka_unit_test(test_two_pass),
        cmocka_unit_test(test_tiled_eye_dome_background),
        cmocka_unit_test(test_layers),
        cmocka_unit_test(test_pyramid),
        cmocka_unit_test(test_transparent),
        cmocka_unit_test(test_reference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
