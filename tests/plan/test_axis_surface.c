/* Plans of surfaces by axis lists: what a flat Gaussian needs is there and nowhere else, and what
 * they cannot show is refused. */
#include "plans.h"

#include "volumes.h"

static struct inputs surface_inputs(void)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_AXIS;
    return in;
}

static void splats_and_their_lists(void **state)
{
    struct inputs in = surface_inputs();
    struct stp_plan *plan = plan_of(&in);
    uint64_t splats = plan->facts.splats,
             blocks = resource_named(plan, "block starts")->bytes + 4 * plan->axis_blocks.count;
    assert_int_equal(plan->constant[PLAN_AXIS_SHAPE], 2);
    assert_int_equal(resource_named(plan, "splats")->bytes, 32 * splats);
    assert_int_equal(resource_named(plan, "projected")->bytes, 64 * splats);
    assert_int_equal(plan_bytes(plan, PLAN_TRANSIENT), 64 * splats);
    assert_int_equal(plan_bytes(plan, PLAN_SCENE),
                     32 * splats + blocks + (plan->facts.has_color ? 12 * splats : 0));
    assert_int_equal(plan->pass_count, 2);
    assert_int_equal(pass_named(plan, "project")->shader, PLAN_SHADER_AXIS_SURFACE);
    assert_int_equal(pass_named(plan, "walks")->shader, PLAN_SHADER_AXIS_BLOCK_SHUFFLED);
    stp_plan_destroy(&plan);
    static const float background[] = { 1, 1, 1, 1 };
    in.params.background = background;
    in.params.path = STP_PATH_RASTER;
    in.params.axis_merge = STP_AXIS_SINGLE;
    plan = plan_of(&in);
    assert_int_equal(plan->axis.walk_count, 1);
    assert_int_equal(plan->pass_count, 4); /* project, a walk, merge, background */
    assert_int_equal(plan->pass[1].vertex, PLAN_SHADER_AXIS_SURFACE_VERTEX);
    assert_int_equal(plan->pass[3].shader, PLAN_SHADER_BACKGROUND);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* An environment that no splat mirrors is no part of it, and may lie behind. */
static void an_environment_behind(void **state)
{
    struct inputs in = surface_inputs();
    in.scene->facts.environment_levels = 1;
    in.scene->facts.environment_texels = 1000;
    struct stp_plan *plan = plan_of(&in);
    assert_null(resource_named(plan, "environment"));
    stp_plan_destroy(&plan);
    in.params.environment_behind = true;
    plan = plan_of(&in);
    assert_non_null(resource_named(plan, "environment"));
    assert_int_equal(plan->pass[plan->pass_count - 1].shader, PLAN_SHADER_BACKGROUND);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* The floor and culling are the lists', too. */
static void lists_look_as_the_picture_does(void **state)
{
    struct inputs in = surface_inputs();
    in.params.min_splat = 7;
    in.params.cull = STP_CULL_BACK;
    struct stp_plan *plan = plan_of(&in);
    assert_true(plan->axis.look.cull_back && plan->axis.look.floor == 7);
    stp_plan_destroy(&plan);
    in.params.min_splat = -1;
    in.params.cull = STP_CULL_NONE;
    plan = plan_of(&in);
    assert_true(!plan->axis.look.cull_back && plan->axis.look.floor == 0);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void its_reference_is_on_the_cpu(void **state)
{
    struct inputs in = surface_inputs();
    in.params.axis_merge = STP_AXIS_REFERENCE;
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->method, STP_METHOD_REFERENCE);
    assert_int_equal(plan->resource_count, 0);
    stp_plan_destroy(&plan);
    in.params.method = STP_METHOD_AUTO; /* which takes no lists of a surface */
    plan = plan_of(&in);
    assert_int_equal(plan->method, STP_METHOD_EXACT);
    stp_plan_destroy(&plan);
    release_inputs(&in);
    struct inputs volume = {
        .scene = block_scene((uint32_t[]){ 4, 5, 6 }, (double[]){ 1, 1, 1 }, 0.5),
        .camera = plain_camera(64, 48, 200),
        .params = { .axis_merge = STP_AXIS_REFERENCE },
    };
    stp_limits_lavapipe(&volume.limits);
    look_at(&volume.camera, v3(0, 0, 40), v3(0, 0, 0));
    plan = plan_of(&volume);
    assert_int_equal(plan->method, STP_METHOD_REFERENCE);
    stp_plan_destroy(&plan);
    release_inputs(&volume);
}

/* A volume has not a byte or a pass of it. */
static void volumes_pay_nothing(void **state)
{
    for (int path = STP_PATH_RASTER; path <= STP_PATH_COMPUTE; path++) {
        struct inputs in = {
            .scene = block_scene((uint32_t[]){ 4, 5, 6 }, (double[]){ 1, 1, 1 }, 0.5),
            .camera = plain_camera(64, 48, 200),
            .params = { .path = (enum stp_path)path },
        };
        static const float background[] = { 1, 1, 1, 1 };
        in.params.background = background;
        stp_limits_lavapipe(&in.limits);
        look_at(&in.camera, v3(0, 0, 40), v3(0, 0, 0));
        struct stp_plan *plan = plan_of(&in);
        assert_int_equal(plan->constant[PLAN_AXIS_SHAPE], 0);
        assert_null(resource_named(plan, "splats"));
        assert_int_equal(resource_named(plan, "projected")->bytes, 32 * plan->facts.splats);
        for (uint32_t i = 0; i < plan->pass_count; i++) {
            assert_true(plan->pass[i].shader != PLAN_SHADER_AXIS_SURFACE);
            assert_true(plan->pass[i].shader != PLAN_SHADER_AXIS_SURFACE_FRAGMENT);
            assert_true(plan->pass[i].shader != PLAN_SHADER_BACKGROUND);
        }
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

static void deep(struct inputs *in)
{
    in->params.deep = true;
}

static void light_of_pixels(struct inputs *in)
{
    in->params.shade = STP_SHADE_FLAT;
}

static void layers_counted(struct inputs *in)
{
    in->params.aovs = STP_AOV_LAYERS;
    in->scene->facts.transparent = true;
}

static void peel(struct inputs *in)
{
    in->params.transparency = STP_TRANSPARENCY_PEEL;
    in->scene->facts.transparent = true;
}

static void samples(struct inputs *in)
{
    in->params.samples = 4;
}

static void ids(struct inputs *in)
{
    in->params.aovs = STP_AOV_ID;
}

static void mirrors(struct inputs *in)
{
    in->scene->facts.environment_levels = 1;
    in->scene->facts.environment_texels = 1000;
    in->scene->facts.reflects = true;
}

static void whole_h(struct inputs *in)
{
    in->params.axis_h = 1;
}

static const struct plan_refusal refused[] = {
    { deep, "not layers" },         { light_of_pixels, "--shade" }, { layers_counted, "exact" },
    { peel, "transparency peel" },  { samples, "one sample" },      { ids, "aovs" },
    { mirrors, "mirrors nothing" }, { whole_h, "below 1" },
};

static void what_it_cannot_show(void **state)
{
    expect_refusals(surface_inputs, refused, sizeof refused / sizeof *refused);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(splats_and_their_lists),
        cmocka_unit_test(an_environment_behind),
        cmocka_unit_test(lists_look_as_the_picture_does),
        cmocka_unit_test(its_reference_is_on_the_cpu),
        cmocka_unit_test(volumes_pay_nothing),
        cmocka_unit_test(what_it_cannot_show),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
