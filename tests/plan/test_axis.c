/* Plans of volumes: one list where one is enough, nothing of it elsewhere, and what is refused. */
#include "plans.h"

#include "volumes.h"

static struct inputs volume_inputs(void)
{
    struct inputs in = {
        .scene = block_scene((uint32_t[]){ 4, 5, 6 }, (double[]){ 1, 1, 1 }, 0.5),
        .camera = plain_camera(64, 48, 200),
        .params = { .method = STP_METHOD_AXIS },
    };
    stp_limits_lavapipe(&in.limits);
    look_at(&in.camera, v3(0, 0, 40), v3(0, 0, 0));
    return in;
}

/* No constants of integers, so that not every compiler could compare them itself. */
static void shaders_cut_where_the_processor_does(void **state)
{
    assert_true(STP_AXIS_REACH == KERNEL_REACH);
    assert_true(STP_AXIS_LEAST_ALPHA == LEAST_ALPHA);
}

/* R'R is what the kernel's precision is in the camera frame, and R keeps its volume, which a
 * difference would lose of kernels of 10^6 : 1. */
static void expect_factor(const struct stp_plan *plan, const double spacing[3])
{
    const float *f = plan->frame.axis.factor;
    const double r[3][3] = { { f[0], f[1], f[2] }, { 0, f[3], f[4] }, { 0, 0, f[5] } };
    const double *m = plan->camera.world_to_camera, down[3] = { 1, -1, -1 };
    double g[3][3] = { 0 }, of_r[3][3] = { 0 }, volume = 1;
    for (int a = 0; a < 3; a++) {
        double per_deviation = 1 / (KERNEL_SIGMA * spacing[a]);
        volume *= per_deviation;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                of_r[i][j] += r[a][i] * r[a][j];
                g[i][j] +=
                    down[i] * m[4 * i + a] * down[j] * m[4 * j + a] * per_deviation * per_deviation;
            }
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            assert_true(fabs(of_r[i][j] - g[i][j]) <= 1e-6 * sqrt(g[i][i] * g[j][j]));
    assert_true(r[0][0] > 0 && r[1][1] > 0 && r[2][2] > 0);
    assert_true(fabs(r[0][0] * r[1][1] * r[2][2] / volume - 1) <= 1e-6);
}

