/* The positive control: what every other program of tests/pass relies on, namely that validation
 * and synchronisation validation would speak. */
#include "device.h"

#include "record/record.h"
#include "scene/scene.h"

/* Records the plan with one barrier left out; nothing is submitted. Returns the messages. */
static unsigned messages_without(struct device *device, const struct stp_scene *scene,
                                 const struct stp_plan *plan, uint32_t skipped)
{
    struct record_frame frame;
    struct stp_context *c = device->context;
    unsigned before = c->messages;
    c->env = &device->env;
    assert_int_equal(record_frame_create(&device->env, c, plan, &frame), STP_OK);
    assert_int_equal(record_upload(&device->env, &frame, scene), STP_OK);
    assert_int_equal(gpu_begin(&device->env, c), STP_OK);
    record_walk(&frame, c->commands, &plan->tile[0], 0, false, skipped);
    c->vk.vkEndCommandBuffer(c->commands);
    record_frame_destroy(&frame);
    c->env = NULL;
    return c->messages - before;
}

static uint32_t find_pass(const struct stp_plan *plan, const char *name, unsigned which)
{
    for (uint32_t i = 0; i < plan->pass_count; i++)
        if (strcmp(plan->pass[i].name, name) == 0 && which-- == 0)
            return i;
    fail_msg("no pass %s", name);
    return 0;
}

static void expect_hazard(struct stp_render_params params, const char *pass, unsigned which,
                          const char *hazard)
{
    struct device device;
    struct stp_scene *scene = scene_random(41, 8, 0.05);
    struct stp_camera camera = hard_view(0, 16, 16);
    struct stp_plan *plan = NULL;
    device_open(&device, 0);
    scene_own_groups(scene);
    assert_int_equal(device_plan(&device, scene, &camera, &params, &plan), STP_OK);
    assert_int_equal(messages_without(&device, scene, plan, RECORD_NO_PASS), 0);
    unsigned messages = messages_without(&device, scene, plan, find_pass(plan, pass, which));
    if (messages == 0 || !strstr(device.last, hazard))
        fail_msg("without the barrier before \"%s\": %u messages, the last: %s", pass, messages,
                 device.last);
    /* From now on every render of the context is a failure. */
    struct stp_image *image = NULL;
    assert_int_equal(stp_render(&device.env, device.context, scene, plan, 0, &image, NULL),
                     STP_ERROR_VALIDATION);
    assert_null(image);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    stp_context_destroy(&device.context);
}

/* The reset of the indirect arguments, then their being read. */
static void test_write_then_indirect_read(void **state)
{
    expect_hazard((struct stp_render_params){ .method = STP_METHOD_EXACT }, "slots", 0,
                  "READ-AFTER-WRITE");
}

/* Arguments that were read, then reset for the second geometry pass. */
static void test_indirect_read_then_write(void **state)
{
    expect_hazard(
        (struct stp_render_params){ .method = STP_METHOD_DEFERRED, .voronoi = STP_VORONOI_EXACT },
        "reset arguments", 1, "AFTER");
}

/* The same from one sample to the next. */
static void test_sample_after_sample(void **state)
{
    expect_hazard((struct stp_render_params){ .method = STP_METHOD_EXACT, .samples = 4 },
                  "reset arguments", 0, "AFTER");
}

/* Misuse of the API: a dispatch that no pipeline was bound for. */
static void test_misuse(void **state)
{
    struct device device;
    device_open(&device, 0);
    struct stp_context *c = device.context;
    c->env = &device.env;
    assert_int_equal(gpu_begin(&device.env, c), STP_OK);
    assert_int_equal(c->messages, 0);
    c->vk.vkCmdDispatch(c->commands, 1, 1, 1);
    c->vk.vkEndCommandBuffer(c->commands);
    assert_true(c->messages > 0);
    assert_non_null(strstr(device.last, "VUID"));
    c->env = NULL;
    stp_context_destroy(&device.context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_write_then_indirect_read),
        cmocka_unit_test(test_indirect_read_then_write),
        cmocka_unit_test(test_sample_after_sample),
        cmocka_unit_test(test_misuse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
