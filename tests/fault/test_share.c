/* One of several processes whose calls fail, or whose device the host does not see into. The
 * process is the only one, so that its calls come in the same order every time;
 * tests/pass/test_share.c has several. */
#include "subject.h"

#include <stipple/machines.h>

#include "base/memory.h"

/* What was agreed last: once it is a failure nobody may ask again. */
struct alone {
    enum stp_result agreed;
    unsigned asked_again;
};

static enum stp_result agree(void *user, enum stp_result mine)
{
    struct alone *alone = user;
    alone->asked_again += alone->agreed != STP_OK;
    alone->agreed = mine;
    return mine;
}

static void reduce(void *user, enum stp_reduction reduction, int64_t *values, size_t count,
                   bool to_all)
{
    struct alone *alone = user;
    alone->asked_again += alone->agreed != STP_OK;
}

static const struct way two_pass = { "two-pass by compute",
                                     { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE } };

static enum stp_result render_share(struct subject *s, struct stp_image **image)
{
    struct alone alone = { 0 };
    struct stp_machines machines = { 0, 1, &alone, agree, reduce };
    s->device.lines = 0;
    enum stp_result result = stp_render_share(&s->device.env, s->device.context, s->scene, s->plan,
                                              &machines, 0, image, NULL);
    subject_rendered(s);
    assert_int_equal(alone.asked_again, 0);
    assert_int_equal(alone.agreed, result);
    assert_int_equal(s->device.context->allocated, 0);
    return result;
}

/* The whole scene's picture, and the same scene shared by one. */
static void open_shared(struct subject *s, struct stp_scene *scene)
{
    struct stp_render_params params = s->plan->params;
    struct stp_camera camera = s->plan->camera;
    stp_plan_destroy(&s->plan);
    assert_int_equal(stp_scene_share(NULL, scene, 0, 1), STP_OK);
    assert_int_equal(device_plan(&s->device, scene, &camera, &params, &s->plan), STP_OK);
}

static void expect_failure(struct subject *s, enum stp_result got, const struct stp_image *image)
{
    struct fault_state seen = s->fault.read();
    if (got == STP_OK || image || s->device.lines != 1)
        fail_msg("%s failing: %s, %u lines, the last: %s", seen.injected, stp_result_text(got),
                 s->device.lines, s->device.last);
}

/* False: none was made to fail, and the picture is whole. */
static bool fail_call(struct subject *s, unsigned long n)
{
    struct stp_image *image = NULL;
    s->fault.arm(n, (unsigned)n, true);
    enum stp_result result = render_share(s, &image);
    bool injected = s->fault.read().injected[0] != 0;
    no_misuse(&s->fault, s->what, s->live);
    if (injected)
        expect_failure(s, result, image);
    else
        expect_same_bits(image, s->image, "shared by one");
    s->fault.arm(0, 0, false);
    stp_image_destroy(&image);
    return injected;
}

static bool fail_allocation(struct subject *s, unsigned long n)
{
    struct stp_image *image = NULL;
    mem_fail_at(n);
    enum stp_result result = render_share(s, &image);
    mem_fail_at(0);
    bool failed = !image;
    no_misuse(&s->fault, s->what, s->live);
    if (failed)
        expect_failure(s, result, image);
    stp_image_destroy(&image);
    return failed;
}

typedef bool fail_fn(struct subject *s, unsigned long n);

/* The n-th of all; of a cold context's up to its pipelines, which the warm one has. */
static void fail_each(fail_fn *fail_at, struct stp_scene *scene, unsigned long least)
{
    struct subject s;
    struct stp_image *image = NULL;
    unsigned long cold = 1, warm = 1;
    subject_open(&s, scene, &two_pass, 0);
    open_shared(&s, scene);
    while (fail_at(&s, cold) && !s.made)
        cold++;
    s.warm = true;
    assert_int_equal(render_share(&s, &image), STP_OK);
    s.live = s.fault.read().live;
    while (fail_at(&s, warm))
        warm++;
    assert_true(cold > least && warm > least);
    stp_image_destroy(&image);
    subject_close(&s);
}

static void fail_all(bool out_of_sight)
{
    struct stp_scene *scene = small_scene();
    find_faults().discrete(out_of_sight);
    fail_each(fail_call, scene, 30);
    stp_scene_destroy(&scene);
    scene = small_scene();
    fail_each(fail_allocation, scene, 2);
    stp_scene_destroy(&scene);
    find_faults().discrete(false);
}

static void test_mapped(void **state)
{
    fail_all(false);
}

static void test_out_of_sight(void **state)
{
    fail_all(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mapped),
        cmocka_unit_test(test_out_of_sight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
