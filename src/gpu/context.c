#include "gpu/gpu.h"

#include <string.h>
#include <strings.h>

#include "base/log.h"
#include "base/memory.h"

/* The first of the best kind among those that are usable and named so; without one *best holds
 * what the first that is named so lacks. */
static VkPhysicalDevice best_device(const struct gpu_instance *instance,
                                    const VkPhysicalDevice *devices, uint32_t count,
                                    const char *name, struct stp_device_info *best)
{
    VkPhysicalDevice chosen = VK_NULL_HANDLE;
    struct stp_device_info info;
    for (uint32_t i = 0; i < count; i++) {
        bool usable = gpu_device_survey(instance, devices[i], &info);
        if (name && !strcasestr(info.limits.device, name))
            continue;
        if (!usable && !best->limits.device[0])
            *best = info;
        if (!usable || (best->usable && best->limits.processor >= info.limits.processor))
            continue;
        *best = info;
        chosen = devices[i];
    }
    return chosen;
}

static enum stp_result choose(const struct stp_env *env, const struct stp_context_params *params,
                              struct stp_context *context)
{
    VkPhysicalDevice *devices = NULL;
    uint32_t count = 0;
    struct stp_device_info best = { 0 };
    enum stp_result result = gpu_instance_devices(env, &context->instance, &devices, &count);
    if (result != STP_OK)
        return result;
    context->physical = best_device(&context->instance, devices, count, params->device, &best);
    mem_free(devices);
    context->limits = best.limits;
    if (context->physical)
        return STP_OK;
    if (best.limits.device[0])
        return log_error(env, STP_ERROR_FEATURE, "%s lacks %s", best.limits.device, best.lacks);
    if (params->device)
        return log_error(env, STP_ERROR_NO_DEVICE,
                         "no Vulkan device is called \"%s\"; see stipple devices", params->device);
    return log_error(env, STP_ERROR_NO_DEVICE,
                     "no Vulkan device; install mesa-vulkan-drivers for a software one, or use "
                     "--method reference");
}

enum stp_result stp_context_create(const struct stp_env *env,
                                   const struct stp_context_params *params,
                                   struct stp_context **context)
{
    static const struct stp_context_params defaults;
    struct stp_context *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return log_no_memory(env, sizeof *made, "the context");
    params = params ? params : &defaults;
    made->env = env;
    enum stp_result result = gpu_instance_create(env, params->validate, made, &made->instance);
    if (result == STP_OK)
        result = choose(env, params, made);
    if (result == STP_OK) {
        made->limits.features &= ~params->mask_features;
        if (!(made->limits.features & STP_FEATURE_INT64))
            result = log_error(env, STP_ERROR_FEATURE, "%s lacks shaderInt64, which is required",
                               made->limits.device);
    }
    if (result == STP_OK)
        result = gpu_device_create(env, made);
    made->env = NULL;
    if (result != STP_OK)
        stp_context_destroy(&made);
    else
        *context = made;
    return result;
}

const struct stp_limits *stp_context_limits(const struct stp_context *context)
{
    return &context->limits;
}

unsigned stp_context_messages(const struct stp_context *context)
{
    return context->messages;
}

void stp_context_destroy(struct stp_context **context)
{
    if (!context || !*context)
        return;
    struct stp_context *c = *context;
    if (c->device && !c->imported)
        c->vk.vkDeviceWaitIdle(c->device);
    gpu_trim(c);
    if (c->device && !c->imported) {
        c->vk.vkDestroyPipelineCache(c->device, c->cache, NULL);
        c->vk.vkDestroyFence(c->device, c->fence, NULL);
        c->vk.vkDestroyCommandPool(c->device, c->pool, NULL);
        c->vk.vkDestroyDevice(c->device, NULL);
    }
    if (!c->imported)
        gpu_instance_destroy(&c->instance);
    mem_free(c);
    *context = NULL;
}

enum stp_result stp_devices(const struct stp_env *env, struct stp_device_info *devices,
                            unsigned capacity, unsigned *count)
{
    struct gpu_instance instance;
    VkPhysicalDevice *handles = NULL;
    uint32_t found = 0;
    enum stp_result result = gpu_instance_create(env, false, NULL, &instance);
    if (result != STP_OK)
        return result;
    result = gpu_instance_devices(env, &instance, &handles, &found);
    for (uint32_t i = 0; i < found && i < capacity; i++)
        gpu_device_survey(&instance, handles[i], &devices[i]);
    mem_free(handles);
    gpu_instance_destroy(&instance);
    if (result == STP_OK)
        *count = found;
    return result;
}
