/* What a host may do besides: leave features off, give memory, move points, place pictures. */
#include "stage.h"

#include <math.h>

static void expect_refused(struct engine *e, const struct stp_import *import, enum stp_result why,
                           const char *words)
{
    struct stp_context *context = NULL;
    unsigned lines = e->lines;
    assert_int_equal(stp_context_import(&e->env, import, &context), why);
    assert_null(context);
    assert_int_equal(e->lines, lines + 1);
    if (!strstr(e->last, words))
        fail_msg("\"%s\" does not say \"%s\"", e->last, words);
}

static void test_refused(void **state)
{
    struct engine e;
    engine_open(&e, "synchronization2 scalarBlockLayout");
    struct stp_import import = engine_import(&e);
    expect_refused(&e, &import, STP_ERROR_FEATURE, "scalarBlockLayout (required)");
    expect_refused(&e, &import, STP_ERROR_FEATURE, "synchronization2 (required)");
    import.api_version = VK_API_VERSION_1_2;
    expect_refused(&e, &import, STP_ERROR_FEATURE, "1.2");
    import = engine_import(&e);
    import.device = VK_NULL_HANDLE;
    expect_refused(&e, &import, STP_ERROR_ARGUMENT, "device");
    import = engine_import(&e);
    import.queue_family = 77;
    expect_refused(&e, &import, STP_ERROR_FEATURE, "queue family 77");
    engine_close(&e);
}

/* Features as single structs instead of the 1.2 and 1.3 ones. */
static void test_single_structs(void **state)
{
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    VkPhysicalDeviceMaintenance4Features m4 = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_FEATURES, .maintenance4 = VK_TRUE
    };
    VkPhysicalDeviceSynchronization2Features sync = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES,
        .pNext = &m4,
        .synchronization2 = VK_TRUE
    };
    VkPhysicalDeviceDynamicRenderingFeatures rendering = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES,
        .pNext = &sync,
        .dynamicRendering = VK_TRUE
    };
    VkPhysicalDeviceScalarBlockLayoutFeatures scalar = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES,
        .pNext = &rendering,
        .scalarBlockLayout = VK_TRUE
    };
    VkPhysicalDeviceBufferDeviceAddressFeatures address = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES,
        .pNext = &scalar,
        .bufferDeviceAddress = VK_TRUE
    };
    VkPhysicalDeviceFeatures2 core = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                       .pNext = &address,
                                       .features = { .shaderInt64 = VK_TRUE } };
    struct stp_import import = engine_import(&s.engine);
    struct stp_context *context = NULL;
    import.features = &core;
    assert_int_equal(stp_context_import(&s.engine.env, &import, &context), STP_OK);
    assert_int_equal(stp_context_limits(context)->features &
                         (STP_FEATURE_INT64_ATOMICS | STP_FEATURE_FLOAT64),
                     0);
    stp_context_destroy(&context);
    stage_close(&s);
}

/* An allocator of the host's that counts, and offsets what it gives. */
struct counting {
    struct engine *engine;
    unsigned given, released;
    bool unmapped; /* leaves `mapped` NULL */
};

static VkResult give(void *user, const VkMemoryRequirements *needs, uint32_t type,
                     struct stp_device_memory *memory)
{
    struct counting *c = user;
    VkMemoryAllocateFlagsInfo flags = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT };
    VkDeviceSize offset = (4096 + needs->alignment - 1) / needs->alignment * needs->alignment;
    VkMemoryAllocateInfo info = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .pNext = &flags,
                                  .allocationSize = needs->size + offset + ((VkDeviceSize)1 << 20),
                                  .memoryTypeIndex = type };
    *memory = (struct stp_device_memory){ .offset = offset, .handle = c };
    VkResult result = vkAllocateMemory(c->engine->device, &info, NULL, &memory->memory);
    void *mapped = NULL;
    if (result == VK_SUCCESS)
        result = vkMapMemory(c->engine->device, memory->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
    memory->mapped = c->unmapped ? NULL : (char *)mapped + offset;
    c->given += result == VK_SUCCESS;
    return result;
}

static void take_back(void *user, const struct stp_device_memory *memory)
{
    struct counting *c = user;
    assert_ptr_equal(memory->handle, c);
    vkFreeMemory(c->engine->device, memory->memory, NULL);
    c->released++;
}

