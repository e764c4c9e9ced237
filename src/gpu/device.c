#include "gpu/gpu.h"

#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "plan/plan.h"
#include "plan/profile.h"

static void lack(struct stp_device_info *info, bool present, bool required, const char *name)
{
    if (present)
        return;
    size_t used = strlen(info->lacks);
    snprintf(info->lacks + used, sizeof info->lacks - used, "%s%s%s", used ? ", " : "", name,
             required ? " (required)" : "");
    if (required)
        info->usable = false;
}

static bool blends_float32(const struct gpu_instance *instance, VkPhysicalDevice device)
{
    const VkFormat formats[] = { VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R32G32_SFLOAT };
    for (int i = 0; i < 2; i++) {
        VkFormatProperties2 p = { .sType = VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2 };
        instance->vk.vkGetPhysicalDeviceFormatProperties2(device, formats[i], &p);
        if (!(p.formatProperties.optimalTilingFeatures &
              VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT))
            return false;
    }
    return true;
}

static void survey_features(const struct gpu_instance *instance, VkPhysicalDevice device,
                            struct stp_device_info *info)
{
    struct stp_vulkan_features f;
    gpu_features_chain(&f);
    instance->vk.vkGetPhysicalDeviceFeatures2(device, &f.core);
    if (gpu_features_lacking(&f, true, info->lacks, sizeof info->lacks))
        info->usable = false;
    gpu_features_lacking(&f, false, info->lacks, sizeof info->lacks);
    bool blend = blends_float32(instance, device);
    lack(info, blend, false, "blending into float32");
    info->limits.features = gpu_features_flags(&f) | (blend ? STP_FEATURE_FLOAT32_BLEND : 0);
}

static bool shares_memory(const VkPhysicalDeviceMemoryProperties *memory)
{
    const VkMemoryPropertyFlags shared = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                         VK_MEMORY_PROPERTY_HOST_CACHED_BIT |
                                         VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    for (uint32_t i = 0; i < memory->memoryTypeCount; i++)
        if ((memory->memoryTypes[i].propertyFlags & shared) == shared)
            return true;
    return false;
}

static void survey_memory(const struct gpu_instance *instance, VkPhysicalDevice device,
                          struct stp_limits *limits)
{
    VkPhysicalDeviceMemoryProperties memory;
    instance->vk.vkGetPhysicalDeviceMemoryProperties(device, &memory);
    for (uint32_t i = 0; i < memory.memoryHeapCount; i++)
        if ((memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) &&
            memory.memoryHeaps[i].size > limits->heap_bytes)
            limits->heap_bytes = memory.memoryHeaps[i].size;
    if (shares_memory(&memory))
        limits->features |= STP_FEATURE_SHARED_MEMORY;
}

/* Where subgroups have one size, a shader has no other. */
static bool shuffles_by_eight(const VkPhysicalDeviceVulkan11Properties *p,
                              const VkPhysicalDeviceVulkan13Properties *sizes)
{
    const VkSubgroupFeatureFlags needed =
        VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_BIT;
    return sizes->minSubgroupSize == 8 && sizes->maxSubgroupSize == 8 &&
           (p->subgroupSupportedStages & VK_SHADER_STAGE_COMPUTE_BIT) &&
           (p->subgroupSupportedOperations & needed) == needed;
}

/* A side of images that are drawn to; viewports are as large at least. */
static uint32_t largest_target(const VkPhysicalDeviceLimits *l)
{
    uint32_t framebuffer = l->maxFramebufferWidth < l->maxFramebufferHeight
                               ? l->maxFramebufferWidth
                               : l->maxFramebufferHeight;
    return l->maxImageDimension2D < framebuffer ? l->maxImageDimension2D : framebuffer;
}

bool gpu_device_survey(const struct gpu_instance *instance, VkPhysicalDevice device,
                       struct stp_device_info *info)
{
    VkPhysicalDeviceVulkan11Properties v11 = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES
    };
    VkPhysicalDeviceVulkan13Properties v13 = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES, .pNext = &v11
    };
    VkPhysicalDeviceVulkan12Properties v12 = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES, .pNext = &v13
    };
    VkPhysicalDeviceProperties2 p = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                      .pNext = &v12 };
    instance->vk.vkGetPhysicalDeviceProperties2(device, &p);
    *info = (struct stp_device_info){ .usable = true };
    struct stp_limits *l = &info->limits;
    calibration_built_in(&l->calibration);
    uint32_t v = p.properties.apiVersion;
    snprintf(info->api_version, sizeof info->api_version, "%u.%u.%u", VK_API_VERSION_MAJOR(v),
             VK_API_VERSION_MINOR(v), VK_API_VERSION_PATCH(v));
    snprintf(l->device, sizeof l->device, "%s", p.properties.deviceName);
    lack(info, v >= VK_API_VERSION_1_3, true, "Vulkan 1.3");
    if (!info->usable)
        return false;
    snprintf(l->driver, sizeof l->driver, "%.120s %.120s", v12.driverName, v12.driverInfo);
    l->max_allocation = v11.maxMemoryAllocationSize < v13.maxBufferSize
                            ? v11.maxMemoryAllocationSize
                            : v13.maxBufferSize;
    l->max_image_size = largest_target(&p.properties.limits);
    l->max_image_layers = p.properties.limits.maxImageArrayLayers;
    l->max_workgroups = p.properties.limits.maxComputeWorkGroupCount[0];
    l->max_texels = p.properties.limits.maxTexelBufferElements;
    l->processor = p.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU ? STP_PROCESSOR_CPU
                                                                          : STP_PROCESSOR_GPU;
    survey_features(instance, device, info);
    survey_memory(instance, device, l);
    if (l->max_texels >= PLAN_MANY_TEXELS)
        l->features |= STP_FEATURE_TEXEL_BUFFERS;
    if (shuffles_by_eight(&v11, &v13))
        l->features |= STP_FEATURE_SUBGROUP_SHUFFLE;
    return info->usable;
}

