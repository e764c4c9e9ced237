/* An upload on a transfer queue: what is recorded there and on the queue that draws. The device of
 * these tests has one family, so a stand-in takes the commands of two, and nothing is submitted. */
#include "stage.h"

#define MOST 32

/* Of core Vulkan 1.3; PRE_RASTERIZATION: vertices, tessellation, geometry, meshes. */
static const VkPipelineStageFlags2 every =
    VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT |
    VK_PIPELINE_STAGE_2_PRE_RASTERIZATION_SHADERS_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT |
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT |
    VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |
    VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;

/* What a command buffer was given; one test at a time. */
static struct {
    unsigned copies, barriers, memory, images;
    VkImage target; /* barriers of it are looked at; and all that is recorded goes on to the device;
                       null: nothing does */
    VkBuffer copied[MOST];
    VkBufferMemoryBarrier2 barrier[MOST];
    VkMemoryBarrier2 all;
    VkMemoryBarrier2 first_all, last_all; /* of barriers with images of the host's */
    VkImageMemoryBarrier2 first_image, last_image;
    unsigned others; /* commands of any other kind */
} seen;

static VKAPI_ATTR void VKAPI_CALL see_barrier(VkCommandBuffer commands,
                                              const VkDependencyInfo *info)
{
    for (uint32_t i = 0; i < info->bufferMemoryBarrierCount; i++)
        seen.barrier[seen.barriers++ % MOST] = info->pBufferMemoryBarriers[i];
    for (uint32_t i = 0; i < info->memoryBarrierCount; i++)
        seen.all = info->pMemoryBarriers[i];
    seen.memory += info->memoryBarrierCount;
    if (info->imageMemoryBarrierCount && info->pImageMemoryBarriers->image == seen.target) {
        seen.last_all = *info->pMemoryBarriers;
        seen.last_image = *info->pImageMemoryBarriers;
        if (!seen.images++) {
            seen.first_all = seen.last_all;
            seen.first_image = seen.last_image;
        }
    }
    seen.others += info->imageMemoryBarrierCount && !seen.target;
    if (seen.target)
        vkCmdPipelineBarrier2(commands, info);
}

static VKAPI_ATTR void VKAPI_CALL see_copy(VkCommandBuffer commands, VkBuffer from, VkBuffer to,
                                           uint32_t count, const VkBufferCopy *regions)
{
    seen.copied[seen.copies++ % MOST] = to;
    if (seen.target)
        vkCmdCopyBuffer(commands, from, to, count, regions);
}

static VKAPI_ATTR void VKAPI_CALL see_fill(VkCommandBuffer commands, VkBuffer to, VkDeviceSize at,
                                           VkDeviceSize size, uint32_t word)
{
    seen.others++;
    if (seen.target)
        vkCmdFillBuffer(commands, to, at, size, word);
}

