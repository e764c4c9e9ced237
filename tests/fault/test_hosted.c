/* A host's frames, through the stand-in loader: recording makes no object and waits for nothing,
 * and every call of what comes before it may fail, with any result that the specification allows it
 * and as a lost device. */
#include "subject.h"

#include "base/memory.h"
#include "pass/ellipses.h"
#include "record/resident.h"

#define WIDTH   40
#define HEIGHT  24
#define RESULTS 4 /* as many as any call has, and a lost device */

/* The host: the device of a context of our own, whose commands it records and never submits. */
struct host {
    struct fault_controls fault;
    struct device device; /* its lines */
    struct stp_context *own;
    struct stp_import import;
    struct stp_vulkan_features features;
    VkImage image[2]; /* colour, depth */
    VkImageView view[2];
    VkDeviceMemory memory[2];
};

static void make_image(struct host *h, unsigned i, VkFormat format, VkImageUsageFlags usage,
                       VkImageAspectFlags aspect)
{
    const struct gpu_device_functions *vk = &h->own->vk;
    VkDevice device = h->own->device;
    VkImageCreateInfo info = { .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = format,
                               .extent = { WIDTH, HEIGHT, 1 },
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = usage };
    VkMemoryRequirements needs;
    assert_int_equal(vk->vkCreateImage(device, &info, NULL, &h->image[i]), VK_SUCCESS);
    vk->vkGetImageMemoryRequirements(device, h->image[i], &needs);
    VkMemoryAllocateInfo memory = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                    .allocationSize = needs.size };
    assert_int_equal(vk->vkAllocateMemory(device, &memory, NULL, &h->memory[i]), VK_SUCCESS);
    assert_int_equal(vk->vkBindImageMemory(device, h->image[i], h->memory[i], 0), VK_SUCCESS);
    VkImageViewCreateInfo view = { .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = h->image[i],
                                   .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                   .format = format,
                                   .subresourceRange = { aspect, 0, 1, 0, 1 } };
    assert_int_equal(vk->vkCreateImageView(device, &view, NULL, &h->view[i]), VK_SUCCESS);
}

static void host_open(struct host *h)
{
    const struct stp_context_params params = { 0 };
    struct stp_vulkan_features supported;
    *h = (struct host){ .fault = find_faults() };
    device_silent(&h->device);
    h->fault.arm(0, 0, false);
    assert_int_equal(stp_context_create(NULL, &params, &h->own), STP_OK);
    stp_vulkan_wanted_features(NULL, &supported);
    h->own->instance.vk.vkGetPhysicalDeviceFeatures2(h->own->physical, &supported.core);
    stp_vulkan_wanted_features(&supported, &h->features);
    h->import = (struct stp_import){
        .get_instance_proc_addr = h->own->instance.global.vkGetInstanceProcAddr,
        .instance = h->own->instance.handle,
        .physical_device = h->own->physical,
        .device = h->own->device,
        .queue_family = h->own->family,
        .api_version = VK_API_VERSION_1_3,
        .features = &h->features.core,
    };
    make_image(h, 0, VK_FORMAT_R16G16B16A16_SFLOAT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
               VK_IMAGE_ASPECT_COLOR_BIT);
    make_image(h, 1, VK_FORMAT_D32_SFLOAT,
               VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
               VK_IMAGE_ASPECT_DEPTH_BIT);
}

static void host_close(struct host *h)
{
    for (int i = 0; i < 2; i++) {
        h->own->vk.vkDestroyImageView(h->own->device, h->view[i], NULL);
        h->own->vk.vkDestroyImage(h->own->device, h->image[i], NULL);
        h->own->vk.vkFreeMemory(h->own->device, h->memory[i], NULL);
    }
    stp_context_destroy(&h->own);
    no_misuse(&h->fault, "host", 0);
}

