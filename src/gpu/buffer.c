#include "gpu/memory.h"

static enum stp_result back_buffer(const struct stp_env *env, struct stp_context *context,
                                   enum gpu_memory kind, struct gpu_block *block, const char *what,
                                   struct gpu_buffer *buffer)
{
    VkMemoryRequirements needs;
    context->vk.vkGetBufferMemoryRequirements(context->device, buffer->handle, &needs);
    if (block)
        buffer->memory = memory_take(context, block, &needs);
    else {
        enum stp_result result = memory_allocate(env, context, &needs, kind, what, &buffer->memory);
        if (result != STP_OK)
            return result;
    }
    const struct stp_device_memory *where = &buffer->memory.where;
    VkResult status = context->vk.vkBindBufferMemory(context->device, buffer->handle, where->memory,
                                                     where->offset);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkBindBufferMemory");
    VkBufferDeviceAddressInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                       .buffer = buffer->handle };
    buffer->address = context->vk.vkGetBufferDeviceAddress(context->device, &info);
    buffer->mapped = where->mapped;
    buffer->coherent = buffer->memory.coherent;
    return STP_OK;
}

static VkBufferCreateInfo buffer_info(VkDeviceSize bytes)
{
    return (VkBufferCreateInfo){
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = bytes < 16 ? 16 : bytes,
        .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT
    };
}

VkMemoryRequirements gpu_buffer_needs(const struct stp_context *context, VkDeviceSize bytes)
{
    VkBufferCreateInfo info = buffer_info(bytes);
    VkDeviceBufferMemoryRequirements asked = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS, .pCreateInfo = &info
    };
    VkMemoryRequirements2 needs = { .sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2 };
    context->vk.vkGetDeviceBufferMemoryRequirements(context->device, &asked, &needs);
    return needs.memoryRequirements;
}

static enum stp_result make_buffer(const struct stp_env *env, struct stp_context *context,
                                   VkDeviceSize bytes, enum gpu_memory kind,
                                   struct gpu_block *block, const char *what,
                                   struct gpu_buffer *buffer)
{
    struct gpu_buffer made = { 0 };
    VkBufferCreateInfo info = buffer_info(bytes);
    VkResult status = context->vk.vkCreateBuffer(context->device, &info, NULL, &made.handle);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkCreateBuffer");
    enum stp_result result = back_buffer(env, context, kind, block, what, &made);
    if (result != STP_OK)
        gpu_buffer_destroy(context, &made);
    else
        *buffer = made;
    return result;
}

enum stp_result gpu_buffer_create(const struct stp_env *env, struct stp_context *context,
                                  VkDeviceSize bytes, enum gpu_memory kind, const char *what,
                                  struct gpu_buffer *buffer)
{
    return make_buffer(env, context, bytes, kind, NULL, what, buffer);
}

enum stp_result gpu_buffer_place(const struct stp_env *env, struct stp_context *context,
                                 VkDeviceSize bytes, struct gpu_block *block, const char *what,
                                 struct gpu_buffer *buffer)
{
    return make_buffer(env, context, bytes, GPU_DEVICE, block, what, buffer);
}

void gpu_buffer_destroy(struct stp_context *context, struct gpu_buffer *buffer)
{
    if (buffer->handle)
        context->vk.vkDestroyBuffer(context->device, buffer->handle, NULL);
    memory_release(context, &buffer->memory);
    *buffer = (struct gpu_buffer){ 0 };
}