static float *picture(struct stage *s, struct stp_frame *frame, const struct stp_resident *resident,
                      const struct stp_targets *targets)
{
    VkCommandBuffer commands = engine_begin(&s->engine, 0);
    stage_clear(commands, s, NULL, 0);
    if (stp_frame_record(&s->engine.env, frame, resident, &s->camera, targets, commands))
        fail_msg("not recorded: %s", s->engine.last);
    engine_submit(&s->engine, 0);
    return engine_read(&s->engine, &s->color, 16);
}

/* A context whose memory is the host's, counted. */
static struct stp_context *import_counted(struct stage *s, struct stp_import import,
                                          struct counting *counting)
{
    struct stp_context *context = NULL;
    import.allocator = (struct stp_device_allocator){ counting, give, take_back };
    assert_int_equal(stp_context_import(&s->engine.env, &import, &context), STP_OK);
    return context;
}

static const struct stp_host_frame_params floats = { .color_format =
                                                         VK_FORMAT_R32G32B32A32_SFLOAT };

static void test_memory_of_the_host(void **state)
{
    const struct stp_render_params ways[] = {
        { .method = STP_METHOD_EXACT },
        { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER },
    };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct counting counting = { .engine = &s.engine };
    struct stp_context *context = import_counted(&s, engine_import(&s.engine), &counting);
    for (unsigned i = 0; i < 2; i++) {
        struct stp_plan *plan = stage_plan(&s.engine, context, s.scene, &s.camera, &ways[i]);
        struct stp_resident *resident = stage_resident(&s.engine, context, s.scene, plan, NULL);
        struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, &ways[i]);
        struct stp_targets targets = stage_targets(&s);
        struct stp_host_frame_params params = floats;
        struct stp_device_memory scratch;
        VkMemoryRequirements needs;
        assert_int_equal(stp_frame_scratch(&s.engine.env, context, plan, &params, &needs), STP_OK);
        assert_true(needs.memoryTypeBits != 0 && needs.size > 0);
        assert_int_equal(give(&counting, &needs, 0, &scratch), VK_SUCCESS);
        params.scratch = &scratch;
        unsigned given = counting.given;
        struct stp_frame *frame = stage_frame(&s.engine, context, plan, &params);
        assert_int_equal(counting.given, given);
        float *texels = picture(&s, frame, resident, &targets);
        stage_same(expected, texels, "scratch of the host");
        free(texels);
        stp_frame_destroy(&frame);
        take_back(&counting, &scratch);
        frame = stage_frame(&s.engine, context, plan, &floats);
        assert_int_equal(counting.given, given + 1);
        texels = picture(&s, frame, resident, &targets);
        stage_same(expected, texels, "scratch by the host's allocator");
        free(texels);
        stp_frame_destroy(&frame);
        stp_image_destroy(&expected);
        stp_resident_destroy(&resident);
        stp_plan_destroy(&plan);
    }
    stp_context_destroy(&context);
    assert_int_equal(counting.given, counting.released);
    assert_true(counting.given >= 4);
    stage_close(&s);
}

/* A loader of a device that allows no allocation of more than this. */
#define SMALL_ALLOCATION 4096

static void VKAPI_CALL small_properties(VkPhysicalDevice device, VkPhysicalDeviceProperties2 *p)
{
    vkGetPhysicalDeviceProperties2(device, p);
    for (VkBaseOutStructure *s = p->pNext; s; s = s->pNext)
        if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES)
            ((VkPhysicalDeviceVulkan11Properties *)(void *)s)->maxMemoryAllocationSize =
                SMALL_ALLOCATION;
}

static PFN_vkVoidFunction VKAPI_CALL small_loader(VkInstance instance, const char *name)
{
    return strcmp(name, "vkGetPhysicalDeviceProperties2") == 0
               ? (PFN_vkVoidFunction)small_properties
               : vkGetInstanceProcAddr(instance, name);
}

/* What one allocation may not hold together is allocated one by one, and the picture is the same.
 */
