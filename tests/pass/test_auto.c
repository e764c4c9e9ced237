/* What auto reckons with, against the device: the probe's errors against those of whole pictures,
 * and prices from frames that were timed. */
#include "group_device.h"

#include "plan/offer.h"
#include "study/calibrate.h"

static const struct probe_sample every = { .cells = 100000, .alone = true }; /* pixel */

/* 900 discs on a sphere, grouped where it is opaque; some colours where asked. */
static struct stp_scene *sphere(struct stp_camera *camera, double overlap, bool color,
                                double opacity)
{
    const struct calibrate_scene what = { 900, 160, 6, 0.9, 1, overlap, color, opacity };
    struct stp_scene *scene = NULL;
    assert_int_equal(calibrate_scene_make(&device.env, &what, &scene, camera), STP_OK);
    return scene;
}

static double measured_error(const struct stp_scene *scene, const struct stp_plan *plan)
{
    struct stp_image *truth = NULL;
    struct stp_comparison comparison;
    struct stp_image *image = device_render_plan(&device, scene, plan);
    assert_int_equal(reference_render(&device.env, scene, &plan->camera, &plan->params, &truth),
                     STP_OK);
    assert_int_equal(stp_compare(&device.env, image, truth, NULL, &comparison), STP_OK);
    stp_image_destroy(&image);
    stp_image_destroy(&truth);
    return comparison.covered.mean_absolute;
}

/* All pixels of the touched blocks: the mean over the picture is that of the device but for the
 * rounding that auto adds. */
static void expect_estimate(const struct stp_scene *scene, const struct stp_plan *plan)
{
    struct survey survey;
    struct probe probe;
    struct probe_error error;
    assert_int_equal(survey_make(NULL, scene, &plan->camera, &plan->params, &survey), STP_OK);
    assert_int_equal(probe_make(NULL, scene, &plan->camera, &plan->params, &survey, &every, &probe),
                     STP_OK);
    assert_int_equal(plan_judge(NULL, &probe, plan, scene->splats.group, false, &error), STP_OK);
    double actual = measured_error(scene, plan);
    assert_true(error.spread == 0);
    double tolerance = error.rounding + plan_rounding(plan);
    if (getenv("STP_TEST_VERDICTS"))
        fprintf(stderr, "%-40.40s layers %u: measured %.3g, estimated %.3g +- %.3g\n", plan->why,
                plan->params.peel_layers, actual, error.mean, tolerance);
    if (fabs(actual - error.mean) > tolerance)
        fail_msg("%s: measured %g, estimated %g +- %g", plan->why, actual, error.mean, tolerance);
    probe_release(&probe);
    survey_release(&survey);
}

/* Every way that applies to the scene; regrouped: but those that groups make no difference to. */
static void expect_estimates(const struct stp_scene *scene, const struct stp_camera *camera,
                             enum stp_cull cull, bool regrouped)
{
    for (unsigned o = 0; o < plan_offer_count; o++) {
        struct plan_candidate way[PLAN_MAX_OFFERED];
        unsigned count = plan_offers[o]->candidates(way);
        if ((plan_offers[o]->transparency != STP_TRANSPARENCY_AUTO) != scene->facts.transparent)
            continue;
        for (unsigned k = 0; k < count; k++) {
            struct stp_plan *plan = NULL;
            struct stp_render_params params = { .min_splat = -1, .cull = cull };
            params.method = way[k].method;
            params.path = way[k].path;
            params.payload = way[k].payload;
            params.voronoi = way[k].voronoi;
            params.transparency = way[k].transparency;
            params.peel_layers = way[k].layers;
            if (way[k].overlap > 0 && way[k].overlap != 0.4)
                continue; /* the scene has one grouping */
            if ((regrouped && way[k].overlap == 0) || way[k].layers > 2)
                continue; /* as before; as two layers */
            assert_int_equal(device_plan(&device, scene, camera, &params, &plan), STP_OK);
            expect_estimate(scene, plan);
            stp_plan_destroy(&plan);
        }
    }
}

static void test_estimates(void **state)
{
    for (int i = 0; i < 4; i++) {
        struct stp_camera camera;
        struct stp_scene *scene = sphere(&camera, i & 1 ? 0.8 : 0.4, i & 2, 0);
        expect_estimates(scene, &camera, STP_CULL_BACK, i & 1);
        stp_scene_destroy(&scene);
    }
}

/* Light per splat and of the nearest splat: the probe's colours are theirs. */
static void test_shades(void **state)
{
    for (int shade = STP_SHADE_PIXEL + 1; shade <= STP_SHADE_FLAT; shade++) {
        struct stp_camera camera;
        struct stp_plan *plan = NULL;
        struct stp_scene *scene = sphere(&camera, 0.4, true, 0);
        struct stp_render_params params = { .method = STP_METHOD_TWO_PASS,
                                            .min_splat = -1,
                                            .shade = (enum stp_shade)shade };
        assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
        expect_estimate(scene, plan);
        stp_plan_destroy(&plan);
        stp_scene_destroy(&scene);
    }
}

/* Both faces: two layers, and more where discs stand apart. */
static void test_layers(void **state)
{
    for (int i = 0; i < 2; i++) {
        struct stp_camera camera;
        struct stp_scene *scene = sphere(&camera, 0, i & 1, i ? 0.7 : 0.3);
        expect_estimates(scene, &camera, STP_CULL_NONE, false);
        stp_scene_destroy(&scene);
    }
}

