/* Several samples a pixel: device pictures against the reference's at the same positions. */
#include "group_device.h"

#include "record/record.h"

#define WIDTH   45
#define HEIGHT  37
#define LEAST   60 /* dB, over covered pixels */
#define EPSILON 0.05

static struct stp_image *reference(const struct stp_scene *scene, const struct stp_camera *camera,
                                   const struct stp_render_params *params)
{
    struct stp_env env = { .threads = 2 };
    struct stp_image *image = NULL;
    assert_int_equal(reference_render(&env, scene, camera, params, &image), STP_OK);
    return image;
}

/* How many pixels of a plane are not as in the reference, within `tolerance` of its size. */
static size_t plane_differs(const struct stp_image *image, const struct stp_image *truth,
                            const char *name, double tolerance)
{
    const float *a = stp_image_find(image, name)->data.f, *b = stp_image_find(truth, name)->data.f;
    size_t differs = 0;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++)
        if (isinf(a[i]) || isinf(b[i]))
            differs += a[i] != b[i];
        else
            differs += !(fabs(a[i] - b[i]) <= tolerance * fmax(1, fabs(b[i])));
    return differs;
}

static size_t ids_differ(const struct stp_image *image, const struct stp_image *truth)
{
    const uint32_t *a = stp_image_find(image, "id")->data.u;
    const uint32_t *b = stp_image_find(truth, "id")->data.u;
    size_t differs = 0;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++)
        differs += a[i] != b[i];
    return differs;
}

static void report(const char *plane, size_t differs, size_t most, const char *what)
{
    if (getenv("STP_TEST_VERDICTS") && differs)
        print_message("%s: %s differs at %zu pixels of at most %zu\n", what, plane, differs, most);
    if (differs > most)
        fail_msg("%s: %s differs at %zu pixels", what, plane, differs);
}

/* Colour by PSNR. What is of the nearest sample may come from another where two are as near as
 * rounding, and a sample on an outline may miss: few pixels. */
static void compare(const struct stp_image *image, const struct stp_image *truth, unsigned aovs,
                    const char *what)
{
    static const char *const planes[] = { "Z",   "N.X", "N.Y", "N.Z",    "albedo.R",  "albedo.G",
                                          "P.X", "P.Y", "P.Z", "weight", "fragments", "layers" };
    struct stp_comparison c;
    assert_int_equal(stp_compare(NULL, image, truth, NULL, &c), STP_OK);
    if (getenv("STP_TEST_VERDICTS"))
        print_message("%s: %.1f dB, %llu covered\n", what, c.covered.psnr,
                      (unsigned long long)c.covered.pixels);
    if (c.covered.psnr < LEAST)
        fail_msg("%s: %.1f dB", what, c.covered.psnr);
    size_t most = c.covered.pixels / 40 + 1;
    report("A", plane_differs(image, truth, "A", 1e-6), most, what);
    for (size_t i = 0; aovs && i < sizeof planes / sizeof *planes; i++)
        report(planes[i], plane_differs(image, truth, planes[i], 1e-2), most, what);
    if (aovs)
        report("coverage", plane_differs(image, truth, "coverage", 0), most, what);
    if (aovs)
        report("id", ids_differ(image, truth), most, what);
}

static void expect_samples(struct stp_scene *scene, const struct stp_camera *camera,
                           const struct stp_render_params *params, const char *name)
{
    char what[128];
    snprintf(what, sizeof what, "%s, %s, %u samples", name, stp_method_name(params->method),
             params->samples);
    struct stp_image *image = device_render(&device, scene, camera, params);
    struct stp_image *truth = reference(scene, camera, params);
    compare(image, truth, params->aovs, what);
    stp_image_destroy(&image);
    stp_image_destroy(&truth);
}

/* 10 is rounded up to 16; 40 to 49, which take several submissions, and is no power of two. Splats
 * that face the eye of an orthographic view are as near at every sample: colour alone is compared.
 */
static void same_as_reference(void **state)
{
    static const unsigned samples[] = { 4, 10, 16, 40 };
    static const enum stp_method methods[] = { STP_METHOD_EXACT, STP_METHOD_TWO_PASS };
    struct stp_scene *scene = scene_random(1, 160, EPSILON);
    scene->facts.two_sided = true;
    for (unsigned n = 0; n < 4; n++)
        for (int m = 0; m < 2; m++) {
            struct stp_camera camera = hard_view(n == 1 ? 6 : 0, WIDTH, HEIGHT);
            struct stp_render_params p = { .method = methods[m],
                                           .samples = samples[n],
                                           .min_splat = n == 1 ? 3 : -1,
                                           .local_viewer = n == 2,
                                           .aovs = n == 1 ? 0 : 127 };
            expect_samples(scene, &camera, &p, "cloud");
        }
    stp_scene_destroy(&scene);
}

