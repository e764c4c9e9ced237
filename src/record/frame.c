#include "record/record.h"

#include "base/log.h"
#include "base/thread.h"

static enum stp_result make_resources(const struct stp_env *env, struct record_frame *frame)
{
    const struct stp_plan *plan = frame->plan;
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        enum stp_result result =
            r->format == PLAN_BUFFER
                ? gpu_buffer_create(env, frame->context, r->bytes, GPU_DEVICE, r->name,
                                    &frame->resources.buffer[i])
                : gpu_image_create(env, frame->context, pass_format(r->format), r->width, r->height,
                                   r->layers, r->name, &frame->resources.image[i]);
        if (result == STP_OK && r->lifetime == PLAN_OUTPUT && !frame->resources.buffer[i].mapped)
            result = gpu_buffer_create(env, frame->context, r->bytes, GPU_READ_BACK, r->name,
                                       &frame->read_back[i]);
        if (result != STP_OK)
            return result;
    }
    if (plan->loop_first) {
        enum stp_result result = gpu_buffer_create(env, frame->context, 4, GPU_READ_BACK,
                                                   "what remains", &frame->remaining);
        if (result != STP_OK)
            return result;
    }
    return gpu_buffer_create(env, frame->context, sizeof(struct stp_frame_constants), GPU_DEVICE,
                             "frame constants", &frame->resources.constants);
}

/* Binding 0 is the frame block; an image of slot s, when the plan has it, is 1 + s - first image.
 */
static uint32_t image_bindings(const struct stp_plan *plan, uint32_t binding[PLAN_SLOTS],
                               uint8_t resource[PLAN_SLOTS])
{
    uint32_t count = 0;
    for (uint32_t slot = PLAN_IMAGE_ID; slot < PLAN_SLOTS; slot++) {
        uint8_t found = plan_find(plan, slot);
        if (found == PLAN_NONE || slot == PLAN_IMAGE_DEPTH)
            continue;
        resource[count] = found;
        binding[count++] = 1 + slot - PLAN_IMAGE_ID;
    }
    return count;
}

static VkResult make_layouts(struct record_frame *frame, uint32_t images, const uint32_t *binding)
{
    struct stp_context *c = frame->context;
    const VkShaderStageFlags stages =
        VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    VkDescriptorSetLayoutBinding bindings[1 + PLAN_SLOTS] = {
        { 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, stages, NULL }
    };
    for (uint32_t i = 0; i < images; i++)
        bindings[1 + i] =
            (VkDescriptorSetLayoutBinding){ binding[i], VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, stages,
                                            NULL };
    VkDescriptorSetLayoutCreateInfo set = { .sType =
                                                VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                            .bindingCount = 1 + images,
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

static VkResult make_set(struct record_frame *frame, uint32_t images)
{
    struct stp_context *c = frame->context;
    VkDescriptorPoolSize sizes[] = { { VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1 },
                                     { VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, images } };
    VkDescriptorPoolCreateInfo pool = { .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                        .maxSets = 1,
                                        .poolSizeCount = images ? 2 : 1,
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

static void write_set(struct record_frame *frame, uint32_t images, const uint32_t *binding,
                      const uint8_t *resource)
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
    for (uint32_t i = 0; i < images; i++) {
        image[i] = (VkDescriptorImageInfo){ .imageView = frame->resources.image[resource[i]].all,
                                            .imageLayout = VK_IMAGE_LAYOUT_GENERAL };
        writes[1 + i] = (VkWriteDescriptorSet){ .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                .dstSet = frame->resources.set,
                                                .dstBinding = binding[i],
                                                .descriptorCount = 1,
                                                .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                                                .pImageInfo = &image[i] };
    }
    c->vk.vkUpdateDescriptorSets(c->device, 1 + images, writes, 0, NULL);
}

static enum stp_result make_descriptors(const struct stp_env *env, struct record_frame *frame)
{
    uint32_t binding[PLAN_SLOTS];
    uint8_t resource[PLAN_SLOTS];
    uint32_t images = image_bindings(frame->plan, binding, resource);
    VkResult result = make_layouts(frame, images, binding);
    if (result == VK_SUCCESS)
        result = make_set(frame, images);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "making descriptor sets");
    write_set(frame, images, binding, resource);
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
        gpu_buffer_destroy(c, &frame->resources.buffer[i]);
        gpu_buffer_destroy(c, &frame->read_back[i]);
        gpu_image_destroy(c, &frame->resources.image[i]);
    }
    gpu_buffer_destroy(c, &frame->remaining);
    gpu_buffer_destroy(c, &frame->resources.constants);
    *frame = (struct record_frame){ 0 };
}