static struct stp_targets targets_of(const struct host *h)
{
    struct stp_targets targets = {
        .width = WIDTH, .height = HEIGHT, .depth_near = 0.1, .depth_far = INFINITY
    };
    struct stp_host_image *images[] = { &targets.color, &targets.depth };
    for (int i = 0; i < 2; i++)
        *images[i] = (struct stp_host_image){ .image = h->image[i],
                                              .view = h->view[i],
                                              .before = VK_IMAGE_LAYOUT_UNDEFINED,
                                              .after = VK_IMAGE_LAYOUT_GENERAL };
    return targets;
}

/* All that a host makes of stipple. */
struct made {
    struct stp_context *context;
    struct stp_plan *plan;
    struct stp_resident *resident;
    struct stp_frame *frame;
};

static const struct stp_host_frame_params formats = { .color_format = VK_FORMAT_R16G16B16A16_SFLOAT,
                                                      .depth_format = VK_FORMAT_D32_SFLOAT };

static enum stp_result make(struct host *h, const struct stp_scene *scene,
                            const struct stp_render_params *params, struct made *m)
{
    const struct stp_env *env = &h->device.env;
    struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
    enum stp_result result = stp_context_import(env, &h->import, &m->context);
    if (result == STP_OK)
        result =
            stp_plan_create(env, scene, &camera, params, stp_context_limits(m->context), &m->plan);
    if (result == STP_OK)
        result = stp_resident_create(env, m->context, scene, m->plan, NULL, &m->resident);
    if (result == STP_OK)
        result = stp_frame_create(env, m->context, m->plan, &formats, &m->frame);
    return result;
}

static void unmake(struct made *m)
{
    stp_frame_destroy(&m->frame);
    stp_resident_destroy(&m->resident);
    stp_plan_destroy(&m->plan);
    stp_context_destroy(&m->context);
}

static struct stp_scene *faded_scene(void)
{
    struct stp_scene *scene = small_scene();
    scene->facts.transparent = scene->facts.uniform_opacity = true;
    scene->facts.opacity_min = 0.5f;
    return scene;
}

/* Recording: not a call that makes, takes, submits or waits, nor one of the heap. */
static void expect_quiet(struct host *h, const struct stp_scene *scene, const struct way *way)
{
    const struct gpu_device_functions *vk = &h->own->vk;
    VkCommandBufferBeginInfo begin = { .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO };
    struct stp_targets targets = targets_of(h);
    struct made made = { 0 };
    assert_int_equal(make(h, scene, &way->params, &made), STP_OK);
    assert_int_equal(vk->vkResetCommandPool(h->own->device, h->own->pool, 0), VK_SUCCESS);
    assert_int_equal(vk->vkBeginCommandBuffer(h->own->commands, &begin), VK_SUCCESS);
    assert_int_equal(
        stp_resident_record_upload(NULL, made.resident, h->own->commands, h->own->family), STP_OK);
    unsigned live = h->fault.read().live;
    h->fault.arm(0, 0, false);
    mem_fail_at(1);
    for (unsigned i = 0; i < 3; i++) {
        struct stp_camera camera = hard_view((int)i, WIDTH - i, HEIGHT - 2 * i);
        enum stp_result result = stp_frame_record(&h->device.env, made.frame, made.resident,
                                                  &camera, &targets, h->own->commands);
        if (result != STP_OK)
            fail_msg("%s: %s", way->name, h->device.last);
    }
    unsigned long allocations = mem_count();
    mem_fail_at(0);
    struct fault_state seen = h->fault.read();
    if (seen.calls || seen.live != live || allocations)
        fail_msg("%s: recording made %lu calls that may fail, %d objects and %lu allocations",
                 way->name, seen.calls, (int)seen.live - (int)live, allocations);
    assert_int_equal(vk->vkEndCommandBuffer(h->own->commands), VK_SUCCESS);
    unmake(&made);
}

static bool is_hosted(const struct way *way)
{
    return way->params.method != STP_METHOD_REFERENCE && way->params.method != STP_METHOD_PYRAMID &&
           way->params.method != STP_METHOD_AXIS;
}