/* Inside the cloud, wide, sliced: splats are large, and cross the near plane. */
static void hard_views(void **state)
{
    struct stp_scene *scene = scene_random(2, 160, EPSILON);
    for (int view = 0; view < VIEWS; view++) {
        struct stp_camera camera = hard_view(view, WIDTH, HEIGHT);
        struct stp_render_params p = {
            .method = STP_METHOD_EXACT, .payload = STP_PAYLOAD_ID, .samples = 4, .min_splat = -1
        };
        char name[32];
        snprintf(name, sizeof name, "view %d", view);
        expect_samples(scene, &camera, &p, name);
    }
    stp_scene_destroy(&scene);
}

/* A group for every splat: deferred splatting loses nothing. */
static void deferred(void **state)
{
    static const enum stp_voronoi voronoi[] = { STP_VORONOI_OFF, STP_VORONOI_EXACT };
    for (int i = 0; i < 2; i++) {
        struct stp_scene *scene = scene_random(5, 12, EPSILON);
        scene_own_groups(scene);
        struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
        struct stp_render_params p = { .method = STP_METHOD_DEFERRED,
                                       .voronoi = voronoi[i],
                                       .samples = 16,
                                       .min_splat = -1,
                                       .aovs = 127 };
        expect_samples(scene, &camera, &p, i ? "exact Voronoi" : "no Voronoi");
        stp_scene_destroy(&scene);
    }
}

/* A stack of discs: most samples of a pixel overflow its slots, and are repaired one by one. */
static void overflowing(void **state)
{
    struct stp_scene *scene = scene_make(200, 1, 0.02);
    uint32_t seed = 77;
    for (int i = 0; i < 200; i++) {
        double x = 0.3 * uniform(&seed), z = -2 - 0.01 * uniform(&seed);
        size_t at = scene_add(scene, v3(x, 0.1, z), v3(0.3 * uniform(&seed), 0.1, 1), 0.4);
        scene_paint(scene, at, (float)uniform(&seed), 0.5f, (float)uniform(&seed));
    }
    scene_finish(scene);
    struct stp_camera camera = plain_camera(WIDTH, HEIGHT, 40);
    struct stp_render_params p = {
        .method = STP_METHOD_EXACT, .samples = 4, .min_splat = -1, .aovs = 127
    };
    expect_samples(scene, &camera, &p, "stack");
    stp_scene_destroy(&scene);
}

/* Both once, over the finished picture; coverage stays that of the splats. */
static void dome_and_background(void **state)
{
    static const float background[] = { 0.5f, 0.25f, 1, 0.75f };
    struct stp_scene *scene = scene_random(3, 60, EPSILON);
    scene->facts.eye_dome = scene->facts.two_sided = true;
    scene_finish(scene);
    for (int i = 0; i < 2; i++) {
        struct stp_camera camera = hard_view(i ? 6 : 0, WIDTH, HEIGHT);
        struct stp_render_params p = { .method = i ? STP_METHOD_TWO_PASS : STP_METHOD_EXACT,
                                       .samples = 9,
                                       .min_splat = -1,
                                       .background = background,
                                       .aovs = STP_AOV_COVERAGE };
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        struct stp_image *truth = reference(scene, &camera, &p);
        compare(image, truth, 0, "dome and background");
        report("coverage", plane_differs(image, truth, "coverage", 0), 10, "background");
        assert_true(image->channels[3].data.f[0] == 0.75f);
        stp_image_destroy(&image);
        stp_image_destroy(&truth);
    }
    stp_scene_destroy(&scene);
}

