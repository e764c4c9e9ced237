#include "gpu/gpu.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

static const char validation_layer[] = "VK_LAYER_KHRONOS_validation";

static enum stp_result open_loader(const struct stp_env *env, struct gpu_instance *instance)
{
    instance->library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!instance->library)
        return log_error(env, STP_ERROR_NO_DEVICE,
                         "no Vulkan loader (libvulkan.so.1); install libvulkan1 and "
                         "mesa-vulkan-drivers, or use --method reference");
    PFN_vkGetInstanceProcAddr get =
        (PFN_vkGetInstanceProcAddr)dlsym(instance->library, "vkGetInstanceProcAddr");
    if (!get)
        return log_error(env, STP_ERROR_NO_DEVICE, "libvulkan.so.1 has no vkGetInstanceProcAddr");
    instance->global.vkGetInstanceProcAddr = get;
#define LOAD(name) instance->global.name = (PFN_##name)get(NULL, #name);
    GPU_GLOBAL_FUNCTIONS(LOAD)
#undef LOAD
    uint32_t version = 0;
    VkResult result = VK_SUCCESS;
    if (instance->global.vkEnumerateInstanceVersion && instance->global.vkCreateInstance)
        result = instance->global.vkEnumerateInstanceVersion(&version);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkEnumerateInstanceVersion");
    if (version < VK_API_VERSION_1_3)
        return log_error(env, STP_ERROR_NO_DEVICE, "the Vulkan loader is older than 1.3");
    return STP_OK;
}

static enum stp_result find_validation(const struct stp_env *env,
                                       const struct gpu_instance *instance)
{
    VkLayerProperties layers[64];
    uint32_t count = 64;
    VkResult result = instance->global.vkEnumerateInstanceLayerProperties(&count, layers);
    if (result != VK_SUCCESS && result != VK_INCOMPLETE)
        return gpu_error(env, result, "vkEnumerateInstanceLayerProperties");
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(layers[i].layerName, validation_layer) == 0)
            return STP_OK;
    return log_error(env, STP_ERROR_FEATURE, "%s is not installed; install vulkan-validationlayers",
                     validation_layer);
}

/* user is the context: counts, and passes the first line of the message on. */
static VKAPI_ATTR VkBool32 VKAPI_CALL message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                              VkDebugUtilsMessageTypeFlagsEXT types,
                                              const VkDebugUtilsMessengerCallbackDataEXT *data,
                                              void *user)
{
    struct stp_context *context = user;
    if (!(types & VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT))
        return VK_FALSE;
    if (context) {
        context->messages++;
        log_error(context->env, STP_ERROR_VALIDATION, "validation: %.900s", data->pMessage);
    }
    return VK_FALSE;
}

static enum stp_result create(const struct stp_env *env, bool validate, void *user,
                              struct gpu_instance *instance)
{
    const char *layer = validation_layer;
    const char *extensions[] = { VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                 VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME };
    VkValidationFeatureEnableEXT sync = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkDebugUtilsMessengerCreateInfoEXT messenger = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = message,
        .pUserData = user,
    };
    VkValidationFeaturesEXT features = {
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .pNext = &messenger,
        .enabledValidationFeatureCount = 1,
        .pEnabledValidationFeatures = &sync,
    };
    VkApplicationInfo application = { .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                      .pApplicationName = "stipple",
                                      .pEngineName = "stipple",
                                      .apiVersion = VK_API_VERSION_1_3 };
    VkInstanceCreateInfo info = { .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                  .pNext = validate ? &features : NULL,
                                  .pApplicationInfo = &application,
                                  .enabledLayerCount = validate ? 1 : 0,
                                  .ppEnabledLayerNames = &layer,
                                  .enabledExtensionCount = validate ? 2 : 0,
                                  .ppEnabledExtensionNames = extensions };
    VkResult result = instance->global.vkCreateInstance(&info, NULL, &instance->handle);
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY)
        return gpu_error(env, result, "vkCreateInstance");
    if (result != VK_SUCCESS)
        return log_error(env, STP_ERROR_NO_DEVICE,
                         "no Vulkan driver could be loaded (VkResult %d); install "
                         "mesa-vulkan-drivers, or use --method reference",
                         result);
#define LOAD(name)                                                                                 \
    instance->vk.name = (PFN_##name)instance->global.vkGetInstanceProcAddr(instance->handle, #name);
    GPU_INSTANCE_FUNCTIONS(LOAD)
#undef LOAD
    if (!validate)
        return STP_OK;
    PFN_vkCreateDebugUtilsMessengerEXT make =
        (PFN_vkCreateDebugUtilsMessengerEXT)instance->global.vkGetInstanceProcAddr(
            instance->handle, "vkCreateDebugUtilsMessengerEXT");
    result = make ? make(instance->handle, &messenger, NULL, &instance->messenger)
                  : VK_ERROR_EXTENSION_NOT_PRESENT;
    return result == VK_SUCCESS ? STP_OK : gpu_error(env, result, "vkCreateDebugUtilsMessengerEXT");
}

enum stp_result gpu_instance_create(const struct stp_env *env, bool validate, void *user,
                                    struct gpu_instance *instance)
{
    *instance = (struct gpu_instance){ .validate = validate };
    enum stp_result result = open_loader(env, instance);
    if (result == STP_OK && validate)
        result = find_validation(env, instance);
    if (result == STP_OK)
        result = create(env, validate, user, instance);
    if (result != STP_OK)
        gpu_instance_destroy(instance);
    return result;
}

void gpu_instance_destroy(struct gpu_instance *instance)
{
    if (instance->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy =
            (PFN_vkDestroyDebugUtilsMessengerEXT)instance->global.vkGetInstanceProcAddr(
                instance->handle, "vkDestroyDebugUtilsMessengerEXT");
        destroy(instance->handle, instance->messenger, NULL);
    }
    if (instance->handle)
        instance->vk.vkDestroyInstance(instance->handle, NULL);
    if (instance->library)
        dlclose(instance->library);
    *instance = (struct gpu_instance){ 0 };
}

enum stp_result gpu_instance_devices(const struct stp_env *env, const struct gpu_instance *instance,
                                     VkPhysicalDevice **devices, uint32_t *count)
{
    uint32_t all = 0;
    VkResult result = instance->vk.vkEnumeratePhysicalDevices(instance->handle, &all, NULL);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkEnumeratePhysicalDevices");
    VkPhysicalDevice *found = mem_alloc(all ? all : 1, sizeof(VkPhysicalDevice));
    if (!found)
        return log_no_memory(env, all * sizeof(VkPhysicalDevice), "the list of devices");
    result = instance->vk.vkEnumeratePhysicalDevices(instance->handle, &all, found);
    if (result != VK_SUCCESS &&
        result != VK_INCOMPLETE) { /* incomplete: one was plugged in since */
        mem_free(found);
        return gpu_error(env, result, "vkEnumeratePhysicalDevices");
    }
    *devices = found;
    *count = all;
    return STP_OK;
}

enum stp_result gpu_error(const struct stp_env *env, VkResult result, const char *call)
{
    if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY)
        return log_error(env, STP_ERROR_DEVICE_MEMORY, "%s: out of device memory", call);
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY)
        return log_error(env, STP_ERROR_MEMORY, "%s: out of host memory", call);
    if (result == VK_ERROR_DEVICE_LOST)
        return log_error(env, STP_ERROR_DEVICE, "%s: the device was lost", call);
    return log_error(env, STP_ERROR_DEVICE, "%s failed: VkResult %d", call, result);
}
