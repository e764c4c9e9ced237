#include "record/record.h"

#include "base/log.h"

/* Outputs that the host cannot read where they are. */
static enum stp_result make_read_back(const struct stp_env *env, struct record_frame *frame)
{
    const struct stp_plan *plan = frame->plan;
    enum stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < plan->resource_count; i++)
        if (plan->resource[i].lifetime == PLAN_OUTPUT && !frame->resources.buffer[i].mapped)
            result = gpu_buffer_create(env, frame->context, plan->resource[i].bytes, GPU_READ_BACK,
                                       plan->resource[i].name, &frame->read_back[i]);
    if (result == STP_OK && plan->loop_first)
        result = gpu_buffer_create(env, frame->context, 4, GPU_READ_BACK, "what remains",
                                   &frame->remaining);
    return result;
}

static VkResult make_set(struct record_frame *frame, const struct record_bindings *b)
{
    struct stp_context *c = frame->context;
    VkDescriptorPoolSize sizes[1 + PLAN_SLOTS] = { { VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1 } };
    for (uint32_t i = 0; i < b->count; i++)
        sizes[1 + i] = (VkDescriptorPoolSize){ b->type[i], 1 };
    VkDescriptorPoolCreateInfo pool = { .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                        .maxSets = 1,
                                        .poolSizeCount = 1 + b->count,
                                        .pPoolSizes = sizes };
    VkResult result = c->vk.vkCreateDescriptorPool(c->device, &pool, NULL, &frame->resources.pool);
    if (result != VK_SUCCESS)
        return result;
    VkDescriptorSetAllocateInfo set = { .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                        .descriptorPool = frame->resources.pool,
                                        .descriptorSetCount = 1,
                                        .pSetLayouts = &frame->pipelines->set_layout };
    return c->vk.vkAllocateDescriptorSets(c->device, &set, &frame->resources.set);
}

static void write_set(struct record_frame *frame, const struct record_bindings *b)
{
    struct stp_context *c = frame->context;
    VkDescriptorBufferInfo buffer = { frame->resources.constants.handle, 0,
                                      sizeof(struct stp_frame_constants) };
    VkDescriptorImageInfo image[PLAN_SLOTS];
    VkWriteDescriptorSet writes[1 + PLAN_SLOTS] = {
        { .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
          .dstSet = frame->resources.set,
          .descriptorCount = 1,
          .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
          .pBufferInfo = &buffer }
    };
    for (uint32_t i = 0; i < b->count; i++) {
        uint8_t r = b->resource[i];
        image[i] = (VkDescriptorImageInfo){ .imageView = frame->resources.image[r].all,
                                            .imageLayout = VK_IMAGE_LAYOUT_GENERAL };
        writes[1 + i] = (VkWriteDescriptorSet){ .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                .dstSet = frame->resources.set,
                                                .dstBinding = b->binding[i],
                                                .descriptorCount = 1,
                                                .descriptorType = b->type[i],
                                                .pImageInfo = &image[i],
                                                .pTexelBufferView = &frame->resources.texels[r] };
    }
    c->vk.vkUpdateDescriptorSets(c->device, 1 + b->count, writes, 0, NULL);
}

static enum stp_result make_descriptors(const struct stp_env *env, struct record_frame *frame)
{
    struct record_bindings bindings = record_bindings(frame->plan);
    VkResult result = make_set(frame, &bindings);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "making descriptor sets");
    write_set(frame, &bindings);
    return STP_OK;
}

static enum stp_result take_pipelines(const struct stp_env *env, struct record_frame *frame,
                                      const struct pass_host *host)
{
    enum stp_result result =
        record_pipelines_take(env, frame->context, frame->plan, host, &frame->pipelines);
    if (result == STP_OK)
        frame->resources.layout = frame->pipelines->layout;
    return result;
}

static enum stp_result make_queries(const struct stp_env *env, struct record_frame *frame)
{
    struct stp_context *c = frame->context;
    if (!(c->timestamp_ms > 0))
        return STP_OK;
    VkQueryPoolCreateInfo info = { .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                   .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                   .queryCount = RECORD_MAX_STEPS + 1 };
    VkResult status = c->vk.vkCreateQueryPool(c->device, &info, NULL, &frame->queries);
    return status == VK_SUCCESS ? STP_OK : gpu_error(env, status, "vkCreateQueryPool");
}

static enum stp_result keep_or_destroy(enum stp_result result, struct record_frame *frame)
{
    if (result != STP_OK)
        record_frame_destroy(frame);
    return result;
}

enum stp_result record_frame_create(const struct stp_env *env, struct stp_context *context,
                                    const struct stp_plan *plan, struct record_frame *frame)
{
    *frame = (struct record_frame){ .plan = plan, .context = context };
    enum stp_result result =
        record_resources_create(env, context, plan, RECORD_ALL, NULL, &frame->resources);
    if (result == STP_OK)
        result = make_read_back(env, frame);
    if (result == STP_OK)
        result = take_pipelines(env, frame, NULL);
    if (result == STP_OK)
        result = make_descriptors(env, frame);
    if (result == STP_OK)
        result = make_queries(env, frame);
    return keep_or_destroy(result, frame);
}

/* One block, unless no type of memory holds both the buffers and the images, or no allocation may
 * be so large. */
static enum stp_result make_scratch(const struct stp_env *env, struct record_frame *frame,
                                    const struct record_host *host)
{
    if (host->scratch) {
        frame->scratch.part.where = *host->scratch;
        return STP_OK;
    }
    VkMemoryRequirements needs =
        record_resources_need(frame->context, frame->plan, RECORD_WITHOUT_SCENE);
    if (!needs.memoryTypeBits || needs.size > frame->context->limits.max_allocation)
        return STP_OK;
    return gpu_block_create(env, frame->context, &needs, GPU_DEVICE, "a frame's scratch",
                            &frame->scratch);
}

enum stp_result record_frame_create_hosted(const struct stp_env *env, struct stp_context *context,
                                           const struct stp_plan *plan,
                                           const struct record_host *host,
                                           struct record_frame *frame)
{
    *frame = (struct record_frame){ .plan = plan, .context = context };
    enum stp_result result = make_scratch(env, frame, host);
    if (result == STP_OK)
        result = record_resources_create(env, context, plan, RECORD_WITHOUT_SCENE,
                                         frame->scratch.part.where.memory ? &frame->scratch : NULL,
                                         &frame->resources);
    if (result == STP_OK)
        result = take_pipelines(env, frame, &host->pass);
    if (result == STP_OK)
        result = make_descriptors(env, frame);
    return keep_or_destroy(result, frame);
}

void record_frame_destroy(struct record_frame *frame)
{
    struct stp_context *c = frame->context;
    if (!c)
        return;
    if (frame->pipelines)
        gpu_leave_kept(c, &frame->pipelines->kept);
    if (frame->queries)
        c->vk.vkDestroyQueryPool(c->device, frame->queries, NULL);
    if (frame->resources.pool)
        c->vk.vkDestroyDescriptorPool(c->device, frame->resources.pool, NULL);
    for (uint32_t i = 0; i < PLAN_MAX_RESOURCES; i++)
        gpu_buffer_destroy(c, &frame->read_back[i]);
    gpu_buffer_destroy(c, &frame->remaining);
    axis_lists_release(&frame->axis);
    axis_blocks_release(&frame->axis_blocks);
    record_resources_destroy(c, &frame->resources);
    gpu_block_destroy(c, &frame->scratch);
    *frame = (struct record_frame){ 0 };
}
