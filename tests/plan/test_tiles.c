/* Tiles: every pixel kept exactly once, margins where neighbours are read, all within the limit. */
#include "plans.h"

static void check_tile(const struct stp_plan *plan, const struct plan_tile *t, uint32_t reach)
{
    uint32_t w = plan->camera.width, h = plan->camera.height;
    uint32_t right = t->x + t->width, bottom = t->y + t->height;
    assert_true(t->width > 0 && t->width <= plan->tile_width && right <= w);
    assert_true(t->height > 0 && t->height <= plan->tile_height && bottom <= h);
    assert_true(t->keep[0] < t->keep[2] && t->keep[1] < t->keep[3]);
    assert_true(t->x + reach <= t->keep[0] || t->x == 0);
    assert_true(t->y + reach <= t->keep[1] || t->y == 0);
    assert_true(t->keep[2] + reach <= right || (right == w && t->keep[2] <= right));
    assert_true(t->keep[3] + reach <= bottom || (bottom == h && t->keep[3] <= bottom));
}

/* Kept rectangles that lie within the picture, do not overlap and have its area are a partition. */
static void check_partition(const struct stp_plan *plan)
{
    uint64_t area = 0;
    for (uint32_t i = 0; i < plan->tile_count; i++) {
        const uint32_t *a = plan->tile[i].keep;
        area += (uint64_t)(a[2] - a[0]) * (a[3] - a[1]);
        for (uint32_t k = 0; k < i && plan->tile_count < 3000; k++) {
            const uint32_t *b = plan->tile[k].keep;
            assert_true(a[0] >= b[2] || b[0] >= a[2] || a[1] >= b[3] || b[1] >= a[3]);
        }
    }
    assert_int_equal(area, (uint64_t)plan->camera.width * plan->camera.height);
}

static void check_tiles(struct inputs *in, uint32_t width, uint32_t height, uint64_t limit)
{
    struct plan_log log = { 0 };
    struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct stp_plan *plan = NULL;
    in->camera.width = width;
    in->camera.height = height;
    in->params.memory_limit = limit;
    enum stp_result result =
        stp_plan_create(&env, in->scene, &in->camera, &in->params, &in->limits, &plan);
    if (result != STP_OK) { /* not even 8 x 8 pixels and their margins fit */
        assert_int_equal(result, STP_ERROR_DEVICE_MEMORY);
        assert_true(limit != 0 && limit < 2 << 20);
        assert_int_equal(log.lines, 1);
        return;
    }
    uint32_t reach = height / 512 > 1 ? height / 512 : 1;
    for (uint32_t i = 0; i < plan->tile_count; i++)
        check_tile(plan, &plan->tile[i], in->scene->facts.eye_dome ? reach : 0);
    check_partition(plan);
    struct stp_plan_summary s;
    stp_plan_summarize(plan, &s);
    assert_true(limit == 0 || s.transient_bytes + s.output_bytes <= limit);
    assert_true((uint64_t)plan->tile_width * plan->tile_height <= 1 << 22);
    assert_true(plan->tile_width <= in->limits.max_image_size);
    stp_plan_destroy(&plan);
}