static void test_recording(void **state)
{
    const struct way more[] = {
        { "samples", { .method = STP_METHOD_EXACT, .samples = 9 } },
        { "tiles", { .method = STP_METHOD_EXACT, .memory_limit = 400000 } },
    };
    const struct way layers[] = {
        { "layers", { .method = STP_METHOD_EXACT } },
        { "layers, samples, tiles",
          { .method = STP_METHOD_EXACT, .samples = 4, .memory_limit = 400000 } },
    };
    struct stp_scene *scene = small_scene(), *faded = faded_scene();
    struct host h;
    host_open(&h);
    for (unsigned i = 0; i < WAYS; i++)
        if (is_hosted(&ways[i]))
            expect_quiet(&h, scene, &ways[i]);
    for (unsigned i = 0; i < 2; i++) {
        expect_quiet(&h, scene, &more[i]);
        expect_quiet(&h, faded, &layers[i]);
    }
    host_close(&h);
    stp_scene_destroy(&scene);
    stp_scene_destroy(&faded);
}

static enum stp_result wanted(VkResult result)
{
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return STP_ERROR_MEMORY;
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return STP_ERROR_DEVICE_MEMORY;
    default:
        return STP_ERROR_DEVICE;
    }
}

/* False: no call was made to fail, and all was made. */
static bool fail_making(struct host *h, const struct stp_scene *scene,
                        const struct stp_render_params *params, unsigned long n, unsigned choice)
{
    struct made made = { 0 };
    unsigned live = h->fault.read().live;
    h->device.lines = 0;
    h->fault.arm(n, choice, true); /* a pipeline that fails on a worker is tried once more */
    enum stp_result result = make(h, scene, params, &made);
    struct fault_state seen = h->fault.read();
    h->fault.arm(0, 0, false);
    bool injected = seen.injected[0] != 0;
    if (injected && (result != wanted(seen.result) || h->device.lines != 1))
        fail_msg("%s gives VkResult %d: %s, %u lines, the last: %s", seen.injected, seen.result,
                 stp_result_text(result), h->device.lines, h->device.last);
    assert_true(injected || (result == STP_OK && made.frame));
    unmake(&made);
    no_misuse(&h->fault, "hosted", live);
    return injected;
}

static void test_failing(void **state)
{
    const unsigned choices[] = { 0, 1, 2, FAULT_LOST };
    struct stp_scene *scene = small_scene(), *faded = faded_scene();
    const struct stp_render_params raster = { .method = STP_METHOD_TWO_PASS,
                                              .path = STP_PATH_RASTER };
    const struct stp_render_params layers = { .method = STP_METHOD_EXACT };
    struct host h;
    host_open(&h);
    for (unsigned c = 0; c < RESULTS; c++) {
        bool staged = c % 2 == 1; /* and there the layers */
        unsigned long n = 1;
        h.import.mask_features = staged ? STP_FEATURE_SHARED_MEMORY : 0;
        while (fail_making(&h, staged ? faded : scene, staged ? &layers : &raster, n, choices[c]))
            n++;
        assert_true(n > 20); /* it did go through the calls */
    }
    host_close(&h);
    stp_scene_destroy(&scene);
    stp_scene_destroy(&faded);
}

/* Every allocation of what a host makes, of a scene whose ellipses and clip lines are uploaded too;
 * all of what was made before goes with it. */
static void test_allocations(void **state)
{
    const struct stp_render_params params = { .method = STP_METHOD_EXACT };
    struct stp_scene *scene = random_scene(61, 12, true);
    struct host h;
    host_open(&h);
    assert_true(scene->facts.clip_lines > 0);
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        struct made made = { 0 };
        unsigned live = h.fault.read().live;
        h.device.lines = 0;
        mem_fail_at(n);
        result = make(&h, scene, &params, &made);
        mem_fail_at(0);
        if (result != STP_OK && (result != STP_ERROR_MEMORY || h.device.lines != 1))
            fail_msg("allocation %lu: %s, %u lines, the last: %s", n, stp_result_text(result),
                     h.device.lines, h.device.last);
        assert_true(result == STP_OK ? made.frame != NULL : !made.frame);
        unmake(&made);
        no_misuse(&h.fault, "hosted", live);
    }
    host_close(&h);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_recording),
        cmocka_unit_test(test_failing),
        cmocka_unit_test(test_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