static void test_small_allocations(void **state)
{
    const struct stp_render_params params = { .method = STP_METHOD_EXACT };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct counting counting = { .engine = &s.engine };
    struct stp_import import = engine_import(&s.engine);
    import.get_instance_proc_addr = small_loader;
    struct stp_context *context = import_counted(&s, import, &counting);
    assert_true(stp_context_limits(context)->max_allocation == SMALL_ALLOCATION);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &params);
    struct stp_resident *resident = stage_resident(&s.engine, context, s.scene, plan, NULL);
    assert_true(counting.given >= 2);
    unsigned given = counting.given;
    struct stp_host_frame_params format = floats;
    VkMemoryRequirements needs;
    assert_int_equal(stp_frame_scratch(&s.engine.env, context, plan, &format, &needs), STP_OK);
    assert_int_equal(needs.memoryTypeBits, 0);
    struct stp_frame *frame = stage_frame(&s.engine, context, plan, &format);
    assert_true(counting.given >= given + 2);
    struct stp_targets targets = stage_targets(&s);
    struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, &params);
    float *texels = picture(&s, frame, resident, &targets);
    stage_same(expected, texels, "allocations one by one");
    free(texels);
    stp_image_destroy(&expected);
    stp_frame_destroy(&frame);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stp_context_destroy(&context);
    assert_int_equal(counting.given, counting.released);
    stage_close(&s);
}

/* Memory to be written by the host that the allocator did not map: refused, and given back. */
static void test_not_mapped(void **state)
{
    const struct stp_render_params params = { .method = STP_METHOD_EXACT };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct counting counting = { .engine = &s.engine, .unmapped = true };
    struct stp_import import = engine_import(&s.engine);
    struct stp_resident *resident = NULL;
    import.mask_features = STP_FEATURE_SHARED_MEMORY; /* so that uploads are staged */
    struct stp_context *context = import_counted(&s, import, &counting);
    struct stp_plan *plan = stage_plan(&s.engine, context, s.scene, &s.camera, &params);
    assert_int_equal(stp_resident_create(&s.engine.env, context, s.scene, plan, NULL, &resident),
                     STP_ERROR_DEVICE);
    assert_null(resident);
    assert_non_null(strstr(s.engine.last, "allocator"));
    assert_true(counting.given >= 2); /* the scene's, and what was to stage it */
    assert_int_equal(counting.given, counting.released);
    stp_plan_destroy(&plan);
    stp_context_destroy(&context);
    stage_close(&s);
}

/* A buffer of splats that the host fills through its mapping. */
struct moving {
    VkBuffer buffer;
    struct stp_device_memory memory;
    float (*splats)[8];
};

static struct moving make_moving(struct engine *e, struct counting *c, VkDeviceSize bytes)
{
    struct moving m;
    VkBufferCreateInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = bytes,
                                .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                         VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT };
    VkMemoryRequirements needs;
    assert_int_equal(vkCreateBuffer(e->device, &info, NULL, &m.buffer), VK_SUCCESS);
    vkGetBufferMemoryRequirements(e->device, m.buffer, &needs);
    needs.size += (VkDeviceSize)1 << 20;
    assert_int_equal(give(c, &needs, 0, &m.memory), VK_SUCCESS);
    assert_int_equal(vkBindBufferMemory(e->device, m.buffer, m.memory.memory, m.memory.offset),
                     VK_SUCCESS);
    m.splats = m.memory.mapped;
    return m;
}

static struct stp_scene *three(struct engine *e, double shift)
{
    const double position[3][3] = { { shift, 0, 0 }, { -0.5, 0.3, 0.2 }, { -0.5, -0.4, -0.2 } };
    const float normal[3][3] = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } };
    const float radius[3] = { 0.3f, 0.3f, 0.3f };
    struct stp_points points = {
        .count = 3, .position = position, .normal = normal, .radius = radius
    };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(&e->env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(&e->env, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(&e->env, scene, NULL), STP_OK);
    return scene;
}