static void test_partition(void **state)
{
    static const uint32_t sizes[][2] = { { 1, 1 },      { 1, 777 },     { 901, 1 },
                                         { 8, 8 },      { 17, 9 },      { 33, 47 },
                                         { 1280, 720 }, { 1021, 1031 }, { 16384, 64 },
                                         { 20000, 31 }, { 4099, 2053 }, { 64, 65536 } };
    static const uint64_t limits[] = { 0, 40 << 20, 4 << 20, 1 << 20, 100 << 10, 1 << 10 };
    for (unsigned s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (unsigned l = 0; l < sizeof limits / sizeof *limits; l++)
            for (int kind = 0; kind < 6; kind++) {
                struct inputs in = plain_inputs();
                in.params.method = kind % 3 == 0   ? STP_METHOD_EXACT
                                   : kind % 3 == 1 ? STP_METHOD_DEFERRED
                                                   : STP_METHOD_TWO_PASS;
                in.params.path = kind % 3 == 0 ? STP_PATH_AUTO : STP_PATH_RASTER;
                in.scene->facts.eye_dome = kind >= 3;
                uint64_t pixels = (uint64_t)sizes[s][0] * sizes[s][1];
                if (limits[l] == 0 || pixels / 64 < limits[l] / 1024 * 4)
                    check_tiles(&in, sizes[s][0], sizes[s][1], limits[l]);
                release_inputs(&in);
            }
}

static void test_one_tile_where_it_fits(void **state)
{
    struct inputs in = plain_inputs();
    in.params.method = STP_METHOD_TWO_PASS;
    in.camera.width = in.camera.height = 2048;
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->tile_count, 1);
    assert_int_equal(plan->tile_width, 2048);
    stp_plan_destroy(&plan);
    in.camera.width = 2049;
    plan = plan_of(&in);
    assert_int_equal(plan->tile_count, 2);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* Slots that are fetched as texels are no more than a device must hold of those. */
static void test_texels(void **state)
{
    for (int fetched = 0; fetched < 2; fetched++) {
        struct inputs in = plain_inputs();
        in.params.method = STP_METHOD_EXACT;
        in.params.mask_features = fetched ? 0 : STP_FEATURE_TEXEL_BUFFERS;
        in.limits.heap_bytes = in.limits.max_allocation = (uint64_t)1 << 34;
        in.camera.width = in.camera.height = 2048;
        struct stp_plan *plan = plan_of(&in);
        const struct plan_resource *slots = &plan->resource[plan_find(plan, PLAN_KEYS)];
        assert_int_equal(slots->format, fetched ? PLAN_TEXELS_RG32UI : PLAN_BUFFER);
        assert_true(!fetched || slots->bytes / 8 <= in.limits.max_texels);
        assert_int_equal(plan->tile_count, fetched ? 2 : 1);
        stp_plan_destroy(&plan);
        in.limits.max_texels = 1 << 24; /* of a smaller device: more tiles, if it is fetched */
        plan = plan_of(&in);
        slots = &plan->resource[plan_find(plan, PLAN_KEYS)];
        assert_true(!fetched || slots->bytes / 8 <= 1 << 24);
        assert_true(fetched ? plan->tile_count >= 16 : plan->tile_count == 1);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* The device's own limits cut as well: its heap, its largest allocation and image. */
static void test_limits_of_the_device(void **state)
{
    for (int i = 0; i < 3; i++) {
        struct inputs in = plain_inputs();
        in.camera.width = in.camera.height = 512;
        in.params.path = STP_PATH_RASTER;
        in.params.method = STP_METHOD_DEFERRED;
        if (i == 0)
            in.limits.heap_bytes = 8 << 20;
        else if (i == 1)
            in.limits.max_allocation = 1 << 20;
        else
            in.limits.max_image_size = 200;
        struct stp_plan *plan = plan_of(&in);
        assert_true(plan->tile_count > 1);
        for (uint32_t r = 0; r < plan->resource_count; r++)
            assert_true(plan->resource[r].bytes <= in.limits.max_allocation);
        check_partition(plan);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* What the device cannot hold is left to the CPU where no method is asked for, and said. */
static void test_too_large_for_the_device(void **state)
{
    for (int allocation = 0; allocation < 2; allocation++) {
        struct inputs in = plain_inputs();
        if (allocation)
            in.limits.max_allocation = 100 * 32 - 1;
        else
            in.limits.heap_bytes = 100 * 32;
        struct stp_plan *plan = plan_of(&in);
        assert_int_equal(plan->method, STP_METHOD_REFERENCE);
        assert_int_equal(plan->resource_count + plan->pass_count + plan->tile_count, 0);
        assert_non_null(strstr(plan->why, "100 splats are more than the device"));
        stp_plan_destroy(&plan);
        in.params.method = STP_METHOD_TWO_PASS;
        struct plan_log log = { 0 };
        struct stp_env env = { .log = plan_keep_line, .user = &log };
        assert_int_equal(stp_plan_create(&env, in.scene, &in.camera, &in.params, &in.limits, &plan),
                         STP_ERROR_DEVICE_MEMORY);
        assert_null(plan);
        assert_int_equal(log.lines, 1);
        assert_non_null(strstr(log.last, "the scene takes"));
        release_inputs(&in);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_partition),
        cmocka_unit_test(test_texels),
        cmocka_unit_test(test_one_tile_where_it_fits),
        cmocka_unit_test(test_limits_of_the_device),
        cmocka_unit_test(test_too_large_for_the_device),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
