/* Every Vulkan call and every allocation of a render made to fail in turn, for every way to a
 * picture: the right result, one line, nothing left alive, no picture; and the context renders as
 * before afterwards. */
#include "subject.h"

#include "base/memory.h"
#include "pass/ellipses.h"
#include "ranges.h"

/* What a caller gets for the VkResult. */
static enum stp_result wanted(VkResult result)
{
    return result == VK_ERROR_OUT_OF_HOST_MEMORY     ? STP_ERROR_MEMORY
           : result == VK_ERROR_OUT_OF_DEVICE_MEMORY ? STP_ERROR_DEVICE_MEMORY
                                                     : STP_ERROR_DEVICE;
}

/* Pipelines are made by workers that say nothing; what failed there is tried once more. */
static bool is_retried(const char *name)
{
    return strcmp(name, "vkCreateShaderModule") == 0 ||
           strcmp(name, "vkCreateComputePipelines") == 0 ||
           strcmp(name, "vkCreateGraphicsPipelines") == 0;
}

static void expect_success(struct subject *s, struct stp_image **image)
{
    assert_int_equal(s->device.lines, 0);
    expect_same_bits(*image, s->image, s->what);
    stp_image_destroy(image);
}

static void expect_failure(struct subject *s, enum stp_result got, enum stp_result want)
{
    struct fault_state seen = s->fault.read();
    if (got != want || s->device.lines != 1)
        fail_msg("%s, %s gives VkResult %d: %s, %u lines, the last: %s", s->what, seen.injected,
                 seen.result, stp_result_text(got), s->device.lines, s->device.last);
}

/* False: no call was made to fail. */
static bool fail_call(struct subject *s, unsigned long n, unsigned choice, bool sticky)
{
    struct stp_image *image = NULL;
    s->fault.arm(n, choice, sticky);
    enum stp_result result = subject_render(s, &image);
    struct fault_state seen = s->fault.read();
    if (result == STP_OK && (!seen.injected[0] || (!sticky && is_retried(seen.injected))))
        expect_success(s, &image);
    else
        expect_failure(s, result, wanted(seen.result));
    assert_null(image);
    s->fault.arm(0, 0, false);
    assert_int_equal(s->device.context->allocated, 0);
    no_misuse(&s->fault, s->what, s->live);
    return seen.injected[0] != 0;
}

/* Sticky, the call fails for good, which no second try mends. */
static void fail_every_call(const struct stp_scene *scene, const struct way *way, bool sticky,
                            unsigned repeat)
{
    struct subject s;
    unsigned long cold = 1, warm = 1;
    subject_open(&s, scene, way, repeat);
    while (fail_call(&s, cold, (unsigned)cold, sticky) && !s.made)
        cold++;
    subject_warm(&s);
    while (fail_call(&s, warm, (unsigned)warm, sticky))
        warm++;
    assert_true(way->params.method == STP_METHOD_REFERENCE || (cold > 30 && warm > 30));
    subject_close(&s);
}

static void test_every_way(void **state)
{
    struct stp_scene *scene = small_scene();
    for (unsigned i = 0; i < WAYS; i++)
        fail_every_call(scene, &ways[i], true, 0);
    stp_scene_destroy(&scene);
}

/* False: none was made to fail. */
static bool fail_allocation(struct subject *s, unsigned long n)
{
    struct stp_image *image = NULL;
    mem_fail_at(n);
    enum stp_result result = subject_render(s, &image);
    mem_fail_at(0);
    assert_int_equal(s->device.context->allocated, 0);
    no_misuse(&s->fault, s->what, s->live);
    if (!image) {
        expect_failure(s, result, STP_ERROR_MEMORY);
        return true;
    }
    expect_success(s, &image);
    return false;
}

static void fail_every_allocation(const struct stp_scene *scene, const struct way *way)
{
    struct subject s;
    unsigned long n = 1;
    subject_open(&s, scene, way, 1);
    while (fail_allocation(&s, n) && !s.made)
        n++;
    subject_warm(&s);
    n = 1;
    while (fail_allocation(&s, n))
        n++;
    subject_close(&s);
}

