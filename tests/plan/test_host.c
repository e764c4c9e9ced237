/* A frame whose layers a host's depth cuts needs that depth; no other plan has anything of it. */
#include "base/memory.h"
#include "plans.h"

static bool reads(const struct stp_plan *plan, const struct plan_pass *pass, enum plan_slot slot)
{
    for (unsigned i = 0; i < pass->access_count; i++)
        if (plan->resource[pass->access[i].resource].slot == slot)
            return true;
    return false;
}

static void test_nothing_without(void **state)
{
    for (int faded = 0; faded < 2; faded++) {
        struct inputs in = plain_inputs();
        if (faded)
            fade_inputs(&in, true);
        struct stp_plan *plan = plan_of(&in);
        char *before = stp_plan_print(plan);
        assert_null(resource_named(plan, "limits"));
        assert_int_equal(plan_behind_host(NULL, plan, PLAN_HOST_DEPTH_NONE), STP_OK);
        if (!faded) /* what is opaque is tested as it is drawn */
            assert_int_equal(plan_behind_host(NULL, plan, PLAN_HOST_DEPTH_FLOAT), STP_OK);
        char *after = stp_plan_print(plan);
        assert_string_equal(before, after);
        free(before);
        free(after);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

static void test_layers(void **state)
{
    struct inputs in = plain_inputs();
    fade_inputs(&in, true);
    in.params.samples = 4;
    struct stp_plan *plan = plan_of(&in), *cut = NULL;
    assert_int_equal(plan_copy(NULL, plan, &cut), STP_OK);
    assert_int_equal(plan_behind_host(NULL, cut, PLAN_HOST_DEPTH_16), STP_OK);
    assert_int_equal(cut->constant[PLAN_HOST_DEPTH], PLAN_HOST_DEPTH_16);
    assert_int_equal(cut->resource_count, plan->resource_count + 2);
    assert_int_equal(cut->pass_count, plan->pass_count + 2);
    assert_int_equal(cut->repeat_first, plan->repeat_first + 2); /* once for all samples */
    assert_int_equal(cut->loop_first, plan->loop_first + 2);
    assert_int_equal(resource_named(cut, "limits")->bytes, 64 * 48 * 4);
    const char *const geometry[] = { "slots",           "slots large", "mend find",
                                     "mend find large", "mend sum",    "mend sum large" };
    for (unsigned i = 0; i < sizeof geometry / sizeof *geometry; i++)
        assert_true(reads(cut, pass_named(cut, geometry[i]), PLAN_LIMITS));
    assert_false(reads(cut, pass_named(cut, "layers"), PLAN_LIMITS));
    stp_plan_destroy(&cut);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* Its transients count when the picture is cut into tiles, and no allocation may be taken on
 * trust. */
static void test_tiles_and_memory(void **state)
{
    struct inputs in = plain_inputs();
    fade_inputs(&in, false);
    struct stp_plan *plan = plan_of(&in), *cut = NULL;
    uint64_t all = plan_bytes(plan, PLAN_TRANSIENT) + plan_bytes(plan, PLAN_OUTPUT);
    assert_int_equal(plan->tile_count, 1);
    stp_plan_destroy(&plan);
    in.params.memory_limit = all; /* not a byte for the host's depth */
    plan = plan_of(&in);
    assert_int_equal(plan->tile_count, 1);
    assert_int_equal(plan_copy(NULL, plan, &cut), STP_OK);
    mem_fail_at(1);
    assert_int_equal(plan_behind_host(NULL, cut, PLAN_HOST_DEPTH_24), STP_ERROR_MEMORY);
    mem_fail_at(0);
    assert_int_equal(plan_behind_host(NULL, cut, PLAN_HOST_DEPTH_24), STP_OK);
    assert_true(cut->tile_count > 1);
    assert_true(plan_bytes(cut, PLAN_TRANSIENT) + plan_bytes(cut, PLAN_OUTPUT) <= all);
    stp_plan_destroy(&cut);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void test_refused(void **state)
{
    struct plan_log log = { 0 };
    const struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct inputs in = plain_inputs();
    fade_inputs(&in, false);
    struct stp_plan *plan = plan_of(&in);
    plan->transparency = STP_TRANSPARENCY_FAST;
    assert_int_equal(plan_behind_host(&env, plan, PLAN_HOST_DEPTH_FLOAT), STP_ERROR_ARGUMENT);
    assert_int_equal(log.lines, 1);
    assert_non_null(strstr(log.last, "transparency fast"));
    assert_null(resource_named(plan, "limits"));
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nothing_without),
        cmocka_unit_test(test_layers),
        cmocka_unit_test(test_tiles_and_memory),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
