/* A pyramid has the levels, images and passes that its view and scene need, and no other plan has
 * any of it. */
#include "plans.h"

static struct inputs pyramid_inputs(void)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_PYRAMID;
    in.params.min_splat = -1;
    return in;
}

/* How the pass accesses the slot: PLAN_READ, PLAN_WRITE, both; 0: not at all. */
static unsigned access_of(const struct stp_plan *plan, const char *pass, enum plan_slot slot)
{
    const struct plan_pass *p = pass_named(plan, pass);
    unsigned kind = 0;
    for (unsigned i = 0; i < p->access_count; i++)
        if (plan->resource[p->access[i].resource].slot == slot)
            kind |= p->access[i].kind;
    return kind;
}

/* A splat of d pixels at the scene's depth takes ceil(log2 d) + 1 levels; blocks need four. Only
 * discs that reach beyond the pixels beside their own are looked for from afar, and only those that
 * may touch more than STP_LARGE_AREA pixels, seen from their rim, by a workgroup each. */
static void test_levels(void **state)
{
    static const char *const far_passes[] = { "clear limits", "rim clusters", "rim find",
                                              "rim take", "rim shade" };
    static const struct {
        double diameter;
        uint32_t levels;
        bool far, large;
    } cases[] = { { 0.5, 4, false, false }, { 1.7, 4, false, false }, { 2.5, 4, true, false },
                  { 7.9, 4, true, false },  { 8.1, 5, true, false },  { 14.3, 5, true, false },
                  { 14.5, 5, true, true },  { 100, 8, true, true },   { 5000, 11, true, true } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct inputs in = pyramid_inputs();
        in.camera = plain_camera(1000, 700, 500); /* the nearest point is at depth 3 */
        in.scene->facts.radius_max = (float)(cases[i].diameter / 2 * 3 / 500);
        struct stp_plan *plan = plan_of(&in);
        assert_int_equal(plan->levels, cases[i].levels);
        for (unsigned k = 0; k < 5; k++)
            assert_int_equal(pass_named(plan, far_passes[k]) != NULL, cases[i].far);
        assert_int_equal(resource_named(plan, "reaching") != NULL, cases[i].far);
        assert_int_equal(plan->again_end != 0, cases[i].far);
        assert_int_equal(pass_named(plan, "rim splat, large") != NULL, cases[i].large);
        assert_int_equal(plan->constant[PLAN_RIM_FAR], cases[i].far);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* The passes over the rim say what their shaders do, no more: barriers come from it. */
static void test_accesses(void **state)
{
    static const unsigned both = PLAN_READ | PLAN_WRITE;
    static const struct {
        const char *pass;
        enum plan_slot slot;
        unsigned near, far; /* where discs reach the pixels beside their own, and beyond */
    } cases[] = { { "push 0 and shade", PLAN_WORK, both, both },
                  { "push 0 and shade", PLAN_RIM, PLAN_WRITE, PLAN_WRITE },
                  { "push 0 and shade", PLAN_KEYS, 0, PLAN_WRITE },
                  { "push 0 and shade", PLAN_OUT_DEPTH, PLAN_WRITE, PLAN_WRITE },
                  { "rim near", PLAN_WORK, PLAN_READ, both },
                  { "rim near", PLAN_RIM, PLAN_READ, both },
                  { "rim near", PLAN_KEYS, 0, PLAN_WRITE },
                  { "rim near", PLAN_OUT_DEPTH, both, both },
                  { "project", PLAN_WORK, 0, PLAN_WRITE },
                  { "project", PLAN_TEXEL_CLUSTERS, 0, PLAN_READ },
                  { "rim clusters", PLAN_WORK, 0, both },
                  { "rim clusters", PLAN_LARGE, 0, PLAN_WRITE },
                  { "rim find", PLAN_WORK, 0, both },
                  { "rim find", PLAN_LARGE, 0, both },
                  { "rim find", PLAN_RIM, 0, 0 },
                  { "rim splat", PLAN_LARGE, 0, PLAN_READ },
                  { "rim splat", PLAN_RIM, 0, PLAN_READ },
                  { "rim splat", PLAN_IMAGE_PYRAMID, 0, 0 },
                  { "rim take", PLAN_WORK, 0, both },
                  { "rim take", PLAN_KEYS, 0, PLAN_READ },
                  { "rim take", PLAN_IMAGE_PYRAMID, 0, PLAN_WRITE },
                  { "rim splat", PLAN_KEYS, 0, both },
                  { "rim shade", PLAN_WORK, 0, PLAN_READ },
                  { "rim shade", PLAN_RIM, 0, PLAN_READ },
                  { "rim shade", PLAN_KEYS, 0, PLAN_READ },
                  { "rim shade", PLAN_OUT_DEPTH, 0, both } };
    for (int far = 0; far < 2; far++) {
        struct inputs in = pyramid_inputs();
        in.camera = plain_camera(1000, 700, 500);
        in.scene->facts.radius_max = (far ? 20 : 0.5f) * 3 / 500;
        struct stp_plan *plan = plan_of(&in);
        for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
            unsigned wanted = far ? cases[i].far : cases[i].near;
            if (pass_named(plan, cases[i].pass))
                assert_int_equal(access_of(plan, cases[i].pass, cases[i].slot), wanted);
            else
                assert_int_equal(wanted, 0);
        }
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

static void test_only_what_is_needed(void **state)
{
    struct inputs in = pyramid_inputs();
    struct stp_plan *plan = plan_of(&in);
    assert_null(resource_named(plan, "attributes"));
    assert_null(resource_named(plan, "splats"));
    assert_null(resource_named(plan, "objects"));
    assert_int_equal(resource_named(plan, "points")->bytes, 100 * 16);
    uint64_t plain = resource_named(plan, "pyramid")->bytes;
    stp_plan_destroy(&plan);
    color_inputs(&in);
    plan = plan_of(&in);
    assert_int_equal(resource_named(plan, "attributes")->bytes, plain / 2);
    stp_plan_destroy(&plan);
    in.params.aovs = STP_AOV_ID;
    in.scene->facts.objects = 2;
    plan = plan_of(&in);
    assert_int_equal(resource_named(plan, "attributes")->bytes, plain);
    assert_non_null(resource_named(plan, "objects"));
    stp_plan_destroy(&plan);
    in.params.method = STP_METHOD_EXACT;
    plan = plan_of(&in);
    assert_null(resource_named(plan, "pyramid"));
    assert_int_equal(plan->levels, 0);
    assert_int_equal(plan->constant[PLAN_RIM_FAR], 0);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* The grid is the part of the picture, and a little round it, that the scene can touch. */
static void test_grid(void **state)
{
    struct inputs in = pyramid_inputs();
    in.camera = plain_camera(1000, 700, 300); /* 0.9 wide at depth 3: 90 pixels, and discs of 10 */
    struct stp_plan *plan = plan_of(&in);
    assert_true(plan->grid.width >= 110 && plan->grid.width <= 136);
    assert_true(plan->grid.height >= 110 && plan->grid.height <= 136);
    assert_true(plan->grid.x <= 490 && plan->grid.x % STP_BLOCK == 0);
    stp_plan_destroy(&plan);
    in.camera.far_depth = INFINITY;
    in.camera.world_to_camera[11] = -100; /* the scene is far away, then behind the eye */
    plan = plan_of(&in);
    assert_true(plan->grid.width <= 24);
    stp_plan_destroy(&plan);
    in.camera.world_to_camera[11] = 100;
    plan = plan_of(&in);
    assert_true(plan->grid.width > 0 && plan->grid.height > 0);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* Every texel that a kept pixel is made from lies in its tile's grid, or in no grid at all. */
static void test_tile_grids(void **state)
{
    struct inputs in = pyramid_inputs();
    in.camera = plain_camera(900, 700, 2500);
    in.params.memory_limit = 12 << 20;
    struct stp_plan *plan = plan_of(&in);
    assert_true(plan->tile_count > 1);
    int32_t reach = 1 << plan->levels;
    for (uint32_t i = 0; i < plan->tile_count; i++) {
        const struct plan_tile *t = &plan->tile[i];
        struct plan_grid g = plan_tile_grid(plan, t), all = plan->grid;
        assert_true(g.x <= (int32_t)t->x - reach || g.x == all.x);
        assert_true(g.y <= (int32_t)t->y - reach || g.y == all.y);
        assert_true(g.x + (int32_t)g.width >= (int32_t)(t->x + t->width) + reach ||
                    g.x + g.width == all.x + all.width);
        const struct plan_resource *keys = resource_named(plan, "keys");
        assert_true((uint64_t)g.width * g.height * 8 <= keys->bytes);
    }
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* Points that are more than half of the device's memory come in chunks of a quarter, each whole
 * runs; none is lost, and no other plan has any of it. */
static void test_chunks(void **state)
{
    struct inputs in = pyramid_inputs();
    in.camera = plain_camera(16, 16, 8);
    in.scene->facts.splats = 100000;
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->chunk_count, 0);
    stp_plan_destroy(&plan);
    in.limits.heap_bytes = 40 * 100000;
    plan = plan_of(&in);
    assert_int_equal(plan->chunk_count, 0); /* just a half */
    stp_plan_destroy(&plan);
    for (uint64_t heap = 3900000; heap > 300000; heap = heap * 2 / 3) {
        in.limits.heap_bytes = heap;
        plan = plan_of(&in);
        assert_true(plan->chunk_count >= 2);
        assert_int_equal(plan->chunk[0], 0);
        assert_int_equal(plan->chunk[plan->chunk_count], 100000);
        for (uint32_t i = 0; i < plan->chunk_count; i++) {
            assert_true(plan->chunk[i] < plan->chunk[i + 1]);
            assert_int_equal(plan->chunk[i] % STP_POINT_RUN, 0);
        }
        uint64_t points = resource_named(plan, "points")->bytes;
        assert_true(points / 16 * 20 <= heap / 4);
        assert_int_equal(points, (uint64_t)(plan->chunk[1] - plan->chunk[0]) * 16);
        assert_string_equal(plan->pass[plan->chunk_first].name, "project");
        assert_string_equal(plan->pass[plan->chunk_end - 1].name, "gather");
        assert_non_null(strstr(plan->why, "chunks"));
        stp_plan_destroy(&plan);
    }
    in.limits.heap_bytes = (uint64_t)1 << 31;
    in.limits.max_allocation = 16 * 50000; /* one buffer, not all memory */
    plan = plan_of(&in);
    assert_true(plan->chunk_count >= 2);
    stp_plan_destroy(&plan);
    in.limits.max_allocation = (uint64_t)1 << 31;
    in.limits.max_texels =
        1 << 14; /* points are fetched as texels: whole runs, as many as may be */
    plan = plan_of(&in);
    assert_int_equal(plan->chunk_count, 7);
    for (uint32_t i = 0; i < 7; i++)
        assert_int_equal(plan->chunk[i + 1], i < 6 ? (i + 1) << 14 : 100000);
    stp_plan_destroy(&plan);
    in.limits.max_texels = 100000; /* just enough */
    plan = plan_of(&in);
    assert_int_equal(plan->chunk_count, 0);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void test_without_atomics(void **state)
{
    struct inputs in = pyramid_inputs();
    in.params.mask_features = STP_FEATURE_INT64_ATOMICS;
    struct stp_plan *plan = plan_of(&in);
    assert_null(pass_named(plan, "project"));
    assert_non_null(pass_named(plan, "project depth"));
    assert_non_null(pass_named(plan, "project id"));
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* Clusters are there where some can go, back faces or what lies beyond the picture, or where discs
 * reach far. 32 bytes each. */
static void test_clusters(void **state)
{
    static const struct {
        enum stp_cull cull;
        double focal;
        float radius;
        bool culled, wanted;
    } cases[] = { { STP_CULL_NONE, 300, 0.001f, false, false },
                  { STP_CULL_NONE, 300, 0.1f, false, true },
                  { STP_CULL_BACK, 300, 0.001f, true, true },
                  { STP_CULL_NONE, 30000, 0.00001f, true, true } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct inputs in = pyramid_inputs();
        in.camera = plain_camera(1000, 700, cases[i].focal);
        in.params.cull = cases[i].cull;
        in.scene->facts.radius_max = cases[i].radius;
        struct stp_plan *plan = plan_of(&in);
        const struct plan_resource *clusters = resource_named(plan, "clusters");
        assert_int_equal(plan->constant[PLAN_CULL_CLUSTERS], cases[i].culled);
        assert_int_equal(clusters != NULL, cases[i].wanted);
        if (clusters)
            assert_int_equal(clusters->bytes, (100 + STP_CLUSTER - 1) / STP_CLUSTER * 32);
        stp_plan_destroy(&plan);
        in.params.method = STP_METHOD_EXACT;
        plan = plan_of(&in);
        assert_null(resource_named(plan, "clusters"));
        assert_int_equal(plan->constant[PLAN_CULL_CLUSTERS], 0);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels),   cmocka_unit_test(test_only_what_is_needed),
        cmocka_unit_test(test_grid),     cmocka_unit_test(test_tile_grids),
        cmocka_unit_test(test_chunks),   cmocka_unit_test(test_without_atomics),
        cmocka_unit_test(test_clusters), cmocka_unit_test(test_accesses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