/* A host that moves a point in its own buffer gets the picture of the scene in which it moved. */
static void test_points_that_move(void **state)
{
    const struct stp_render_params params = { .method = STP_METHOD_TWO_PASS, .epsilon = 0.3 };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct counting counting = { .engine = &s.engine };
    struct stp_scene *before = three(&s.engine, 0.5), *after = three(&s.engine, 0.25);
    s.camera = stage_view(before, WIDTH, HEIGHT, 0);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, before, &s.camera, &params);
    struct moving moving = make_moving(&s.engine, &counting, 3 * 32);
    struct stp_resident_params own = { .splats = moving.buffer };
    struct stp_resident *resident = stage_resident(&s.engine, s.context, before, plan, &own);
    VkDeviceSize bytes;
    assert_true(stp_resident_splats(resident, &bytes) == moving.buffer && bytes == 96);
    double o[3];
    memcpy(o, stp_scene_facts(before)->origin, sizeof o);
    const double place[3][3] = { { -0.5, -0.4, -0.2 }, { -0.5, 0.3, 0.2 }, { 0.25, 0, 0 } };
    for (int i = 0; i < 3; i++) {
        const float splat[8] = { (float)(place[i][0] - o[0]),
                                 (float)(place[i][1] - o[1]),
                                 (float)(place[i][2] - o[2]),
                                 0.3f,
                                 0,
                                 0,
                                 1,
                                 0 };
        memcpy(moving.splats[i], splat, sizeof splat);
    }
    struct stp_frame *frame = stage_frame(&s.engine, s.context, plan, &floats);
    struct stp_targets targets = stage_targets(&s);
    float *texels = picture(&s, frame, resident, &targets);
    struct stp_image *moved = stage_offline(&s.engine, after, &s.camera, &params);
    struct stp_image *still = stage_offline(&s.engine, before, &s.camera, &params);
    const float *expected = stage_plane(moved, "G"), *old = stage_plane(still, "G");
    size_t covered = 0, changed = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
        assert_float_equal(texels[4 * i + 1], expected[i], 1e-4);
        covered += expected[i] > 0;
        changed += fabsf(expected[i] - old[i]) > 0.1f;
    }
    assert_true(covered > 100 && changed > 50);
    free(texels);
    stp_image_destroy(&moved);
    stp_image_destroy(&still);
    stp_frame_destroy(&frame);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&before);
    stp_scene_destroy(&after);
    vkDestroyBuffer(s.engine.device, moving.buffer, NULL);
    take_back(&counting, &moving.memory);
    stage_close(&s);
}

/* A picture at an offset, cut by the image's edges, leaves the rest of the image alone. */
static void test_placed(void **state)
{
    const struct stp_render_params params = { .method = STP_METHOD_EXACT };
    const int32_t corners[][2] = { { 0, 0 }, { 13, 7 }, { -20, -11 }, { 40, -5 }, { 500, 0 } };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct stp_camera whole = s.camera;
    struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &whole, &params);
    struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
    struct stp_host_frame_params replace = floats;
    replace.composite = STP_COMPOSITE_REPLACE;
    struct stp_frame *frame = stage_frame(&s.engine, s.context, plan, &replace);
    s.camera = stage_view(s.scene, 40, 30, 1); /* smaller than the plan's */
    struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, &params);
    const float *red = stage_plane(expected, "R");
    for (unsigned c = 0; c < sizeof corners / sizeof *corners; c++) {
        struct stp_targets targets = stage_targets(&s);
        targets.x = corners[c][0];
        targets.y = corners[c][1];
        const float blue[4] = { 0.25f, 0, 1, 1 };
        VkCommandBuffer commands = engine_begin(&s.engine, 0);
        stage_clear(commands, &s, blue, 0);
        assert_int_equal(
            stp_frame_record(&s.engine.env, frame, resident, &s.camera, &targets, commands),
            STP_OK);
        engine_submit(&s.engine, 0);
        float *texels = engine_read(&s.engine, &s.color, 16);
        for (int32_t y = 0; y < HEIGHT; y++)
            for (int32_t x = 0; x < WIDTH; x++) {
                int32_t u = x - targets.x, v = y - targets.y;
                bool inside = u >= 0 && v >= 0 && u < 40 && v < 30;
                float right = inside ? red[v * 40 + u] : 0.25f;
                assert_true(texels[4 * (y * WIDTH + x)] == right);
            }
        free(texels);
    }
    s.camera = whole;
    s.camera.width++;
    struct stp_targets targets = stage_targets(&s);
    VkCommandBuffer commands = engine_begin(&s.engine, 0);
    assert_int_equal(
        stp_frame_record(&s.engine.env, frame, resident, &s.camera, &targets, commands),
        STP_ERROR_ARGUMENT);
    engine_submit(&s.engine, 0);
    stp_image_destroy(&expected);
    stp_frame_destroy(&frame);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refused),           cmocka_unit_test(test_single_structs),
        cmocka_unit_test(test_not_mapped),        cmocka_unit_test(test_memory_of_the_host),
        cmocka_unit_test(test_points_that_move),  cmocka_unit_test(test_placed),
        cmocka_unit_test(test_small_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
