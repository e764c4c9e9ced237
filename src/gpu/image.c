#include "base/log.h"
#include "base/memory.h"
#include "gpu/memory.h"

static VkResult make_view(struct stp_context *context, const struct gpu_image *image,
                          VkFormat format, uint32_t first, uint32_t count, VkImageView *view)
{
    VkImageViewCreateInfo info = { .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = image->handle,
                                   .viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                   .format = format,
                                   .subresourceRange = { .aspectMask = image->aspect,
                                                         .levelCount = 1,
                                                         .baseArrayLayer = first,
                                                         .layerCount = count } };
    return context->vk.vkCreateImageView(context->device, &info, NULL, view);
}

static enum stp_result make_views(const struct stp_env *env, struct stp_context *context,
                                  VkFormat format, struct gpu_image *image)
{
    VkResult status = make_view(context, image, format, 0, image->layer_count, &image->all);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkCreateImageView");
    if (image->layer_count == 1)
        return STP_OK;
    image->layers = mem_zalloc(image->layer_count, sizeof *image->layers);
    if (!image->layers)
        return log_no_memory(env, image->layer_count * sizeof *image->layers, "image views");
    for (uint32_t i = 0; i < image->layer_count; i++) {
        status = make_view(context, image, format, i, 1, &image->layers[i]);
        if (status != VK_SUCCESS)
            return gpu_error(env, status, "vkCreateImageView");
    }
    return STP_OK;
}

static enum stp_result back_image(const struct stp_env *env, struct stp_context *context,
                                  struct gpu_block *block, const char *what,
                                  struct gpu_image *image)
{
    VkMemoryRequirements needs;
    context->vk.vkGetImageMemoryRequirements(context->device, image->handle, &needs);
    if (block)
        image->memory = memory_take(context, block, &needs);
    else {
        enum stp_result result =
            memory_allocate(env, context, &needs, GPU_DEVICE, what, &image->memory);
        if (result != STP_OK)
            return result;
    }
    VkResult status = context->vk.vkBindImageMemory(
        context->device, image->handle, image->memory.where.memory, image->memory.where.offset);
    return status == VK_SUCCESS ? STP_OK : gpu_error(env, status, "vkBindImageMemory");
}

static VkImageCreateInfo image_info(VkFormat format, uint32_t width, uint32_t height,
                                    uint32_t layers)
{
    return (VkImageCreateInfo){ .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                .imageType = VK_IMAGE_TYPE_2D,
                                .format = format,
                                .extent = { width, height, 1 },
                                .mipLevels = 1,
                                .arrayLayers = layers,
                                .samples = VK_SAMPLE_COUNT_1_BIT,
                                .usage = format == VK_FORMAT_D32_SFLOAT
                                             ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                             : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                                   VK_IMAGE_USAGE_STORAGE_BIT |
                                                   VK_IMAGE_USAGE_TRANSFER_DST_BIT };
}

VkMemoryRequirements gpu_image_needs(const struct stp_context *context, VkFormat format,
                                     uint32_t width, uint32_t height, uint32_t layers)
{
    VkImageCreateInfo info = image_info(format, width, height, layers);
    VkDeviceImageMemoryRequirements asked = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS, .pCreateInfo = &info
    };
    VkMemoryRequirements2 needs = { .sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2 };
    context->vk.vkGetDeviceImageMemoryRequirements(context->device, &asked, &needs);
    return needs.memoryRequirements;
}

enum stp_result gpu_image_create(const struct stp_env *env, struct stp_context *context,
                                 VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                                 struct gpu_block *block, const char *what, struct gpu_image *image)
{
    bool depth = format == VK_FORMAT_D32_SFLOAT;
    struct gpu_image made = { .layer_count = layers,
                              .aspect =
                                  depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT };
    VkImageCreateInfo info = image_info(format, width, height, layers);
    VkResult status = context->vk.vkCreateImage(context->device, &info, NULL, &made.handle);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkCreateImage");
    enum stp_result result = back_image(env, context, block, what, &made);
    if (result == STP_OK)
        result = make_views(env, context, format, &made);
    if (result != STP_OK)
        gpu_image_destroy(context, &made);
    else
        *image = made;
    return result;
}

void gpu_image_destroy(struct stp_context *context, struct gpu_image *image)
{
    for (uint32_t i = 0; image->layers && i < image->layer_count; i++)
        if (image->layers[i])
            context->vk.vkDestroyImageView(context->device, image->layers[i], NULL);
    mem_free(image->layers);
    if (image->all)
        context->vk.vkDestroyImageView(context->device, image->all, NULL);
    if (image->handle)
        context->vk.vkDestroyImage(context->device, image->handle, NULL);
    memory_release(context, &image->memory);
    *image = (struct gpu_image){ 0 };
}