static void test_every_allocation(void **state)
{
    struct stp_scene *scene = small_scene();
    for (unsigned i = 0; i < WAYS; i++)
        fail_every_allocation(scene, &ways[i]);
    stp_scene_destroy(&scene);
}

static const struct way compute = { "two-pass by compute",
                                    { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE } };
static const struct way raster = { "deferred by raster",
                                   { .method = STP_METHOD_DEFERRED, .path = STP_PATH_RASTER } };

/* A call that fails once, and frames that are timed. */
static void test_once(void **state)
{
    struct stp_scene *scene = small_scene();
    fail_every_call(scene, &compute, false, 1);
    fail_every_call(scene, &raster, false, 0);
    stp_scene_destroy(&scene);
}

/* Staging buffers, copies and read-back, which a software device never needs. */
static void test_out_of_sight(void **state)
{
    struct stp_scene *scene = small_scene();
    find_faults().discrete(true);
    fail_every_call(scene, &compute, true, 0);
    fail_every_call(scene, &raster, true, 0);
    fail_every_allocation(scene, &raster);
    find_faults().discrete(false);
    stp_scene_destroy(&scene);
}

/* Ellipses and their clip lines have uploads of their own, mapped and staged. */
static void test_ellipses(void **state)
{
    struct stp_scene *scene = random_scene(61, 12, true);
    scene_own_groups(scene);
    assert_true(scene->facts.phong > 0 && scene->facts.clip_lines > 0);
    fail_every_allocation(scene, &compute);
    find_faults().discrete(true);
    fail_every_allocation(scene, &raster);
    find_faults().discrete(false);
    stp_scene_destroy(&scene);
}

/* Volumes and range images have kernels and lists of their own, made again for every frame. */
static void test_media(void **state)
{
    static const struct way lists = { "axis lists",
                                      { .method = STP_METHOD_AXIS, .path = STP_PATH_COMPUTE } };
    struct range range = random_range(5, 2, 4, 0.05);
    struct stp_scene *scenes[] = {
        block_scene((uint32_t[]){ 3, 2, 3 }, (double[]){ 0.3, 0.3, 0.3 }, 0.5),
        range_scene(&range),
    };
    for (int i = 0; i < 2; i++) {
        fail_every_call(scenes[i], &lists, true, 1);
        fail_every_allocation(scenes[i], &lists);
        stp_scene_destroy(&scenes[i]);
    }
}

/* The picture does not depend on whether the host sees the device's memory. */
static void test_same_picture_out_of_sight(void **state)
{
    struct fault_controls fault = find_faults();
    struct stp_scene *scene = small_scene();
    for (unsigned i = 0; i < WAYS; i++) {
        struct subject mapped, copied;
        subject_open(&mapped, scene, &ways[i], 0);
        struct stp_image *image = mapped.image;
        mapped.image = NULL;
        subject_close(&mapped); /* one device at a time: the loader keeps one */
        fault.discrete(true);
        subject_open(&copied, scene, &ways[i], 0);
        expect_same_bits(copied.image, image, ways[i].name);
        subject_close(&copied);
        fault.discrete(false);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

static const struct CMUnitTest calls[] = {
    cmocka_unit_test(test_every_way),
};
static const struct CMUnitTest more[] = {
    cmocka_unit_test(test_every_allocation),
    cmocka_unit_test(test_once),
    cmocka_unit_test(test_out_of_sight),
    cmocka_unit_test(test_ellipses),
    cmocka_unit_test(test_media),
    cmocka_unit_test(test_same_picture_out_of_sight),
};

/* With an argument, the second half: each takes seconds. */
int main(int argc, char **argv)
{
    return argc > 1 ? cmocka_run_group_tests(more, NULL, NULL)
                    : cmocka_run_group_tests(calls, NULL, NULL);
}
