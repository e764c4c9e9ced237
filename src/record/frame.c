#include "record/record.h"

#include "base/log.h"
#include "base/thread.h"

static enum stp_result make_texels(const struct stp_env *env, struct record_frame *frame,
                                   uint32_t i)
{
    struct stp_context *c = frame->context;
    VkBufferViewCreateInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                    .buffer = frame->resources.buffer[i].handle,
                                    .format = pass_format(frame->plan->resource[i].format),
                                    .range = frame->plan->resource[i].bytes };
    VkResult result = c->vk.vkCreateBufferView(c->device, &info, NULL, &frame->resources.texels[i]);
    return result == VK_SUCCESS ? STP_OK : gpu_error(env, result, "vkCreateBufferView");
}

static enum stp_result make_resources(const struct stp_env *env, struct record_frame *frame)
{
    const struct stp_plan *plan = frame->plan;
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        enum stp_result result =
            !pass_is_image(r->format)
                ? gpu_buffer_create(env, frame->context, r->bytes, GPU_DEVICE, r->name,
                                    &frame->resources.buffer[i])
                : gpu_image_create(env, frame->context, pass_format(r->format), r->width, r->height,
                                   r->layers, r->name, &frame->resources.image[i]);
        if (result == STP_OK && r->lifetime == PLAN_OUTPUT && !frame->resources.buffer[i].mapped)
            result = gpu_buffer_create(env, frame->context, r->bytes, GPU_READ_BACK, r->name,
                                       &frame->read_back[i]);
        if (result == STP_OK && pass_is_texels(r->format))
            result = make_texels(env, frame, i);
        if (result != STP_OK)
            return result;
    }
    return gpu_buffer_create(env, frame->context, sizeof(struct stp_frame_constants), GPU_DEVICE,
                             "frame constants", &frame->resources.constants);
}

/* What is bound beside the frame block, whose binding is 0: images and texels. */
struct bindings {
    uint32_t count;
    uint32_t binding[PLAN_SLOTS];
    uint8_t resource[PLAN_SLOTS];
    VkDescriptorType type[PLAN_SLOTS];
};

static struct bindings find_bindings(const struct stp_plan *plan)
{
    struct bindings b = { 0 };
    for (uint32_t slot = PLAN_BUFFER_SLOTS; slot < PLAN_SLOTS; slot++) {
        uint8_t found = plan_find(plan, slot);
        if (found == PLAN_NONE || slot == PLAN_IMAGE_DEPTH)
            continue;
        b.resource[b.count] = found;
        b.type[b.count] = pass_is_texels(plan->resource[found].format)
                              ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER
                              : VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
        b.binding[b.count++] = PLAN_BINDING(slot);
    }
    return b;
}

static VkResult make_layouts(struct record_frame *frame, const struct bindings *b)
{
    struct stp_context *c = frame->context;
    const VkShaderStageFlags stages = PASS_STAGES;
    VkDescriptorSetLayoutBinding bindings[1 + PLAN_SLOTS] = {
        { 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, stages, NULL }
    };
    for (uint32_t i = 0; i < b->count; i++)
        bindings[1 + i] =
            (VkDescriptorSetLayoutBinding){ b->binding[i], b->type[i], 1, stages, NULL };
    VkDescriptorSetLayoutCreateInfo set = { .sType =
                                                VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                            .bindingCount = 1 + b->count,
                                            .pBindings = bindings };
    VkResult result =
        c->vk.vkCreateDescriptorSetLayout(c->device, &set, NULL, &frame->resources.set_layout);
    if (result != VK_SUCCESS)
        return result;
    VkPushConstantRange push = { stages, 0, PASS_PUSH_BYTES };
    VkPipelineLayoutCreateInfo layout = { .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &frame->resources.set_layout,
                                          .pushConstantRangeCount = 1,
                                          .pPushConstantRanges = &push };
    return c->vk.vkCreatePipelineLayout(c->device, &layout, NULL, &frame->resources.layout);
}

static VkResult make_set(struct record_frame *frame, const struct bindings *b)
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
                                        .pSetLayouts = &frame->resources.set_layout };
    return c->vk.vkAllocateDescriptorSets(c->device, &set, &frame->resources.set);
}

