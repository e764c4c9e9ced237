/* The buffers and images of a plan. */
#include "record/record.h"

#include "base/log.h"

static enum stp_result make_buffer(const struct stp_env *env, struct stp_context *context,
                                   uint64_t bytes, struct gpu_block *block, const char *name,
                                   struct gpu_buffer *buffer)
{
    return block ? gpu_buffer_place(env, context, bytes, block, name, buffer)
                 : gpu_buffer_create(env, context, bytes, GPU_DEVICE, name, buffer);
}

static enum stp_result make_texels(const struct stp_env *env, struct stp_context *context,
                                   const struct plan_resource *resource,
                                   const struct gpu_buffer *buffer, VkBufferView *view)
{
    VkBufferViewCreateInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                    .buffer = buffer->handle,
                                    .format = pass_format(resource->format),
                                    .range = resource->bytes };
    VkResult status = context->vk.vkCreateBufferView(context->device, &info, NULL, view);
    return status == VK_SUCCESS ? STP_OK : gpu_error(env, status, "vkCreateBufferView");
}

enum stp_result record_resources_create(const struct stp_env *env, struct stp_context *context,
                                        const struct stp_plan *plan, unsigned wanted,
                                        struct gpu_block *block, struct pass_resources *resources)
{
    enum stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        if (!(wanted >> r->lifetime & 1))
            continue;
        result = !pass_is_image(r->format)
                     ? make_buffer(env, context, r->bytes, block, r->name, &resources->buffer[i])
                     : gpu_image_create(env, context, pass_format(r->format), r->width, r->height,
                                        r->layers, block, r->name, &resources->image[i]);
        if (result == STP_OK && pass_is_texels(r->format))
            result = make_texels(env, context, r, &resources->buffer[i], &resources->texels[i]);
    }
    if (result == STP_OK)
        result = make_buffer(env, context, sizeof(struct stp_frame_constants), block,
                             "frame constants", &resources->constants);
    return result;
}

void record_resources_destroy(struct stp_context *context, struct pass_resources *resources)
{
    for (uint32_t i = 0; i < PLAN_MAX_RESOURCES; i++) {
        if (resources->texels[i])
            context->vk.vkDestroyBufferView(context->device, resources->texels[i], NULL);
        resources->texels[i] = VK_NULL_HANDLE;
        gpu_buffer_destroy(context, &resources->buffer[i]);
        gpu_image_destroy(context, &resources->image[i]);
    }
    gpu_buffer_destroy(context, &resources->constants);
}

VkMemoryRequirements record_resources_need(const struct stp_context *context,
                                           const struct stp_plan *plan, unsigned wanted)
{
    VkMemoryRequirements sum = { .alignment = 1, .memoryTypeBits = UINT32_MAX };
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        if (!(wanted >> r->lifetime & 1))
            continue;
        VkMemoryRequirements needs =
            !pass_is_image(r->format)
                ? gpu_buffer_needs(context, r->bytes)
                : gpu_image_needs(context, pass_format(r->format), r->width, r->height, r->layers);
        gpu_needs_add(context, &needs, &sum);
    }
    VkMemoryRequirements constants = gpu_buffer_needs(context, sizeof(struct stp_frame_constants));
    gpu_needs_add(context, &constants, &sum);
    return sum;
}
