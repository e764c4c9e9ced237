#include "gpu/gpu.h"

#include "base/log.h"

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