static double difference(const struct stp_image *image, size_t at, const double color[3])
{
    static const char *const names[] = { "R", "G", "B" };
    double most = 0;
    for (int k = 0; k < 3; k++)
        most = fmax(most, fabs((double)stp_image_find(image, names[k])->data.f[at] - color[k]));
    return most;
}

/* The probe's pixels one by one: the CPU's pyramid is the device's, but for halves that tip the
 * scales in a few. */
static void expect_pixels(const struct stp_scene *scene, const struct stp_plan *plan)
{
    struct survey survey;
    struct probe probe;
    const struct stp_camera *camera = &plan->camera;
    assert_int_equal(survey_make(NULL, scene, camera, &plan->params, &survey), STP_OK);
    assert_int_equal(probe_make(NULL, scene, camera, &plan->params, &survey, &every, &probe),
                     STP_OK);
    struct probe_color *color = calloc(probe.pixels, sizeof *color);
    assert_int_equal(plan_pyramid_offer.draw(NULL, &probe, plan, color), STP_OK);
    struct stp_image *image = device_render_plan(&device, scene, plan);
    size_t off = 0, seen = 0;
    for (size_t i = 0; i < probe.pixels; i++) {
        const uint32_t *corner = probe.corner[i / (PROBE_CELL * PROBE_CELL)];
        size_t k = i % (PROBE_CELL * PROBE_CELL);
        size_t x = corner[0] + k % PROBE_CELL, y = corner[1] + k / PROBE_CELL;
        if (x >= camera->width || y >= camera->height)
            continue;
        off += difference(image, y * camera->width + x, color[i].color) > 0.01;
        seen += color[i].covered;
    }
    if (!(seen > 300 && off <= seen / 100))
        fail_msg("%zu of %zu pixels differ", off, seen);
    stp_image_destroy(&image);
    free(color);
    probe_release(&probe);
    survey_release(&survey);
}

static void test_pyramid(void **state)
{
    for (uint32_t i = 0; i < 4; i++) {
        struct stp_camera camera;
        struct stp_plan *plan = NULL;
        struct stp_render_params params = { .method = STP_METHOD_PYRAMID,
                                            .min_splat = i == 3 ? 3 : -1,
                                            .cull = i & 1 ? STP_CULL_BACK : STP_CULL_NONE };
        struct stp_scene *scene =
            i < 2 ? sphere(&camera, 0.4, i & 1, 0) : scene_random(i, 400, 0.1);
        if (i >= 2)
            camera = plain_camera(121, 75, 80);
        assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
        expect_pixels(scene, plan);
        stp_plan_destroy(&plan);
        stp_scene_destroy(&scene);
    }
}

static double predicted(const struct calibrate_scene *what, const struct plan_candidate *way,
                        const struct stp_calibration *calibration)
{
    struct stp_scene *scene = NULL;
    struct stp_camera camera;
    struct stp_plan *plan = NULL;
    struct survey survey;
    struct stp_render_params params = { .min_splat = -1, .cull = STP_CULL_BACK };
    params.method = way->method;
    params.path = way->path;
    params.payload = way->payload;
    assert_int_equal(calibrate_scene_make(&device.env, what, &scene, &camera), STP_OK);
    assert_int_equal(survey_make(NULL, scene, &camera, &params, &survey), STP_OK);
    assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
    double ms = plan_predict(plan, &survey, calibration);
    survey_release(&survey);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    return ms;
}

/* Every kind that applies gets prices, which say that the large frame takes longer than the small.
 */
static void test_prices(void **state)
{
    const struct calibrate_scene scenes[] = {
        { 500, 64, 4, 0.9, 1, 0.4, false, 0 },   { 3000, 128, 3, 0.9, 1, 0.6, false, 0 },
        { 500, 64, 4, 0.9, 1, 0.4, true, 0 },    { 500, 64, 4, 0.9, 1, 0, false, 0.4 },
        { 3000, 128, 3, 0.9, 2, 0, false, 0.4 }, { 500, 64, 4, 0.9, 1, 0, true, 0.4 },
    };
    const unsigned count = sizeof scenes / sizeof *scenes;
    struct stp_calibration calibration;
    assert_int_equal(calibrate_measure(&device.env, device.context, scenes, count, &calibration),
                     STP_OK);
    assert_true(calibration.measured);
    for (unsigned kind = 0; plan_cost_name(kind); kind++) {
        double sum = 0;
        for (unsigned term = 0; term < PLAN_TERMS; term++) {
            assert_true(calibration.ns[kind][term] >= 0);
            sum += calibration.ns[kind][term];
        }
        if (!(sum > 0) || !isfinite(sum))
            fail_msg("no price of %s", plan_cost_name(kind));
    }
    const struct plan_offer *const offers[] = { &plan_twopass_offer, &plan_exact_offer };
    for (unsigned o = 0; o < 2; o++) {
        struct plan_candidate way[PLAN_MAX_OFFERED];
        for (unsigned i = 0; i < offers[o]->candidates(way); i++)
            assert_true(predicted(&scenes[0], &way[i], &calibration) <
                        predicted(&scenes[1], &way[i], &calibration));
    }
    assert_int_equal(device.lines, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_estimates), cmocka_unit_test(test_shades),
        cmocka_unit_test(test_layers),    cmocka_unit_test(test_pyramid),
        cmocka_unit_test(test_prices),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
