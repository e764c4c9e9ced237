#include "gpu/gpu.h"

#include <stdio.h>
#include <string.h>

#include "base/log.h"

struct features {
    VkPhysicalDeviceFeatures2 core;
    VkPhysicalDeviceVulkan12Features v12;
    VkPhysicalDeviceVulkan13Features v13;
};

static void chain(struct features *f)
{
    f->core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    f->v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    f->v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    f->core.pNext = &f->v12;
    f->v12.pNext = &f->v13;
}

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
    struct features f = { 0 };
    chain(&f);
    instance->vk.vkGetPhysicalDeviceFeatures2(device, &f.core);
    lack(info, f.v12.bufferDeviceAddress, true, "bufferDeviceAddress");
    lack(info, f.v12.scalarBlockLayout, true, "scalarBlockLayout");
    lack(info, f.v13.dynamicRendering, true, "dynamicRendering");
    lack(info, f.v13.synchronization2, true, "synchronization2");
    lack(info, f.v13.maintenance4, true, "maintenance4");
    lack(info, f.core.features.shaderInt64, true, "shaderInt64");
    bool atomics = f.v12.shaderBufferInt64Atomics, layer = f.v12.shaderOutputLayer;
    /* Ids beside colours that are blended: no device of this age lacks it. */
    bool blend = blends_float32(instance, device) && f.core.features.independentBlend;
    bool formats = f.core.features.shaderStorageImageExtendedFormats;
    lack(info, atomics, false, "shaderBufferInt64Atomics");
    lack(info, layer, false, "shaderOutputLayer");
    lack(info, blend, false, "blending into float32");
    lack(info, f.core.features.shaderFloat64, false, "shaderFloat64");
    lack(info, formats, false, "shaderStorageImageExtendedFormats");
    info->limits.features = (atomics ? STP_FEATURE_INT64_ATOMICS : 0) |
                            (layer ? STP_FEATURE_VERTEX_LAYER : 0) |
                            (blend ? STP_FEATURE_FLOAT32_BLEND : 0) |
                            (f.core.features.shaderInt64 ? STP_FEATURE_INT64 : 0) |
                            (f.core.features.shaderFloat64 ? STP_FEATURE_FLOAT64 : 0) |
                            (formats ? STP_FEATURE_STORAGE_FORMATS : 0);
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
}

bool gpu_device_survey(const struct gpu_instance *instance, VkPhysicalDevice device,
                       struct stp_device_info *info)
{
    VkPhysicalDeviceVulkan11Properties v11 = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES
    };
    VkPhysicalDeviceVulkan12Properties v12 = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES, .pNext = &v11
    };
    VkPhysicalDeviceProperties2 p = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                      .pNext = &v12 };
    instance->vk.vkGetPhysicalDeviceProperties2(device, &p);
    *info = (struct stp_device_info){ .usable = true };
    struct stp_limits *l = &info->limits;
    uint32_t v = p.properties.apiVersion;
    snprintf(info->api_version, sizeof info->api_version, "%u.%u.%u", VK_API_VERSION_MAJOR(v),
             VK_API_VERSION_MINOR(v), VK_API_VERSION_PATCH(v));
    snprintf(l->device, sizeof l->device, "%s", p.properties.deviceName);
    lack(info, v >= VK_API_VERSION_1_3, true, "Vulkan 1.3");
    if (!info->usable)
        return false;
    snprintf(l->driver, sizeof l->driver, "%.120s %.120s", v12.driverName, v12.driverInfo);
    l->max_allocation = v11.maxMemoryAllocationSize;
    l->max_image_size = p.properties.limits.maxImageDimension2D;
    l->max_image_layers = p.properties.limits.maxImageArrayLayers;
    l->max_workgroups = p.properties.limits.maxComputeWorkGroupCount[0];
    l->processor = p.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU ? 1 : 2;
    survey_features(instance, device, info);
    survey_memory(instance, device, l);
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
        if (families[i].timestampValidBits)
            context->timestamp_ms = p.properties.limits.timestampPeriod * 1e-6;
        return STP_OK;
    }
    return log_error(env, STP_ERROR_FEATURE, "%s has no queue for graphics and compute",
                     context->limits.device);
}

static VkResult create_device(struct stp_context *context)
{
    unsigned optional = context->limits.features;
    struct features f = { 0 };
    chain(&f);
    f.core.features.shaderInt64 = VK_TRUE;
    f.core.features.shaderStorageImageExtendedFormats =
        (optional & STP_FEATURE_STORAGE_FORMATS) != 0;
    f.core.features.shaderFloat64 = (optional & STP_FEATURE_FLOAT64) != 0;
    f.core.features.independentBlend = (optional & STP_FEATURE_FLOAT32_BLEND) != 0;
    f.v12.bufferDeviceAddress = f.v12.scalarBlockLayout = VK_TRUE;
    f.v12.shaderBufferInt64Atomics = (optional & STP_FEATURE_INT64_ATOMICS) != 0;
    f.v12.shaderOutputLayer = (optional & STP_FEATURE_VERTEX_LAYER) != 0;
    f.v13.dynamicRendering = f.v13.synchronization2 = f.v13.maintenance4 = VK_TRUE;
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
    if (result != VK_SUCCESS)
        return result;
#define LOAD(name)                                                                                 \
    context->vk.name = (PFN_##name)context->instance.vk.vkGetDeviceProcAddr(context->device, #name);
    GPU_DEVICE_FUNCTIONS(LOAD)
#undef LOAD
    return VK_SUCCESS;
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
    context->instance.vk.vkGetPhysicalDeviceMemoryProperties(context->physical, &context->memory);
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