static void one_factor_for_all_kernels(void **state)
{
    static const double spacings[][3] = { { 1, 1, 1 }, { 0.1, 2, 0.7 }, { 1e-3, 1, 1000 } };
    static const struct vec3 eyes[] = { { 0, 0, 4000 },
                                        { 3000, 2000, -900 },
                                        { 2000, 2000, 2000 } };
    for (unsigned n = 0; n < 9; n++) {
        struct inputs in = volume_inputs();
        stp_scene_destroy(&in.scene);
        in.scene = block_scene((uint32_t[]){ 4, 5, 6 }, spacings[n / 3], 0.5);
        in.params.path = n % 2 ? STP_PATH_RASTER : STP_PATH_COMPUTE;
        look_at(&in.camera, eyes[n % 3], v3(0, 0, 0));
        struct stp_plan *plan = plan_of(&in);
        expect_factor(plan, spacings[n / 3]);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

static bool mentions_axis(const struct stp_plan *plan)
{
    bool found = plan->axis.count || plan->axis.order;
    for (int c = PLAN_AXIS_WALKS; c <= PLAN_AXIS_PART; c++)
        found = found || plan->constant[c];
    for (enum plan_slot slot = PLAN_IMAGE_AXIS_COLOR; slot <= PLAN_IMAGE_AXIS_DEPTH; slot++)
        found = found || plan_find(plan, slot) != PLAN_NONE;
    found = found || plan_find(plan, PLAN_PROJECTED) != PLAN_NONE ||
            plan_find(plan, PLAN_AXIS_SUMS) != PLAN_NONE;
    for (uint32_t i = 0; i < plan->pass_count; i++)
        found = found || (plan->pass[i].shader >= PLAN_SHADER_AXIS_PROJECT &&
                          plan->pass[i].shader <= PLAN_SHADER_AXIS_EMPTY);
    return found;
}

static void surfaces_pay_nothing(void **state)
{
    static const enum stp_method methods[] = { STP_METHOD_EXACT, STP_METHOD_DEFERRED,
                                               STP_METHOD_TWO_PASS };
    struct inputs in = plain_inputs();
    for (int i = 0; i < 3; i++) {
        in.params.method = methods[i];
        struct stp_plan *plan = plan_of(&in);
        assert_false(mentions_axis(plan));
        stp_plan_destroy(&plan);
    }
    release_inputs(&in);
}

static void one_axis_costs_one_list(void **state)
{
    struct inputs in = volume_inputs();
    struct stp_plan *plan = plan_of(&in);
    uint64_t kernels = in.scene->volume->kernels.count;
    assert_int_equal(plan->axis.walk_count, 1);
    assert_int_equal(plan->axis.count, kernels);
    assert_int_equal(resource_named(plan, "kernels")->bytes, 32 * kernels);
    assert_int_equal(plan_find(plan, PLAN_IMAGE_AXIS_COLOR), PLAN_NONE);
    /* Not a byte for the other two, and no sums of any. */
    assert_null(resource_named(plan, "walk sums"));
    assert_int_equal(resource_named(plan, "block starts")->bytes,
                     4 * (64 / AXIS_BLOCK_WIDTH * (48 / AXIS_BLOCK_HEIGHT) + 1));
    assert_int_equal(resource_named(plan, "block splats")->bytes, 4 * plan->axis_blocks.count);
    assert_int_equal(resource_named(plan, "projected")->bytes, 32 * kernels);
    assert_int_equal(plan_bytes(plan, PLAN_SCENE), resource_named(plan, "block starts")->bytes +
                                                       resource_named(plan, "block splats")->bytes +
                                                       32 * kernels);
    assert_int_equal(plan_bytes(plan, PLAN_TRANSIENT), 32 * kernels);
    assert_true(!plan->axis.sheets[0].first && !plan->axis.sheets[1].first);
    assert_int_equal(plan->pass_count, 2);
    assert_int_equal(pass_named(plan, "walks")->shader, PLAN_SHADER_AXIS_BLOCK_SHUFFLED);
    assert_int_equal(resource_named(plan, "projected")->format, PLAN_TEXELS_RGBA32UI);
    assert_int_equal(resource_named(plan, "block splats")->format, PLAN_TEXELS_R32UI);
    stp_plan_destroy(&plan);
    in.limits.features &= ~(unsigned)STP_FEATURE_SUBGROUP_SHUFFLE;
    plan = plan_of(&in);
    assert_int_equal(pass_named(plan, "walks")->shader, PLAN_SHADER_AXIS_BLOCK_FETCHED);
    stp_plan_destroy(&plan);
    in.limits.features |= STP_FEATURE_SUBGROUP_SHUFFLE;
    in.limits.features &= ~(unsigned)STP_FEATURE_TEXEL_BUFFERS;
    plan = plan_of(&in);
    assert_int_equal(resource_named(plan, "projected")->format, PLAN_BUFFER);
    assert_int_equal(resource_named(plan, "block splats")->format, PLAN_BUFFER);
    assert_int_equal(pass_named(plan, "walks")->shader, PLAN_SHADER_AXIS_BLOCK);
    assert_int_equal(plan->constant[PLAN_AXIS_CUT], 0);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void three_axes_cost_three(void **state)
{
    struct inputs in = volume_inputs();
    look_at(&in.camera, v3(20, 20.5, 21), v3(0, 0, 0));
    in.params.path = STP_PATH_RASTER;
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->axis.walk_count, 3);
    assert_int_equal(resource_named(plan, "walk depth")->layers, 3);
    assert_int_equal(resource_named(plan, "kernels")->bytes, 32 * plan->facts.splats);
    assert_int_equal(resource_named(plan, "lists")->bytes, 4 * plan->axis.count);
    assert_int_equal(resource_named(plan, "lists")->format, PLAN_BUFFER);
    char *text = stp_plan_print(plan);
    assert_non_null(strstr(text, "rays along -x"));
    assert_non_null(strstr(text, "h 0.85"));
    free(text);
    stp_plan_destroy(&plan);
    in.params.axis_merge = STP_AXIS_SINGLE;
    plan = plan_of(&in);
    assert_int_equal(plan->axis.walk_count, 1);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void near_adds_the_code_that_cuts(void **state)
{
    struct inputs in = volume_inputs();
    in.camera.near_depth = 39;
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->constant[PLAN_AXIS_CUT], 1);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void nothing_in_view_needs_no_list(void **state)
{
    struct inputs in = volume_inputs();
    look_at(&in.camera, v3(0, 0, 40), v3(0, 0, 80));
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->axis.walk_count, 0);
    assert_null(resource_named(plan, "kernels"));
    assert_null(resource_named(plan, "walk sums"));
    assert_int_equal(plan->pass_count, 1);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void refuse(const struct inputs *in, enum stp_result expected, const char *words)
{
    struct plan_log log = { 0 };
    struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct stp_plan *plan = NULL;
    assert_int_equal(stp_plan_create(&env, in->scene, &in->camera, &in->params, &in->limits, &plan),
                     expected);
    assert_true(log.lines == 1 && !plan);
    if (!strstr(log.last, words))
        fail_msg("'%s' does not say '%s'", log.last, words);
}

static void what_does_not_fit_is_refused(void **state)
{
    struct inputs in = volume_inputs();
    const struct inputs good = in;
    in.params.method = STP_METHOD_EXACT;
    refuse(&in, STP_ERROR_ARGUMENT, "surfaces");
    in = good;
    in.params.samples = 4;
    refuse(&in, STP_ERROR_ARGUMENT, "one sample");
    in = good;
    in.params.aovs = STP_AOV_ID;
    refuse(&in, STP_ERROR_ARGUMENT, "aovs");
    in = good;
    in.params.axis_h = 1;
    refuse(&in, STP_ERROR_ARGUMENT, "below 1");
    in = good;
    in.params.path = STP_PATH_RASTER;
    in.params.mask_features = STP_FEATURE_FLOAT32_BLEND;
    refuse(&in, STP_ERROR_FEATURE, "float32");
    in = good;
    in.params = (struct stp_render_params){ 0 };
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->method, STP_METHOD_AXIS);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shaders_cut_where_the_processor_does),
        cmocka_unit_test(one_factor_for_all_kernels),
        cmocka_unit_test(surfaces_pay_nothing),
        cmocka_unit_test(one_axis_costs_one_list),
        cmocka_unit_test(three_axes_cost_three),
        cmocka_unit_test(near_adds_the_code_that_cuts),
        cmocka_unit_test(nothing_in_view_needs_no_list),
        cmocka_unit_test(what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
