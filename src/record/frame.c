#include "record/record.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

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

/* What is bound beside the frame block, whose binding is 0: images and texels. */
struct bindings {
    uint32_t count;
    uint32_t binding[PLAN_SLOTS];
    uint8_t resource[PLAN_SLOTS];
    VkDescriptorType type[PLAN_SLOTS];
};

/* Slots have an address, and may be fetched as texels besides. Where they have no ids the slots
 * themselves stand at that binding: shaders name it, but fetch nothing. */
static uint8_t find_bound(const struct stp_plan *plan, uint32_t slot)
{
    if (slot != PLAN_TEXEL_KEYS && slot != PLAN_TEXEL_SLOT_IDS)
        return plan_find(plan, slot);
    uint8_t keys = plan_find(plan, PLAN_KEYS), ids = plan_find(plan, PLAN_SLOT_IDS);
    if (keys == PLAN_NONE || !pass_is_texels(plan->resource[keys].format))
        return PLAN_NONE;
    return slot == PLAN_TEXEL_SLOT_IDS && ids != PLAN_NONE ? ids : keys;
}

static struct bindings find_bindings(const struct stp_plan *plan)
{
    struct bindings b = { 0 };
    for (uint32_t slot = PLAN_BUFFER_SLOTS; slot < PLAN_SLOTS; slot++) {
        uint8_t found = find_bound(plan, slot);
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

static VkResult make_layouts(struct stp_context *c, struct record_pipelines *p,
                             const struct bindings *b, bool hosted)
{
    VkDescriptorSetLayoutBinding bindings[1 + PLAN_SLOTS] = {
        { 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, PASS_PUSH_STAGES, NULL }
    };
    for (uint32_t i = 0; i < b->count; i++)
        bindings[1 + i] =
            (VkDescriptorSetLayoutBinding){ b->binding[i], b->type[i], 1, PASS_PUSH_STAGES, NULL };
    VkDescriptorSetLayoutCreateInfo set = { .sType =
                                                VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                            .bindingCount = 1 + b->count,
                                            .pBindings = bindings };
    VkResult result = c->vk.vkCreateDescriptorSetLayout(c->device, &set, NULL, &p->set_layout);
    if (result != VK_SUCCESS)
        return result;
    uint32_t bytes = PASS_PUSH_HOST + (hosted ? (uint32_t)sizeof(struct pass_host_push) : 0);
    VkPushConstantRange push = { PASS_PUSH_STAGES, 0, bytes };
    VkPipelineLayoutCreateInfo layout = { .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &p->set_layout,
                                          .pushConstantRangeCount = 1,
                                          .pPushConstantRanges = &push };
    return c->vk.vkCreatePipelineLayout(c->device, &layout, NULL, &p->layout);
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
                                        .pSetLayouts = &frame->pipelines->set_layout };
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
    VkResult result = make_set(frame, &bindings);
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
                          &m->frame->resources, &m->frame->pipelines->pipeline[i]);
}

static enum stp_result compile(const struct stp_env *env, struct record_frame *frame)
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
                                   &frame->resources, &frame->pipelines->pipeline[i]);
        if (result != STP_OK)
            return result;
    }
    return STP_OK;
}

static enum stp_result make_pipelines(const struct stp_env *env, struct record_frame *frame,
                                      const struct record_host *host)
{
    struct bindings bindings = find_bindings(frame->plan);
    struct record_pipelines *p = mem_zalloc(1, sizeof *p);
    if (!p)
        return log_no_memory(env, sizeof *p, "pipelines");
    p->users = 1;
    frame->pipelines = p;
    VkResult status = make_layouts(frame->context, p, &bindings, host != NULL);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "making pipeline layouts");
    frame->resources.layout = p->layout;
    enum stp_result result = compile(env, frame);
    if (result == STP_OK && host)
        result =
            pass_host_pipeline(env, frame->context, frame->plan, &host->pass, p->layout, &p->host);
    return result;
}

static void share_pipelines(struct record_frame *frame, struct record_pipelines *p)
{
    p->users++;
    frame->pipelines = p;
    frame->resources.layout = p->layout;
}

static void leave_pipelines(struct stp_context *c, struct record_pipelines *p)
{
    if (!p || --p->users > 0)
        return;
    for (uint32_t i = 0; i < PLAN_MAX_PASSES; i++)
        if (p->pipeline[i])
            c->vk.vkDestroyPipeline(c->device, p->pipeline[i], NULL);
    if (p->host)
        c->vk.vkDestroyPipeline(c->device, p->host, NULL);
    if (p->layout)
        c->vk.vkDestroyPipelineLayout(c->device, p->layout, NULL);
    if (p->set_layout)
        c->vk.vkDestroyDescriptorSetLayout(c->device, p->set_layout, NULL);
    mem_free(p);
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
        result = make_pipelines(env, frame, NULL);
    if (result == STP_OK)
        result = make_descriptors(env, frame);
    if (result == STP_OK)
        result = make_queries(env, frame);
    return keep_or_destroy(result, frame);
}

/* One block, unless no type of memory holds both the buffers and the images. */
static enum stp_result make_scratch(const struct stp_env *env, struct record_frame *frame,
                                    const struct record_host *host)
{
    if (host->scratch) {
        frame->scratch.part.where = *host->scratch;
        return STP_OK;
    }
    VkMemoryRequirements needs =
        record_resources_need(frame->context, frame->plan, RECORD_WITHOUT_SCENE);
    return needs.memoryTypeBits ? gpu_block_create(env, frame->context, &needs, GPU_DEVICE,
                                                   "a frame's scratch", &frame->scratch)
                                : STP_OK;
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
    if (result == STP_OK && host->pipelines)
        share_pipelines(frame, host->pipelines);
    else if (result == STP_OK)
        result = make_pipelines(env, frame, host);
    if (result == STP_OK)
        result = make_descriptors(env, frame);
    return keep_or_destroy(result, frame);
}

void record_frame_destroy(struct record_frame *frame)
{
    struct stp_context *c = frame->context;
    if (!c)
        return;
    leave_pipelines(c, frame->pipelines);
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
