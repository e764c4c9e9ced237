#include "gpu/gpu.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"

/* The first type that has what is wanted, by falling wishes. */
static uint32_t memory_type(const struct stp_context *context, uint32_t allowed,
                            enum gpu_memory kind)
{
    const VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
    const VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    const VkMemoryPropertyFlags coherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    const VkMemoryPropertyFlags wishes[3][3] = {
        [GPU_DEVICE] = { local, 0, 0 },
        [GPU_UPLOAD] = { visible | coherent, visible | coherent, visible },
        [GPU_READ_BACK] = { visible | cached | coherent, visible | cached, visible },
    };
    for (int wish = 0; wish < 3; wish++)
        for (uint32_t i = 0; i < context->memory.memoryTypeCount; i++)
            if ((allowed >> i & 1) && (context->memory.memoryTypes[i].propertyFlags &
                                       wishes[kind][wish]) == wishes[kind][wish])
                return i;
    return 0;
}

static enum stp_result allocate(const struct stp_env *env, struct stp_context *context,
                                const VkMemoryRequirements *needs, enum gpu_memory kind,
                                bool address, const char *what, VkDeviceMemory *memory,
                                VkMemoryPropertyFlags *flags)
{
    VkMemoryAllocateFlagsInfo with_address = { .sType =
                                                   VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                               .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT };
    VkMemoryAllocateInfo info = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .pNext = address ? &with_address : NULL,
                                  .allocationSize = needs->size,
                                  .memoryTypeIndex =
                                      memory_type(context, needs->memoryTypeBits, kind) };
    VkResult result = context->vk.vkAllocateMemory(context->device, &info, NULL, memory);
    if (result != VK_SUCCESS && result != VK_ERROR_OUT_OF_DEVICE_MEMORY)
        return gpu_error(env, result, "vkAllocateMemory");
    if (result != VK_SUCCESS)
        return log_error(env, STP_ERROR_DEVICE_MEMORY,
                         "%s has no %llu bytes left for %s (%llu are in use); a smaller --size or "
                         "--tile-memory may fit",
                         context->limits.device, (unsigned long long)needs->size, what,
                         (unsigned long long)context->allocated);
    *flags = context->memory.memoryTypes[info.memoryTypeIndex].propertyFlags;
    context->allocated += needs->size;
    if (context->allocated > context->peak)
        context->peak = context->allocated;
    return STP_OK;
}

static enum stp_result back_buffer(const struct stp_env *env, struct stp_context *context,
                                   enum gpu_memory kind, const char *what,
                                   struct gpu_buffer *buffer)
{
    VkMemoryRequirements needs;
    VkMemoryPropertyFlags flags = 0;
    context->vk.vkGetBufferMemoryRequirements(context->device, buffer->handle, &needs);
    enum stp_result result =
        allocate(env, context, &needs, kind, true, what, &buffer->memory, &flags);
    if (result != STP_OK)
        return result;
    buffer->bytes = needs.size;
    VkResult status =
        context->vk.vkBindBufferMemory(context->device, buffer->handle, buffer->memory, 0);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkBindBufferMemory");
    VkBufferDeviceAddressInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                       .buffer = buffer->handle };
    buffer->address = context->vk.vkGetBufferDeviceAddress(context->device, &info);
    /* Cached and device-local: the device is the host, and a copy would only cost. */
    const VkMemoryPropertyFlags shared = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                         VK_MEMORY_PROPERTY_HOST_CACHED_BIT |
                                         VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    buffer->coherent = (flags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) != 0;
    if (kind == GPU_DEVICE && (flags & shared) != shared)
        return STP_OK;
    status = context->vk.vkMapMemory(context->device, buffer->memory, 0, VK_WHOLE_SIZE, 0,
                                     &buffer->mapped);
    return status == VK_SUCCESS ? STP_OK : gpu_error(env, status, "vkMapMemory");
}

enum stp_result gpu_buffer_create(const struct stp_env *env, struct stp_context *context,
                                  VkDeviceSize bytes, enum gpu_memory kind, const char *what,
                                  struct gpu_buffer *buffer)
{
    struct gpu_buffer made = { 0 };
    VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = bytes < 16 ? 16 : bytes,
        .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT
    };
    VkResult status = context->vk.vkCreateBuffer(context->device, &info, NULL, &made.handle);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkCreateBuffer");
    enum stp_result result = back_buffer(env, context, kind, what, &made);
    if (result != STP_OK)
        gpu_buffer_destroy(context, &made);
    else
        *buffer = made;
    return result;
}

