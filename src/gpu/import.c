/* A context on a device of the host's. */
#include "gpu/gpu.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"

static enum stp_result check(const struct stp_env *env, const struct stp_import *import)
{
    const struct {
        bool given;
        const char *name;
    } needed[] = {
        { import->get_instance_proc_addr != NULL, "get_instance_proc_addr" },
        { import->instance != VK_NULL_HANDLE, "instance" },
        { import->physical_device != VK_NULL_HANDLE, "physical_device" },
        { import->device != VK_NULL_HANDLE, "device" },
        { import->features != NULL, "features" },
        { !import->allocator.allocate == !import->allocator.release, "allocator's other half" },
    };
    for (unsigned i = 0; i < sizeof needed / sizeof *needed; i++)
        if (!needed[i].given)
            return log_error(env, STP_ERROR_ARGUMENT, "stp_context_import: no %s", needed[i].name);
    if (import->api_version < VK_API_VERSION_1_3)
        return log_error(
            env, STP_ERROR_FEATURE, "the host's instance is of Vulkan %u.%u; 1.3 is required",
            VK_API_VERSION_MAJOR(import->api_version), VK_API_VERSION_MINOR(import->api_version));
    return STP_OK;
}

static enum stp_result load(const struct stp_env *env, const struct stp_import *import,
                            struct stp_context *context)
{
    struct gpu_instance *instance = &context->instance;
    const char *missing = NULL;
    instance->handle = import->instance;
    instance->global.vkGetInstanceProcAddr = import->get_instance_proc_addr;
#define LOAD(name)                                                                                 \
    instance->vk.name = (PFN_##name)import->get_instance_proc_addr(import->instance, #name);       \
    missing = instance->vk.name ? missing : #name;
    GPU_INSTANCE_FUNCTIONS(LOAD)
#undef LOAD
    if (!missing)
        missing = gpu_device_functions(context);
    return missing ? log_error(env, STP_ERROR_FEATURE, "the host's loader has no %s", missing)
                   : STP_OK;
}

static enum stp_result check_queue(const struct stp_env *env, const struct stp_context *context)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = 0;
    context->instance.vk.vkGetPhysicalDeviceQueueFamilyProperties(context->physical, &count, NULL);
    count = count < 32 ? count : 32;
    context->instance.vk.vkGetPhysicalDeviceQueueFamilyProperties(context->physical, &count,
                                                                  families);
    VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    if (context->family < count && (families[context->family].queueFlags & wanted) == wanted)
        return STP_OK;
    return log_error(env, STP_ERROR_FEATURE, "queue family %u has not both graphics and compute",
                     context->family);
}

/* What the device could do counts for nothing: only what the host has enabled. */
static enum stp_result survey(const struct stp_env *env, const struct stp_import *import,
                              struct stp_context *context)
{
    struct stp_device_info info;
    unsigned enabled;
    gpu_device_survey(&context->instance, context->physical, &info);
    enum stp_result result =
        gpu_features_enabled(env, import->features, info.limits.device, &enabled);
    if (result != STP_OK)
        return result;
    const unsigned not_of_the_chain = STP_FEATURE_FLOAT32_BLEND | STP_FEATURE_SHARED_MEMORY |
                                      STP_FEATURE_TEXEL_BUFFERS | STP_FEATURE_SUBGROUP_SHUFFLE;
    context->limits = info.limits;
    context->limits.features &= enabled | not_of_the_chain;
    context->limits.features &= ~import->mask_features;
    return STP_OK;
}

static enum stp_result fill(const struct stp_env *env, const struct stp_import *import,
                            struct stp_context *context)
{
    context->physical = import->physical_device;
    context->device = import->device;
    context->family = import->queue_family;
    context->cache = import->pipeline_cache;
    context->allocator = import->allocator;
    enum stp_result result = load(env, import, context);
    if (result == STP_OK)
        result = check_queue(env, context);
    if (result == STP_OK)
        result = survey(env, import, context);
    if (result == STP_OK)
        gpu_device_memory(context);
    return result;
}

enum stp_result stp_context_import(const struct stp_env *env, const struct stp_import *import,
                                   struct stp_context **context)
{
    enum stp_result result = check(env, import);
    if (result != STP_OK)
        return result;
    struct stp_context *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return log_no_memory(env, sizeof *made, "the context");
    made->imported = true;
    result = fill(env, import, made);
    if (result != STP_OK)
        mem_free(made);
    else
        *context = made;
    return result;
}