static void write_set(struct record_frame *frame, const struct bindings *b)
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
    struct bindings bindings = find_bindings(frame->plan);
    VkResult result = make_layouts(frame, &bindings);
    if (result == VK_SUCCESS)
        result = make_set(frame, &bindings);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "making descriptor sets");
    write_set(frame, &bindings);
    return STP_OK;
}

struct making {
    struct record_frame *frame;
    enum stp_result result[PLAN_MAX_PASSES];
};

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

/* Compiling is most of a cold start, and drivers do it well side by side. Workers stay silent:
 * what fails is tried again by the caller's thread, which may log. */
static void make_range(void *context, size_t begin, size_t end, unsigned worker)
{
    struct making *m = context;
    const struct stp_env silent = { .log = swallow };
    for (size_t i = begin; i < end; i++)
        m->result[i] =
            pass_pipeline(&silent, m->frame->context, m->frame->plan, &m->frame->plan->pass[i],
                          &m->frame->resources, &m->frame->pipeline[i]);
}

static enum stp_result make_pipelines(const struct stp_env *env, struct record_frame *frame)
{
    struct making making = { .frame = frame };
    /* Validation layers speak on the thread that calls them, and only the caller's may log. */
    struct stp_env alone = { .threads = 1 };
    parallel_for(frame->context->instance.validate ? &alone : env, frame->plan->pass_count, 1,
                 make_range, &making);
    for (uint32_t i = 0; i < frame->plan->pass_count; i++) {
        enum stp_result result = making.result[i];
        if (result != STP_OK)
            result = pass_pipeline(env, frame->context, frame->plan, &frame->plan->pass[i],
                                   &frame->resources, &frame->pipeline[i]);
        if (result != STP_OK)
            return result;
    }
    return STP_OK;
}

enum stp_result record_frame_create(const struct stp_env *env, struct stp_context *context,
                                    const struct stp_plan *plan, struct record_frame *frame)
{
    *frame = (struct record_frame){ .plan = plan, .context = context };
    enum stp_result result = make_resources(env, frame);
    if (result == STP_OK)
        result = make_descriptors(env, frame);
    if (result == STP_OK)
        result = make_pipelines(env, frame);
    if (result == STP_OK && context->timestamp_ms > 0) {
        VkQueryPoolCreateInfo info = { .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                       .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                       .queryCount = RECORD_MAX_STEPS + 1 };
        VkResult status =
            context->vk.vkCreateQueryPool(context->device, &info, NULL, &frame->queries);
        if (status != VK_SUCCESS)
            result = gpu_error(env, status, "vkCreateQueryPool");
    }
    if (result != STP_OK)
        record_frame_destroy(frame);
    return result;
}

void record_frame_destroy(struct record_frame *frame)
{
    struct stp_context *c = frame->context;
    if (!c)
        return;
    for (uint32_t i = 0; i < PLAN_MAX_PASSES; i++)
        if (frame->pipeline[i])
            c->vk.vkDestroyPipeline(c->device, frame->pipeline[i], NULL);
    if (frame->queries)
        c->vk.vkDestroyQueryPool(c->device, frame->queries, NULL);
    if (frame->resources.pool)
        c->vk.vkDestroyDescriptorPool(c->device, frame->resources.pool, NULL);
    if (frame->resources.layout)
        c->vk.vkDestroyPipelineLayout(c->device, frame->resources.layout, NULL);
    if (frame->resources.set_layout)
        c->vk.vkDestroyDescriptorSetLayout(c->device, frame->resources.set_layout, NULL);
    for (uint32_t i = 0; i < PLAN_MAX_RESOURCES; i++) {
        if (frame->resources.texels[i])
            c->vk.vkDestroyBufferView(c->device, frame->resources.texels[i], NULL);
        gpu_buffer_destroy(c, &frame->resources.buffer[i]);
        gpu_buffer_destroy(c, &frame->read_back[i]);
        gpu_image_destroy(c, &frame->resources.image[i]);
    }
    gpu_buffer_destroy(c, &frame->resources.constants);
    *frame = (struct record_frame){ 0 };
}