void gpu_buffer_destroy(struct stp_context *context, struct gpu_buffer *buffer)
{
    if (buffer->handle)
        context->vk.vkDestroyBuffer(context->device, buffer->handle, NULL);
    if (buffer->memory)
        context->vk.vkFreeMemory(context->device, buffer->memory, NULL);
    context->allocated -= buffer->bytes;
    *buffer = (struct gpu_buffer){ 0 };
}

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
                                  const char *what, struct gpu_image *image)
{
    VkMemoryRequirements needs;
    VkMemoryPropertyFlags flags;
    context->vk.vkGetImageMemoryRequirements(context->device, image->handle, &needs);
    enum stp_result result =
        allocate(env, context, &needs, GPU_DEVICE, false, what, &image->memory, &flags);
    if (result != STP_OK)
        return result;
    image->bytes = needs.size;
    VkResult status =
        context->vk.vkBindImageMemory(context->device, image->handle, image->memory, 0);
    return status == VK_SUCCESS ? STP_OK : gpu_error(env, status, "vkBindImageMemory");
}

enum stp_result gpu_image_create(const struct stp_env *env, struct stp_context *context,
                                 VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                                 const char *what, struct gpu_image *image)
{
    bool depth = format == VK_FORMAT_D32_SFLOAT;
    struct gpu_image made = { .layer_count = layers,
                              .aspect =
                                  depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT };
    VkImageCreateInfo info = { .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = format,
                               .extent = { width, height, 1 },
                               .mipLevels = 1,
                               .arrayLayers = layers,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                              : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                                    VK_IMAGE_USAGE_STORAGE_BIT };
    VkResult status = context->vk.vkCreateImage(context->device, &info, NULL, &made.handle);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkCreateImage");
    enum stp_result result = back_image(env, context, what, &made);
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
    if (image->memory)
        context->vk.vkFreeMemory(context->device, image->memory, NULL);
    context->allocated -= image->bytes;
    *image = (struct gpu_image){ 0 };
}

enum stp_result gpu_begin(const struct stp_env *env, struct stp_context *context)
{
    VkResult result = context->vk.vkResetCommandPool(context->device, context->pool, 0);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkResetCommandPool");
    VkCommandBufferBeginInfo info = { .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT };
    result = context->vk.vkBeginCommandBuffer(context->commands, &info);
    return result == VK_SUCCESS ? STP_OK : gpu_error(env, result, "vkBeginCommandBuffer");
}

/* The fence is reset here, not after it was waited for: a failure between leaves nothing to mend.
 */
static enum stp_result submit(const struct stp_env *env, struct stp_context *context)
{
    VkResult result = context->vk.vkResetFences(context->device, 1, &context->fence);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkResetFences");
    VkCommandBufferSubmitInfo commands = { .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                           .commandBuffer = context->commands };
    VkSubmitInfo2 info = { .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .commandBufferInfoCount = 1,
                           .pCommandBufferInfos = &commands };
    result = context->vk.vkQueueSubmit2(context->queue, 1, &info, context->fence);
    return result == VK_SUCCESS ? STP_OK : gpu_error(env, result, "vkQueueSubmit2");
}

enum stp_result gpu_submit_and_wait(const struct stp_env *env, struct stp_context *context)
{
    VkResult status = context->vk.vkEndCommandBuffer(context->commands);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkEndCommandBuffer");
    enum stp_result result = submit(env, context);
    if (result != STP_OK)
        return result;
    status = context->vk.vkWaitForFences(context->device, 1, &context->fence, VK_TRUE, UINT64_MAX);
    if (status == VK_SUCCESS)
        return STP_OK;
    /* What was submitted may still run, and the caller is about to destroy what it uses. */
    context->vk.vkDeviceWaitIdle(context->device);
    return gpu_error(env, status, "vkWaitForFences");
}

enum stp_result gpu_upload(const struct stp_env *env, struct stp_context *context,
                           struct gpu_buffer *buffer, const void *data, size_t bytes)
{
    if (buffer->mapped && buffer->coherent) {
        memcpy(buffer->mapped, data, bytes);
        return STP_OK;
    }
    struct gpu_buffer staging;
    enum stp_result result =
        gpu_buffer_create(env, context, bytes, GPU_UPLOAD, "staging", &staging);
    if (result != STP_OK)
        return result;
    memcpy(staging.mapped, data, bytes);
    result = gpu_begin(env, context);
    if (result == STP_OK) {
        VkBufferCopy copy = { .size = bytes };
        context->vk.vkCmdCopyBuffer(context->commands, staging.handle, buffer->handle, 1, &copy);
        result = gpu_submit_and_wait(env, context);
    }
    gpu_buffer_destroy(context, &staging);
    return result;
}