static VKAPI_ATTR void VKAPI_CALL see_update(VkCommandBuffer commands, VkBuffer to, VkDeviceSize at,
                                             VkDeviceSize size, const void *data)
{
    seen.others++;
    if (seen.target)
        vkCmdUpdateBuffer(commands, to, at, size, data);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char *name)
{
    if (strcmp(name, "vkCmdPipelineBarrier2") == 0)
        return (PFN_vkVoidFunction)see_barrier;
    if (strcmp(name, "vkCmdCopyBuffer") == 0)
        return (PFN_vkVoidFunction)see_copy;
    if (strcmp(name, "vkCmdFillBuffer") == 0)
        return (PFN_vkVoidFunction)see_fill;
    if (strcmp(name, "vkCmdUpdateBuffer") == 0)
        return (PFN_vkVoidFunction)see_update;
    return vkGetDeviceProcAddr(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_instance(VkInstance instance, const char *name)
{
    if (strcmp(name, "vkGetDeviceProcAddr") == 0)
        return (PFN_vkVoidFunction)of_device;
    return vkGetInstanceProcAddr(instance, name);
}

/* A resident whose buffers need staging, made through the stand-in. */
static struct stp_resident *staged(struct stage *s, struct stp_plan **plan)
{
    const struct stp_render_params params = { .method = STP_METHOD_DEFERRED,
                                              .path = STP_PATH_RASTER };
    struct stp_import import = engine_import(&s->engine);
    struct stp_resident *resident = NULL;
    stp_context_destroy(&s->context);
    import.get_instance_proc_addr = of_instance;
    import.mask_features = STP_FEATURE_SHARED_MEMORY;
    assert_int_equal(stp_context_import(&s->engine.env, &import, &s->context), STP_OK);
    *plan = stage_plan(&s->engine, s->context, s->scene, &s->camera, &params);
    assert_int_equal(
        stp_resident_create(&s->engine.env, s->context, s->scene, *plan, NULL, &resident), STP_OK);
    memset(&seen, 0, sizeof seen);
    return resident;
}

/* Every buffer that was copied to, once, from family `from` to family `to`. */
static void expect_hand_over(const VkBuffer *copied, unsigned copies, uint32_t from, uint32_t to)
{
    assert_int_equal(seen.barriers, copies);
    assert_int_equal(seen.memory + seen.images + seen.others, 0);
    for (unsigned i = 0; i < copies; i++) {
        assert_true(seen.barrier[i].buffer == copied[i]);
        assert_int_equal(seen.barrier[i].srcQueueFamilyIndex, from);
        assert_int_equal(seen.barrier[i].dstQueueFamilyIndex, to);
        assert_int_equal(seen.barrier[i].offset, 0);
        assert_true(seen.barrier[i].size == VK_WHOLE_SIZE);
    }
}

static void test_two_families(void **state)
{
    struct stage s;
    struct stp_plan *plan;
    VkBuffer copied[MOST];
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    const uint32_t own = s.engine.family, other = own + 1;
    struct stp_resident *resident = staged(&s, &plan);
    assert_int_equal(stp_resident_record_upload(&s.engine.env, resident, NULL, other), STP_OK);
    unsigned copies = seen.copies;
    assert_int_equal(copies, 3); /* splats, colours, order */
    memcpy(copied, seen.copied, sizeof copied);
    for (unsigned i = 0; i < copies; i++)
        for (unsigned j = 0; j < i; j++)
            assert_true(copied[i] != copied[j]);
    expect_hand_over(copied, copies, other, own);
    for (unsigned i = 0; i < copies; i++) { /* release: only what comes before counts */
        assert_int_equal(seen.barrier[i].srcStageMask, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT);
        assert_int_equal(seen.barrier[i].srcAccessMask, VK_ACCESS_2_TRANSFER_WRITE_BIT);
        assert_int_equal(seen.barrier[i].dstStageMask, 0);
        assert_int_equal(seen.barrier[i].dstAccessMask, 0);
    }
    memset(&seen, 0, sizeof seen);
    stp_resident_record_acquire(resident, NULL, other);
    assert_int_equal(seen.copies, 0);
    expect_hand_over(copied, copies, other, own);
    for (unsigned i = 0; i < copies;
         i++) { /* acquire: behind the semaphore, wherever that is waited for */
        assert_true(seen.barrier[i].srcStageMask == VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
        assert_int_equal(seen.barrier[i].srcAccessMask, 0);
        assert_true((seen.barrier[i].dstStageMask & every) == every);
        assert_true(seen.barrier[i].dstAccessMask == VK_ACCESS_2_MEMORY_READ_BIT);
    }
    memset(&seen, 0, sizeof seen);
    assert_int_equal(stp_resident_record_upload(&s.engine.env, resident, NULL, other),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(seen.copies + seen.barriers, 0);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

/* On the family that draws nothing changes hands: one memory barrier, and none to acquire. */
static void test_one_family(void **state)
{
    struct stage s;
    struct stp_plan *plan;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct stp_resident *resident = staged(&s, &plan);
    assert_int_equal(stp_resident_record_upload(&s.engine.env, resident, NULL, s.engine.family),
                     STP_OK);
    assert_int_equal(seen.copies, 3);
    assert_int_equal(seen.barriers + seen.images + seen.others, 0);
    assert_int_equal(seen.memory, 1);
    assert_true(seen.all.srcAccessMask & VK_ACCESS_2_TRANSFER_WRITE_BIT);
    assert_true((seen.all.dstStageMask & every) == every);
    assert_true(seen.all.dstAccessMask == VK_ACCESS_2_MEMORY_READ_BIT);
    memset(&seen, 0, sizeof seen);
    stp_resident_record_acquire(resident, NULL, s.engine.family);
    assert_int_equal(seen.barriers + seen.images + seen.memory + seen.copies + seen.others, 0);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

/* Staging may be released once the copies are done, which is before or after the acquisition is
 * recorded; but not before the copies are. */
static void test_released(void **state)
{
    struct stage s;
    struct stp_plan *plan;
    VkBuffer copied[MOST];
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    const uint32_t own = s.engine.family, other = own + 1;
    struct stp_resident *resident = staged(&s, &plan);
    assert_int_equal(stp_resident_record_upload(&s.engine.env, resident, NULL, other), STP_OK);
    memcpy(copied, seen.copied, sizeof copied);
    memset(&seen, 0, sizeof seen);
    stp_resident_release_staging(resident);
    stp_resident_record_acquire(resident, NULL, other);
    expect_hand_over(copied, 3, other, own);
    stp_resident_release_staging(resident);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    resident = staged(&s, &plan);
    stp_resident_release_staging(resident);
    assert_int_equal(stp_resident_record_upload(&s.engine.env, resident, NULL, own),
                     STP_ERROR_ARGUMENT);
    assert_non_null(strstr(s.engine.last, "released"));
    assert_int_equal(seen.copies + seen.barriers + seen.memory + seen.others, 0);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

/* Where the host's images change hands: the first and the last barrier of a frame. Whatever the
 * host did before in any stage is waited for, and whatever it does after waits. */
static void test_every_stage(void **state)
{

    const struct stp_render_params params = { .method = STP_METHOD_EXACT };
    const struct stp_host_frame_params host = { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                .depth_format = VK_FORMAT_D32_SFLOAT };
    struct stage s;
    struct stp_plan *plan;
    stage_open(&s, host.color_format, host.depth_format, NULL);
    struct stp_resident *resident = staged(&s, &plan);
    stp_plan_destroy(&plan);
    plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &params);
    struct stp_frame *frame = stage_frame(&s.engine, s.context, plan, &host);
    struct stp_targets targets = stage_targets(&s);
    VkCommandBuffer commands = engine_begin(&s.engine, 0);
    stage_clear(commands, &s, NULL, 0);
    memset(&seen, 0, sizeof seen);
    seen.target = s.color.image;
    assert_int_equal(stp_resident_record_upload(&s.engine.env, resident, commands, s.engine.family),
                     STP_OK);
    assert_int_equal(
        stp_frame_record(&s.engine.env, frame, resident, &s.camera, &targets, commands), STP_OK);
    assert_int_equal(seen.images, 2);
    for (unsigned i = 0; i < 2; i++) {
        const VkMemoryBarrier2 *all = i ? &seen.last_all : &seen.first_all;
        const VkImageMemoryBarrier2 *image = i ? &seen.last_image : &seen.first_image;
        assert_true((all->srcStageMask & all->dstStageMask & every) == every);
        assert_true((image->srcStageMask & image->dstStageMask & every) == every);
        assert_true(all->srcAccessMask == VK_ACCESS_2_MEMORY_WRITE_BIT);
        assert_true(all->dstAccessMask ==
                    (VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT));
        assert_true(image->image == s.color.image);
    }
    engine_submit(&s.engine, 0);
    engine_finish(&s.engine);
    stp_frame_destroy(&frame);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_families),
        cmocka_unit_test(test_one_family),
        cmocka_unit_test(test_released),
        cmocka_unit_test(test_every_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
