/* Plans of range images: what an ellipsoid adds is there, and nowhere else. */
#include "plans.h"

#include "ranges.h"

static struct inputs range_inputs(void)
{
    struct range range = random_range(3, 2, 8, 0.05);
    struct inputs in = { .scene = range_scene(&range), .camera = hard_view(0, 64, 48) };
    stp_limits_lavapipe(&in.limits);
    return in;
}

static void ellipsoids_by_compute(void **state)
{
    struct inputs in = range_inputs();
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->method, STP_METHOD_AXIS);
    assert_int_equal(plan->constant[PLAN_AXIS_SHAPE], 1);
    assert_int_equal(plan->constant[PLAN_UNLIT], 1);
    assert_int_equal(resource_named(plan, "kernels")->bytes, 80 * plan->facts.splats);
    assert_int_equal(resource_named(plan, "projected")->bytes, 64 * plan->facts.splats);
    assert_int_equal(plan_find(plan, PLAN_MATERIALS), PLAN_NONE); /* nothing is lit */
    assert_int_equal(plan->constant[PLAN_AXIS_CUT], 0);           /* nothing is near the eye */
    char *text = stp_plan_print(plan);
    assert_non_null(strstr(text, " axis_shape=1"));
    free(text);
    stp_plan_destroy(&plan);
    look_at(&in.camera, v3(0, 0, 0.1), v3(0, 0.1, -1));
    plan = plan_of(&in);
    assert_int_equal(plan->constant[PLAN_AXIS_CUT], 1);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* A volume and points have no byte of it. */
static void others_pay_nothing(void **state)
{
    struct inputs in = {
        .scene = block_scene((uint32_t[]){ 4, 5, 6 }, (double[]){ 1, 1, 1 }, 0.5),
        .camera = plain_camera(64, 48, 200),
    };
    stp_limits_lavapipe(&in.limits);
    look_at(&in.camera, v3(0, 0, 40), v3(0, 0, 0));
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->constant[PLAN_AXIS_SHAPE], 0);
    assert_int_equal(resource_named(plan, "kernels")->bytes, 32 * plan->facts.splats);
    assert_int_equal(resource_named(plan, "projected")->bytes, 32 * plan->facts.splats);
    stp_plan_destroy(&plan);
    release_inputs(&in);
    in = plain_inputs();
    plan = plan_of(&in);
    assert_int_equal(plan->constant[PLAN_AXIS_SHAPE], 0);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void surface(struct inputs *in)
{
    in->params.method = STP_METHOD_EXACT;
}

static void deep(struct inputs *in)
{
    in->params.deep = true;
}

static void light_cube(struct inputs *in)
{
    in->params.light_cube = STP_ON;
}

static void light_of_splats(struct inputs *in)
{
    in->params.shade = STP_SHADE_SPLAT;
}

static const struct plan_refusal refused[] = {
    { surface, "--range-splats discs" },
    { deep, "no layers" },
    { light_cube, "light cube" },
    { light_of_splats, "--range-splats discs" },
};

/* What belongs to surfaces: one line says so, and nothing is made. */
static void surfaces_are_refused(void **state)
{
    expect_refusals(range_inputs, refused, sizeof refused / sizeof *refused);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ellipsoids_by_compute),
        cmocka_unit_test(others_pay_nothing),
        cmocka_unit_test(surfaces_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
