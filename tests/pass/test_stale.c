/* A plan that meets another scene, or its own in another state, is refused before a byte is moved:
 * its buffers have the sizes of what it was made of. What does not matter to a plan may change. */
#include "device.h"
#include "surroundings.h"

#include <stipple/fit.h>
#include <stipple/machines.h>
#include <stipple/volume.h>

#include "prepare/groupings.h"

#define POINTS 600

/* Points on a ball, each with its own colour. */
static struct stp_scene *ball(size_t n, float opacity)
{
    static double position[2 * POINTS][3];
    static float normal[2 * POINTS][3];
    for (size_t i = 0; i < n; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)n, ring = sqrt(1 - z * z), a = i * 2.399963;
        for (int k = 0; k < 3; k++) {
            position[i][k] = k == 0 ? ring * cos(a) : k == 1 ? ring * sin(a) : z;
            normal[i][k] = (float)position[i][k];
        }
    }
    const struct stp_points points = { .count = n,
                                       .position = (const double(*)[3])position,
                                       .normal = (const float(*)[3])normal };
    const struct stp_object_params object = { .opacity = opacity };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, &object), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    return scene;
}

static struct stp_camera view_of(const struct stp_scene *scene)
{
    struct stp_camera camera;
    const struct stp_frame_params params = { .width = 48, .height = 40 };
    assert_int_equal(stp_camera_frame(NULL, scene, &params, &camera), STP_OK);
    return camera;
}

static struct stp_plan *plan_of(struct device *d, const struct stp_scene *scene,
                                const struct stp_render_params *params)
{
    struct stp_camera camera = view_of(scene);
    struct stp_plan *plan = NULL;
    if (device_plan(d, scene, &camera, params, &plan) != STP_OK)
        fail_msg("no plan: %s", d->last);
    return plan;
}

static void group(struct stp_scene *scene, double overlap)
{
    const struct stp_group_params params = { .overlap = overlap };
    assert_int_equal(stp_scene_group(NULL, scene, &params), STP_OK);
}

static void expect_refused(struct device *d, const struct stp_scene *scene,
                           const struct stp_plan *plan, const char *part)
{
    char line[100];
    struct stp_image *image = NULL;
    unsigned lines = d->lines;
    snprintf(line, sizeof line, "the plan was made of another %s than the scene now has", part);
    assert_int_equal(stp_render(&d->env, d->context, scene, plan, 0, &image, NULL),
                     STP_ERROR_ARGUMENT);
    assert_null(image);
    assert_int_equal(d->lines, lines + 1);
    if (!strstr(d->last, line))
        fail_msg("%s", d->last);
}

static void expect_drawn(struct device *d, const struct stp_scene *scene,
                         const struct stp_plan *plan)
{
    struct stp_image *image = device_render_plan(d, scene, plan);
    stp_image_destroy(&image);
}

static void test_grouped_again(void **state)
{
    static const enum stp_path paths[] = { STP_PATH_COMPUTE, STP_PATH_RASTER };
    struct device d;
    device_open(&d, 0);
    struct stp_scene *scene = ball(POINTS, 1);
    for (unsigned i = 0; i < 2; i++) {
        group(scene, 0.1);
        unsigned few = scene->facts.grouping.groups;
        struct stp_plan *deferred =
            plan_of(&d, scene,
                    &(struct stp_render_params){ .method = STP_METHOD_DEFERRED, .path = paths[i] });
        struct stp_plan *exact =
            plan_of(&d, scene, &(struct stp_render_params){ .method = STP_METHOD_EXACT });
        expect_drawn(&d, scene, deferred);
        group(scene, 1);
        assert_true(scene->facts.grouping.groups > few); /* its layers would be too few */
        expect_refused(&d, scene, deferred, "grouping");
        expect_drawn(&d, scene, exact);
        stp_plan_destroy(&deferred);
        deferred =
            plan_of(&d, scene,
                    &(struct stp_render_params){ .method = STP_METHOD_DEFERRED, .path = paths[i] });
        expect_drawn(&d, scene, deferred);
        stp_plan_destroy(&deferred);
        stp_plan_destroy(&exact);
    }
    stp_scene_destroy(&scene);
    device_close(&d);
}

/* Groupings that are kept aside: each plan fits while its own is shown, as it does in sweeps. */
static void test_groupings_in_turns(void **state)
{
    const struct stp_render_params params = { .method = STP_METHOD_DEFERRED };
    const struct stp_group_params none = { 0 };
    struct groupings kept;
    struct device d;
    struct stp_plan *before, *plan[2];
    device_open(&d, 0);
    struct stp_scene *scene = ball(POINTS, 1);
    group(scene, 0.9);
    before = plan_of(&d, scene, &params);
    groupings_begin(&kept, scene);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(groupings_use(NULL, &kept, &none, i ? 1 : 0.1), STP_OK);
        plan[i] = plan_of(&d, scene, &params);
        expect_refused(&d, scene, before, "grouping");
    }
    for (int i = 0; i < 4; i++) {
        assert_int_equal(groupings_use(NULL, &kept, &none, i % 2 ? 1 : 0.1), STP_OK);
        expect_drawn(&d, scene, plan[i % 2]);
        expect_refused(&d, scene, plan[1 - i % 2], "grouping");
    }
    groupings_end(&kept, false);
    expect_drawn(&d, scene, before);
    expect_refused(&d, scene, plan[0], "grouping");
    stp_plan_destroy(&before);
    stp_plan_destroy(&plan[0]);
    stp_plan_destroy(&plan[1]);
    stp_scene_destroy(&scene);
    device_close(&d);
}

