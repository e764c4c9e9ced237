/* Plans of one of several processes: what each has and has not, and that all cut alike. */
#include "plans.h"

#include <stipple/machines.h>

#define PROCESSES 3

static struct stp_plan *share_of(unsigned rank, uint64_t memory_limit, bool colors)
{
    struct inputs in = plain_inputs();
    if (colors)
        color_inputs(&in);
    in.camera.width = 200;
    in.camera.height = 120;
    in.params.memory_limit = memory_limit;
    assert_int_equal(stp_scene_share(NULL, in.scene, rank, PROCESSES), STP_OK);
    struct stp_plan *plan = plan_of(&in);
    release_inputs(&in);
    return plan;
}

static unsigned count_kind(const struct stp_plan *plan, enum plan_kind kind)
{
    unsigned count = 0;
    for (uint32_t i = 0; i < plan->pass_count; i++)
        count += plan->pass[i].kind == kind;
    return count;
}

/* Nobody but the root resolves, so nobody else has outputs; every splat is in one share. */
static void test_parts(void **state)
{
    uint64_t splats = 0;
    for (unsigned rank = 0; rank < PROCESSES; rank++) {
        struct stp_plan *plan = share_of(rank, 0, true);
        assert_int_equal(plan->method, STP_METHOD_TWO_PASS);
        assert_int_equal(plan->path, STP_PATH_COMPUTE);
        assert_int_equal(count_kind(plan, PLAN_EXCHANGE), 2);
        assert_int_equal(plan_bytes(plan, PLAN_OUTPUT) > 0, rank == 0);
        assert_int_equal(plan_find(plan, PLAN_OUT_COLOR) != PLAN_NONE, rank == 0);
        uint64_t held = plan->share.splats + (rank == 0 ? plan_pixels(plan) : 1);
        assert_int_equal(plan->resource[plan_find(plan, PLAN_SPLATS)].bytes, held * 32);
        assert_int_equal(plan->resource[plan_find(plan, PLAN_COLORS)].bytes, held * 12);
        assert_int_equal(plan->frame.splat_count, plan->share.splats);
        splats += plan->share.splats;
        stp_plan_destroy(&plan);
    }
    assert_int_equal(splats, 100);
}

/* Fixed point and tiles must not depend on whose share it is. */
static void test_alike(void **state)
{
    const uint64_t limits[] = { 0, 2000000, 700000, 200000 };
    for (unsigned i = 0; i < 4; i++) {
        struct stp_plan *root = share_of(0, limits[i], false);
        assert_int_equal(root->tile_count > 1, i > 0);
        for (unsigned rank = 1; rank < PROCESSES; rank++) {
            struct stp_plan *plan = share_of(rank, limits[i], false);
            assert_int_equal(plan->tile_count, root->tile_count);
            assert_memory_equal(plan->tile, root->tile, root->tile_count * sizeof *root->tile);
            assert_int_equal(plan->tile_width, root->tile_width);
            assert_true(plan->frame.sum_scale == root->frame.sum_scale);
            assert_true(plan->frame.color_scale == root->frame.color_scale);
            assert_true(plan->frame.epsilon == root->frame.epsilon);
            stp_plan_destroy(&plan);
        }
        stp_plan_destroy(&root);
    }
}

/* A scene that is whole has nothing of it. */
static void test_whole(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_TWO_PASS;
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(count_kind(plan, PLAN_EXCHANGE), 0);
    assert_int_equal(plan_ghosts(plan), 0);
    assert_int_equal(plan->resource[plan_find(plan, PLAN_SPLATS)].bytes, 100 * 32);
    char *text = stp_plan_print(plan);
    assert_null(strstr(text, "process"));
    assert_null(strstr(text, "exchange"));
    free(text);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void refuse(struct inputs *in, const char *words)
{
    struct plan_log log = { 0 };
    struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct stp_plan *plan = NULL;
    assert_int_equal(stp_plan_create(&env, in->scene, &in->camera, &in->params, &in->limits, &plan),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(log.lines, 1);
    assert_non_null(strstr(log.last, words));
    assert_null(plan);
}

static void test_refused(void **state)
{
    const enum stp_method others[] = { STP_METHOD_DEFERRED, STP_METHOD_EXACT,
                                       STP_METHOD_REFERENCE };
    struct inputs in = plain_inputs();
    assert_int_equal(stp_scene_share(NULL, in.scene, 1, 2), STP_OK);
    for (unsigned i = 0; i < 3; i++) {
        in.params.method = others[i];
        refuse(&in, "two-pass");
    }
    in.params.method = STP_METHOD_TWO_PASS;
    in.params.path = STP_PATH_RASTER;
    refuse(&in, "compute");
    in.params.path = STP_PATH_AUTO;
    in.scene->facts.transparent = true;
    refuse(&in, "transparent");
    release_inputs(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts),
        cmocka_unit_test(test_alike),
        cmocka_unit_test(test_whole),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
