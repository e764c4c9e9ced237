/* Parts of buffers, to and from the host, between submissions. */
#include "gpu/gpu.h"

#include <assert.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

void *gpu_view(const struct gpu_buffer *buffer)
{
    return buffer->coherent ? buffer->mapped : NULL;
}

/* Copies within the device, after all that was submitted before; waits. */
static enum stp_result copy(const struct stp_env *env, struct stp_context *context, VkBuffer from,
                            VkBuffer to, const VkBufferCopy *region)
{
    enum stp_result result = gpu_begin(env, context);
    if (result != STP_OK)
        return result;
    VkMemoryBarrier2 memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT
    };
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .memoryBarrierCount = 1,
                              .pMemoryBarriers = &memory };
    context->vk.vkCmdPipelineBarrier2(context->commands, &info);
    context->vk.vkCmdCopyBuffer(context->commands, from, to, 1, region);
    context->vk.vkCmdPipelineBarrier2(context->commands, &info);
    return gpu_submit_and_wait(env, context);
}

enum stp_result gpu_upload_at(const struct stp_env *env, struct stp_context *context,
                              struct gpu_buffer *buffer, size_t offset, const void *data,
                              size_t bytes)
{
    struct gpu_buffer staging;
    VkBufferCopy region = { .dstOffset = offset, .size = bytes };
    if (bytes == 0)
        return STP_OK;
    if (gpu_view(buffer)) {
        memcpy((char *)buffer->mapped + offset, data, bytes);
        return STP_OK;
    }
    enum stp_result result =
        gpu_buffer_create(env, context, bytes, GPU_UPLOAD, "staging", &staging);
    if (result != STP_OK)
        return result;
    memcpy(staging.mapped, data, bytes);
    if (context->imported) {
        assert(context->pending_count < GPU_MOST_PENDING);
        context->pending[context->pending_count++] =
            (struct gpu_pending){ staging, buffer->handle, region };
        return STP_OK;
    }
    result = copy(env, context, staging.handle, buffer->handle, &region);
    gpu_buffer_destroy(context, &staging);
    return result;
}

enum stp_result gpu_upload(const struct stp_env *env, struct stp_context *context,
                           struct gpu_buffer *buffer, const void *data, size_t bytes)
{
    return gpu_upload_at(env, context, buffer, 0, data, bytes);
}

void *gpu_fill_begin(const struct stp_env *env, const struct gpu_buffer *buffer, size_t count,
                     size_t size, const char *what)
{
    void *place = gpu_view(buffer);
    if (!place)
        place = mem_alloc(count, size);
    if (!place)
        log_no_memory(env, count * size, what);
    return place;
}

enum stp_result gpu_fill_end(const struct stp_env *env, struct stp_context *context,
                             struct gpu_buffer *buffer, void *filled, size_t bytes)
{
    if (filled == gpu_view(buffer))
        return STP_OK;
    enum stp_result result = gpu_upload(env, context, buffer, filled, bytes);
    mem_free(filled);
    return result;
}

void gpu_fill_drop(const struct gpu_buffer *buffer, void *filled)
{
    if (filled != gpu_view(buffer))
        mem_free(filled);
}

static enum stp_result invalidate(const struct stp_env *env, struct stp_context *context,
                                  const struct gpu_buffer *buffer)
{
    VkMappedMemoryRange range = { .sType = VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE,
                                  .memory = buffer->memory.where.memory,
                                  .size = VK_WHOLE_SIZE };
    if (buffer->coherent)
        return STP_OK;
    VkResult status = context->vk.vkInvalidateMappedMemoryRanges(context->device, 1, &range);
    return status == VK_SUCCESS ? STP_OK : gpu_error(env, status, "vkInvalidateMappedMemoryRanges");
}

enum stp_result gpu_download(const struct stp_env *env, struct stp_context *context,
                             const struct gpu_buffer *buffer, size_t offset, void *data,
                             size_t bytes)
{
    struct gpu_buffer staging;
    if (gpu_view(buffer)) {
        memcpy(data, (const char *)buffer->mapped + offset, bytes);
        return STP_OK;
    }
    enum stp_result result =
        gpu_buffer_create(env, context, bytes, GPU_READ_BACK, "staging", &staging);
    if (result != STP_OK)
        return result;
    VkBufferCopy region = { .srcOffset = offset, .size = bytes };
    result = copy(env, context, buffer->handle, staging.handle, &region);
    if (result == STP_OK)
        result = invalidate(env, context, &staging);
    if (result == STP_OK)
        memcpy(data, staging.mapped, bytes);
    gpu_buffer_destroy(context, &staging);
    return result;
}