static void test_covered_again(void **state)
{
    struct device d;
    device_open(&d, 0);
    struct stp_scene *scene = ball(POINTS, 0.5f);
    assert_int_equal(stp_scene_cover(NULL, scene, &(struct stp_cover_params){ .groups = 2 }),
                     STP_OK);
    struct stp_plan *fast =
        plan_of(&d, scene, &(struct stp_render_params){ .transparency = STP_TRANSPARENCY_FAST });
    struct stp_plan *exact =
        plan_of(&d, scene, &(struct stp_render_params){ .transparency = STP_TRANSPARENCY_EXACT });
    group(scene, 0.8); /* not what it takes */
    expect_drawn(&d, scene, fast);
    assert_int_equal(stp_scene_cover(NULL, scene, &(struct stp_cover_params){ .groups = 6 }),
                     STP_OK);
    expect_refused(&d, scene, fast, "cover");
    expect_drawn(&d, scene, exact);
    stp_plan_destroy(&fast);
    stp_plan_destroy(&exact);
    stp_scene_destroy(&scene);
    device_close(&d);
}

/* Another scene, of more splats, of as many, and where the first one stood. */
static void test_other_scenes(void **state)
{
    static const enum stp_method methods[] = { STP_METHOD_EXACT, STP_METHOD_REFERENCE };
    struct device d;
    device_open(&d, 0);
    for (unsigned m = 0; m < 2; m++) {
        const struct stp_render_params params = { .method = methods[m] };
        struct stp_scene *scene = ball(100, 1), *more = ball(2 * POINTS, 1), *alike = ball(100, 1);
        struct stp_plan *plan = plan_of(&d, scene, &params);
        expect_drawn(&d, scene, plan);
        expect_refused(&d, more, plan, "scene");
        expect_refused(&d, alike, plan, "scene");
        stp_scene_destroy(&scene);
        for (int i = 0; i < 8; i++) { /* of which one takes the memory that was freed */
            struct stp_scene *next = ball(150, 1);
            expect_refused(&d, next, plan, "scene");
            stp_scene_destroy(&next);
        }
        stp_plan_destroy(&plan);
        stp_scene_destroy(&more);
        stp_scene_destroy(&alike);
    }
    device_close(&d);
}

/* Fewer splats than the plan has, or other buffers. */
static void test_changed(void **state)
{
    const struct stp_render_params exact = { .method = STP_METHOD_EXACT };
    struct device d;
    device_open(&d, 0);
    struct stp_scene *scene = ball(POINTS, 1);
    struct stp_plan *plan = plan_of(&d, scene, &exact);
    const struct stp_light light = { .direction = { 1, 2, 3 }, .color = { 1, 0.5f, 1 } };
    assert_int_equal(stp_scene_set_lights(NULL, scene, &light, 1), STP_OK);
    expect_drawn(&d, scene, plan); /* lights are the plan's */
    surround(scene, 16, 8, smooth_sky, NULL);
    expect_refused(&d, scene, plan, "content");
    stp_plan_destroy(&plan);
    plan = plan_of(&d, scene, &exact);
    expect_drawn(&d, scene, plan);
    surround(scene, 32, 16, smooth_sky, NULL);
    expect_refused(&d, scene, plan, "content");
    stp_plan_destroy(&plan);
    plan = plan_of(&d, scene, &exact);
    assert_int_equal(stp_scene_fit(NULL, scene, &(struct stp_fit_params){ .tolerance = 0.1 }, NULL),
                     STP_OK);
    assert_true(scene->splats.count < POINTS);
    expect_refused(&d, scene, plan, "content");
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    scene = ball(POINTS, 1);
    plan = plan_of(&d, scene, &exact);
    assert_int_equal(stp_scene_share(NULL, scene, 0, 2), STP_OK);
    expect_refused(&d, scene, plan, "content");
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    device_close(&d);
}

static void test_classified_again(void **state)
{
    const struct stp_render_params axis = { .method = STP_METHOD_AXIS };
    float value[8 * 8 * 8];
    for (unsigned i = 0; i < 512; i++)
        value[i] = (float)(i % 8);
    const struct stp_volume volume = { { 8, 8, 8 }, { 0.2, 0.2, 0.2 }, { 0 }, value };
    struct stp_volume_params shown = { .transfer_function = "grey" };
    struct device d;
    struct stp_scene *scene = NULL;
    device_open(&d, 0);
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_set_volume(NULL, scene, &volume, &shown), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    struct stp_plan *plan = plan_of(&d, scene, &axis);
    expect_drawn(&d, scene, plan);
    shown.transfer_function = "none such";
    assert_int_not_equal(stp_scene_set_transfer_function(NULL, scene, &shown), STP_OK);
    expect_drawn(&d, scene, plan); /* the scene is as it was */
    shown.transfer_function = "hot";
    assert_int_equal(stp_scene_set_transfer_function(NULL, scene, &shown), STP_OK);
    expect_refused(&d, scene, plan, "content");
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    device_close(&d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_grouped_again), cmocka_unit_test(test_groupings_in_turns),
        cmocka_unit_test(test_covered_again), cmocka_unit_test(test_other_scenes),
        cmocka_unit_test(test_changed),       cmocka_unit_test(test_classified_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
