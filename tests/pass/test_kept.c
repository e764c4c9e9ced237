/* Pipelines that a context keeps: what is alike shares them, what is not does not, they are few,
 * and a picture is the same whether its pipelines are new or kept. */
#include "device.h"

#include "fault/ways.h"
#include "record/record.h"

static unsigned kept(const struct device *device)
{
    unsigned count = 0;
    for (const struct gpu_kept *k = device->context->kept; k; k = k->next) {
        assert_int_equal(k->users, 0); /* nothing is being rendered */
        count++;
    }
    return count;
}

static const struct record_pipelines *last(const struct device *device)
{
    assert_non_null(device->context->kept);
    return (const struct record_pipelines *)device->context->kept;
}

/* All ways twice, in turns: the second time finds the pipelines of the first. */
static void test_same_picture(void **state)
{
    struct device device;
    struct stp_image *first[WAYS];
    struct stp_camera camera = hard_view(0, 48, 40);
    struct stp_scene *scene = scene_random(5, 40, 0.1);
    scene_own_groups(scene);
    device_open(&device, 0);
    for (unsigned i = 0; i < WAYS; i++) {
        gpu_trim(device.context);
        assert_null(device.context->kept);
        first[i] = device_render(&device, scene, &camera, &ways[i].params);
    }
    for (unsigned turn = 0; turn < 2; turn++)
        for (unsigned i = 0; i < WAYS; i++) {
            struct stp_image *again = device_render(&device, scene, &camera, &ways[i].params);
            expect_same_bits(again, first[i], ways[i].name);
            stp_image_destroy(&again);
        }
    for (unsigned i = 0; i < WAYS; i++)
        stp_image_destroy(&first[i]);
    device_close(&device);
    stp_scene_destroy(&scene);
}

static void draw_once(struct device *device, const struct stp_scene *scene, uint32_t width,
                      const struct stp_render_params *params)
{
    struct stp_camera camera = hard_view(0, width, 24);
    struct stp_image *image = device_render(device, scene, &camera, params);
    stp_image_destroy(&image);
}

static void test_alike(void **state)
{
    struct device device;
    const struct stp_render_params exact = { .method = STP_METHOD_EXACT };
    struct stp_scene *scene = scene_random(6, 20, 0.1), *other = scene_random(7, 30, 0.2);
    device_open(&device, 0);
    draw_once(&device, scene, 24, &exact);
    const struct record_pipelines *made = last(&device);
    draw_once(&device, scene, 40, &exact);
    draw_once(&device, other, 24, &exact);
    assert_int_equal(kept(&device), 1);
    assert_ptr_equal(last(&device), made);
    /* One constant, and the layouts, are not the same. */
    struct stp_render_params culled = exact, rich = exact;
    culled.cull = STP_CULL_BACK;
    rich.aovs = STP_AOV_ID;
    draw_once(&device, scene, 24, &culled);
    assert_int_equal(kept(&device), 2);
    draw_once(&device, scene, 24, &rich);
    assert_int_equal(kept(&device), 3);
    draw_once(&device, scene, 24, &exact);
    assert_int_equal(kept(&device), 3);
    assert_ptr_equal(last(&device), made); /* the last used comes first */
    device_close(&device);
    stp_scene_destroy(&scene);
    stp_scene_destroy(&other);
}

/* Every group of `deferred` by raster is a draw of its own, and all have one pipeline. */
static void test_passes_alike(void **state)
{
    struct device device;
    const struct stp_render_params raster = { .method = STP_METHOD_DEFERRED,
                                              .path = STP_PATH_RASTER };
    struct stp_camera camera = hard_view(0, 24, 24);
    struct stp_scene *scene = scene_random(8, 12, 0.1);
    struct stp_plan *plan = NULL;
    scene_own_groups(scene);
    device_open(&device, 0);
    assert_int_equal(device_plan(&device, scene, &camera, &raster, &plan), STP_OK);
    struct stp_image *image = device_render_plan(&device, scene, plan);
    VkPipeline draw = VK_NULL_HANDLE;
    unsigned draws = 0;
    for (uint32_t i = 0; i < plan->pass_count; i++) {
        if (plan->pass[i].kind != PLAN_DRAW)
            continue;
        VkPipeline here = last(&device)->pipeline[i];
        assert_true(here != VK_NULL_HANDLE && (!draw || here == draw));
        draw = here;
        draws++;
    }
    assert_int_equal(draws, 12);
    stp_image_destroy(&image);
    stp_plan_destroy(&plan);
    device_close(&device);
    stp_scene_destroy(&scene);
}

/* More kinds of pictures than a context keeps pipelines for; in use, any number stays. */
static void test_few(void **state)
{
    struct device device;
    struct stp_render_params params = { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE };
    struct stp_scene *scene = scene_random(9, 12, 0.1);
    device_open(&device, 0);
    draw_once(&device, scene, 24, &params);
    struct gpu_kept *first = device.context->kept;
    gpu_use_kept(device.context, first);
    for (unsigned i = 1; i < GPU_MOST_IDLE + 4; i++) {
        params.cull = i & 1 ? STP_CULL_BACK : STP_CULL_NONE;
        params.aovs = (i >> 1 & 1 ? STP_AOV_ID : 0) | (i >> 2 & 1 ? STP_AOV_ALBEDO : 0);
        params.min_splat = i >> 3 & 1 ? -1 : 0;
        params.samples = i >> 4 & 1 ? 4 : 1;
        draw_once(&device, scene, 24, &params);
    }
    unsigned count = 0;
    bool found = false;
    for (struct gpu_kept *k = device.context->kept; k; k = k->next, count++)
        found |= k == first;
    assert_true(found);
    assert_int_equal(count, GPU_MOST_IDLE + 1);
    gpu_leave_kept(device.context, first);
    assert_int_equal(kept(&device), GPU_MOST_IDLE);
    device_close(&device);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_picture),
        cmocka_unit_test(test_alike),
        cmocka_unit_test(test_passes_alike),
        cmocka_unit_test(test_few),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