/* A facing disc of radius 3.7 pixels covers pi 3.7^2 of them, whatever the reference says. */
static void converges_to_area(void **state)
{
    struct stp_scene *scene = scene_make(1, 1, 0.1);
    scene_add(scene, v3(0.013, -0.021, -1), v3(0, 0, 1), 0.37);
    scene_finish(scene);
    struct stp_camera camera = plain_camera(16, 16, 10);
    for (unsigned samples = 16; samples <= 256; samples *= 16) {
        struct stp_render_params p = { .samples = samples, .min_splat = -1 };
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        const float *alpha = stp_image_find(image, "A")->data.f;
        double area = 0;
        for (size_t i = 0; i < 256; i++)
            area += alpha[i];
        close_to(area, M_PI * 3.7 * 3.7, samples == 16 ? 0.5 : 0.08);
        assert_true(alpha[8 * 16 + 8] == 1); /* exactly */
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

/* Positions are those of the whole picture, and sums are in the order of the samples. */
static void same_bits_in_tiles_and_runs(void **state)
{
    struct stp_scene *scene = scene_random(4, 160, EPSILON);
    struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
    static const enum stp_method methods[] = { STP_METHOD_EXACT, STP_METHOD_TWO_PASS };
    for (int m = 0; m < 2; m++) {
        struct stp_render_params p = { .method = methods[m], .samples = 16, .aovs = 127 };
        struct stp_image *whole = device_render(&device, scene, &camera, &p);
        struct stp_image *again = device_render(&device, scene, &camera, &p);
        p.memory_limit = 600000;
        struct stp_plan *plan = NULL;
        assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
        assert_true(m == 1 || plan->tile_count > 1);
        struct stp_image *tiles = device_render_plan(&device, scene, plan);
        expect_same_bits(again, whole, "again");
        expect_same_bits(tiles, whole, "in tiles");
        stp_plan_destroy(&plan);
        stp_image_destroy(&whole);
        stp_image_destroy(&again);
        stp_image_destroy(&tiles);
    }
    stp_scene_destroy(&scene);
}

static void refused(const struct stp_scene *scene, const struct stp_render_params *p,
                    enum stp_result expected, const char *word)
{
    struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
    struct stp_plan *plan = NULL;
    unsigned lines = device.lines;
    assert_int_equal(device_plan(&device, scene, &camera, p, &plan), expected);
    assert_null(plan);
    assert_int_equal(device.lines, lines + 1);
    if (!strstr(device.last, word))
        fail_msg("\"%s\" does not say \"%s\"", device.last, word);
}

static void refusals(void **state)
{
    struct stp_scene *scene = scene_random(5, 12, EPSILON);
    scene_own_groups(scene);
    for (int m = STP_METHOD_DEFERRED; m <= STP_METHOD_EXACT; m++) {
        struct stp_render_params p = { .method = m, .path = STP_PATH_RASTER, .samples = 2 };
        refused(scene, &p, STP_ERROR_ARGUMENT, "--path raster has one sample");
    }
    struct stp_render_params p = { .method = STP_METHOD_DEFERRED,
                                   .samples = 4,
                                   .mask_features = STP_FEATURE_INT64_ATOMICS };
    refused(scene, &p, STP_ERROR_FEATURE, "shaderBufferInt64Atomics");
    p = (struct stp_render_params){ .samples = 65537 };
    refused(scene, &p, STP_ERROR_ARGUMENT, "65537 samples");
    stp_scene_destroy(&scene);
}

/* Without 64-bit atomics two-pass still adds its samples up. */
static void without_atomics(void **state)
{
    struct stp_scene *scene = scene_random(6, 100, EPSILON);
    struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
    struct stp_render_params p = { .method = STP_METHOD_TWO_PASS,
                                   .samples = 4,
                                   .min_splat = -1,
                                   .mask_features = STP_FEATURE_INT64_ATOMICS };
    expect_samples(scene, &camera, &p, "32-bit atomics");
    stp_scene_destroy(&scene);
}

/* Every pass outside the repeated ones is one step; every repeated one is a step of every sample,
 * in order. */
static void steps_cover_the_plan(void **state)
{
    struct stp_scene *scene = scene_random(7, 12, EPSILON);
    struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
    for (unsigned samples = 1; samples <= 49; samples += 12) {
        struct stp_render_params p = { .samples = samples, .background = (float[4]){ 0 } };
        struct stp_plan *plan = NULL;
        assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
        uint32_t pass = 0, sample = 0, parts = record_parts(plan), all = plan_samples(plan);
        for (uint32_t part = 0; part < parts; part++) {
            struct record_steps steps = record_steps(plan, part);
            assert_true(steps.count <= RECORD_MAX_STEPS);
            assert_int_equal(steps.last, part + 1 == parts);
            for (uint32_t i = 0; i < steps.count; i++) {
                uint32_t s;
                assert_int_equal(record_step(&steps, i, &s), pass);
                if (pass >= plan->repeat_first && pass < plan->repeat_end)
                    assert_int_equal(s, sample);
                if (++pass == plan->repeat_end && ++sample < all)
                    pass = plan->repeat_first;
            }
        }
        assert_int_equal(sample, all);
        assert_int_equal(pass, plan->pass_count);
        stp_plan_destroy(&plan);
    }
    stp_scene_destroy(&scene);
}

static void times_and_words(void **state)
{
    struct stp_scene *scene = scene_random(8, 60, EPSILON);
    struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
    struct stp_render_params p = { .samples = 25 };
    struct stp_plan *plan = NULL;
    struct stp_image *image = NULL;
    struct stp_render_stats stats;
    double sum = 0;
    assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
    char *text = stp_plan_print(plan);
    assert_non_null(strstr(text, "samples: 25 a pixel"));
    assert_non_null(strstr(text, "for each of 25 samples:"));
    free(text);
    assert_int_equal(stp_render(&device.env, device.context, scene, plan, 2, &image, &stats),
                     STP_OK);
    assert_int_equal(stats.pass_count, plan->pass_count);
    for (unsigned i = 0; i < stats.pass_count; i++)
        sum += stats.pass[i].milliseconds;
    assert_true(sum > 0 && stats.frame_ms_median > 0);
    stp_image_destroy(&image);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_as_reference),
        cmocka_unit_test(hard_views),
        cmocka_unit_test(deferred),
        cmocka_unit_test(overflowing),
        cmocka_unit_test(dome_and_background),
        cmocka_unit_test(converges_to_area),
        cmocka_unit_test(same_bits_in_tiles_and_runs),
        cmocka_unit_test(refusals),
        cmocka_unit_test(without_atomics),
        cmocka_unit_test(steps_cover_the_plan),
        cmocka_unit_test(times_and_words),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