static enum stp_result find_queue(const struct stp_env *env, struct stp_context *context)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    context->instance.vk.vkGetPhysicalDeviceQueueFamilyProperties(context->physical, &count,
                                                                  families);
    VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (uint32_t i = 0; i < count; i++) {
        if ((families[i].queueFlags & wanted) != wanted)
            continue;
        context->family = i;
        VkPhysicalDeviceProperties2 p = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2 };
        context->instance.vk.vkGetPhysicalDeviceProperties2(context->physical, &p);
        uint32_t bits = families[i].timestampValidBits;
        if (bits)
            context->timestamp_ms = p.properties.limits.timestampPeriod * 1e-6;
        context->timestamp_mask = bits < 64 ? ((uint64_t)1 << bits) - 1 : UINT64_MAX;
        return STP_OK;
    }
    return log_error(env, STP_ERROR_FEATURE, "%s has no queue for graphics and compute",
                     context->limits.device);
}

const char *gpu_device_functions(struct stp_context *context)
{
    const char *missing = NULL;
#define LOAD(name)                                                                                 \
    context->vk.name =                                                                             \
        (PFN_##name)context->instance.vk.vkGetDeviceProcAddr(context->device, #name);              \
    missing = context->vk.name ? missing : #name;
    GPU_DEVICE_FUNCTIONS(LOAD)
#undef LOAD
    return missing;
}

void gpu_device_memory(struct stp_context *context)
{
    VkPhysicalDeviceProperties2 p = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2 };
    context->instance.vk.vkGetPhysicalDeviceMemoryProperties(context->physical, &context->memory);
    context->instance.vk.vkGetPhysicalDeviceProperties2(context->physical, &p);
    context->granularity = p.properties.limits.bufferImageGranularity;
}

static VkResult create_device(struct stp_context *context)
{
    struct stp_vulkan_features f;
    gpu_features_wanted(context->limits.features, &f);
    float priority = 1;
    VkDeviceQueueCreateInfo queue = { .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                      .queueFamilyIndex = context->family,
                                      .queueCount = 1,
                                      .pQueuePriorities = &priority };
    VkDeviceCreateInfo info = { .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                .pNext = &f.core,
                                .queueCreateInfoCount = 1,
                                .pQueueCreateInfos = &queue };
    VkResult result =
        context->instance.vk.vkCreateDevice(context->physical, &info, NULL, &context->device);
    if (result == VK_SUCCESS)
        gpu_device_functions(context); /* of Vulkan 1.3, which the device was chosen for */
    return result;
}

enum stp_result gpu_device_create(const struct stp_env *env, struct stp_context *context)
{
    enum stp_result found = find_queue(env, context);
    if (found != STP_OK)
        return found;
    VkResult result = create_device(context);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkCreateDevice");
    context->vk.vkGetDeviceQueue(context->device, context->family, 0, &context->queue);
    gpu_device_memory(context);
    VkCommandPoolCreateInfo pool = { .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                     .queueFamilyIndex = context->family };
    result = context->vk.vkCreateCommandPool(context->device, &pool, NULL, &context->pool);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkCreateCommandPool");
    VkCommandBufferAllocateInfo commands = { .sType =
                                                 VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                             .commandPool = context->pool,
                                             .commandBufferCount = 1 };
    result = context->vk.vkAllocateCommandBuffers(context->device, &commands, &context->commands);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkAllocateCommandBuffers");
    VkFenceCreateInfo fence = { .sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO };
    result = context->vk.vkCreateFence(context->device, &fence, NULL, &context->fence);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkCreateFence");
    VkPipelineCacheCreateInfo cache = { .sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO };
    result = context->vk.vkCreatePipelineCache(context->device, &cache, NULL, &context->cache);
    return result == VK_SUCCESS ? STP_OK : gpu_error(env, result, "vkCreatePipelineCache");
}
