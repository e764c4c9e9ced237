#define VK_NO_PROTOTYPES
#include "fault.h"

#include "calls.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT    __attribute__((visibility("default")))
#define MOST_LIVE 65536

/* One process, one loader: it is a stand-in, so its state is as global as the real one's. */
static struct {
    pthread_mutex_t mutex;
    unsigned long at;
    unsigned choice, crowd;
    bool sticky, discrete, in_flight;
    struct fault_state seen;
    uint64_t live[MOST_LIVE];
    void *library;
    PFN_vkGetInstanceProcAddr instance_address;
    PFN_vkGetDeviceProcAddr device_address;
    VkInstance instance; /* the latest, and its device: tests have one at a time */
    VkDevice device;
} fault = { .mutex = PTHREAD_MUTEX_INITIALIZER, .seen.injected = "" };

static void misuse(const char *what, const char *name)
{
    if (!fault.seen.misuse[0])
        snprintf(fault.seen.misuse, sizeof fault.seen.misuse, "%s %s", what, name);
}

EXPORT fault_arm_fn fault_arm;
EXPORT fault_discrete_fn fault_discrete;
EXPORT fault_crowd_fn fault_crowd;
EXPORT fault_read_fn fault_read;

void fault_arm(unsigned long n, unsigned choice, bool sticky)
{
    pthread_mutex_lock(&fault.mutex);
    fault.at = n;
    fault.choice = choice;
    fault.sticky = sticky;
    fault.seen.calls = 0;
    fault.seen.injected = "";
    fault.seen.result = VK_SUCCESS;
    pthread_mutex_unlock(&fault.mutex);
}

void fault_discrete(bool discrete)
{
    fault.discrete = discrete;
}

void fault_crowd(unsigned devices)
{
    fault.crowd = devices;
}

struct fault_state fault_read(void)
{
    pthread_mutex_lock(&fault.mutex);
    struct fault_state state = fault.seen;
    pthread_mutex_unlock(&fault.mutex);
    return state;
}

static unsigned long number(const char *name)
{
    const char *text = getenv(name);
    return text ? strtoul(text, NULL, 10) : 0;
}

__attribute__((constructor)) static void start(void)
{
    fault_arm(number("FAULT_AT"), (unsigned)number("FAULT_CHOICE"), number("FAULT_STICKY") != 0);
    fault_discrete(number("FAULT_DISCRETE") != 0);
    fault_crowd((unsigned)number("FAULT_CROWD"));
}

__attribute__((destructor)) static void report(void)
{
    const char *path = getenv("FAULT_REPORT");
    FILE *file = path ? fopen(path, "a") : NULL;
    if (!file)
        return;
    fprintf(file, "calls %lu injected %s %d live %u misuse %s\n", fault.seen.calls,
            fault.seen.injected[0] ? fault.seen.injected : "-", fault.seen.result, fault.seen.live,
            fault.seen.misuse[0] ? fault.seen.misuse : "-");
    fclose(file);
}

/* What every call goes through. */

/* VK_SUCCESS: let it through. */
static VkResult inject(const char *name, const VkResult *results, unsigned count)
{
    VkResult result = VK_SUCCESS;
    pthread_mutex_lock(&fault.mutex);
    bool again = fault.sticky && strcmp(fault.seen.injected, name) == 0;
    if (++fault.seen.calls == fault.at || again) {
        fault.seen.injected = name;
        result = fault.choice == FAULT_LOST ? VK_ERROR_DEVICE_LOST : results[fault.choice % count];
        fault.seen.result = result;
    }
    pthread_mutex_unlock(&fault.mutex);
    return result;
}
#define INJECT(name, ...)                                                                          \
    inject(#name, (const VkResult[]){ __VA_ARGS__ },                                               \
           sizeof(VkResult[]){ __VA_ARGS__ } / sizeof(VkResult))

static void born(uint64_t handle)
{
    pthread_mutex_lock(&fault.mutex);
    if (fault.seen.live == MOST_LIVE)
        misuse("too many live objects", "");
    else
        fault.live[fault.seen.live++] = handle;
    pthread_mutex_unlock(&fault.mutex);
}

static void died(uint64_t handle, const char *name)
{
    if (!handle)
        return;
    pthread_mutex_lock(&fault.mutex);
    unsigned i = 0;
    while (i < fault.seen.live && fault.live[i] != handle)
        i++;
    if (i == fault.seen.live)
        misuse("destroyed, but not alive:", name);
    else
        fault.live[i] = fault.live[--fault.seen.live];
    /* Shader modules are not read by a submission. */
    if (fault.in_flight && strcmp(name, "ShaderModule") != 0)
        misuse("destroyed while a submission may use it:", name);
    pthread_mutex_unlock(&fault.mutex);
}

static PFN_vkVoidFunction real(const char *name)
{
    PFN_vkVoidFunction found = NULL;
    if (fault.device)
        found = fault.device_address(fault.device, name);
    return found ? found : fault.instance_address(fault.instance, name);
}
#define REAL(name) ((PFN_##name)real(#name))

/* Calls that only may fail. */
#define WRAP(name, parameters, arguments, ...)                                                     \
    static VKAPI_ATTR VkResult VKAPI_CALL fault_##name parameters                                  \
    {                                                                                              \
        VkResult result = INJECT(name, __VA_ARGS__);                                               \
        return result == VK_SUCCESS ? REAL(name) arguments : result;                               \
    }
FAULT_PLAIN(WRAP)

#define WRAP_OBJECT(type, ...)                                                                     \
    static VKAPI_ATTR VkResult VKAPI_CALL fault_vkCreate##type(                                    \
        VkDevice device, const Vk##type##CreateInfo *info, const VkAllocationCallbacks *allocator, \
        Vk##type *object)                                                                          \
    {                                                                                              \
        VkResult result = INJECT(vkCreate##type, __VA_ARGS__);                                     \
        if (result == VK_SUCCESS)                                                                  \
            result = REAL(vkCreate##type)(device, info, allocator, object);                        \
        if (result == VK_SUCCESS)                                                                  \
            born((uint64_t)*object);                                                               \
        return result;                                                                             \
    }                                                                                              \
    static VKAPI_ATTR void VKAPI_CALL fault_vkDestroy##type(                                       \
        VkDevice device, Vk##type object, const VkAllocationCallbacks *allocator)                  \
    {                                                                                              \
        died((uint64_t)object, #type);                                                             \
        REAL(vkDestroy##type)(device, object, allocator);                                          \
    }
FAULT_OBJECTS(WRAP_OBJECT)

#define WRAP_PIPELINES(kind)                                                                       \
    static VKAPI_ATTR VkResult VKAPI_CALL fault_vkCreate##kind##Pipelines(                         \
        VkDevice device, VkPipelineCache cache, uint32_t count,                                    \
        const Vk##kind##PipelineCreateInfo *infos, const VkAllocationCallbacks *allocator,         \
        VkPipeline *pipelines)                                                                     \
    {                                                                                              \
        VkResult result = INJECT(vkCreate##kind##Pipelines, HOST, MEMORY);                         \
        for (uint32_t i = 0; i < count; i++)                                                       \
            pipelines[i] = VK_NULL_HANDLE; /* what the specification says of failure */            \
        if (result == VK_SUCCESS)                                                                  \
            result = REAL(vkCreate##kind##Pipelines)(device, cache, count, infos, allocator,       \
                                                     pipelines);                                   \
        for (uint32_t i = 0; i < count; i++)                                                       \
            if (pipelines[i])                                                                      \
                born((uint64_t)pipelines[i]);                                                      \
        return result;                                                                             \
    }
WRAP_PIPELINES(Compute)
WRAP_PIPELINES(Graphics)

static VKAPI_ATTR void VKAPI_CALL fault_vkDestroyPipeline(VkDevice device, VkPipeline pipeline,
                                                          const VkAllocationCallbacks *allocator)
{
    died((uint64_t)pipeline, "Pipeline");
    REAL(vkDestroyPipeline)(device, pipeline, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL fault_vkAllocateMemory(VkDevice device,
                                                             const VkMemoryAllocateInfo *info,
                                                             const VkAllocationCallbacks *allocator,
                                                             VkDeviceMemory *memory)
{
    VkMemoryAllocateInfo changed = *info;
    VkResult result = INJECT(vkAllocateMemory, HOST, MEMORY);
    if (fault.discrete)
        changed.memoryTypeIndex = 0;
    if (result == VK_SUCCESS)
        result = REAL(vkAllocateMemory)(device, &changed, allocator, memory);
    if (result == VK_SUCCESS)
        born((uint64_t)*memory);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL fault_vkFreeMemory(VkDevice device, VkDeviceMemory memory,
                                                     const VkAllocationCallbacks *allocator)
{
    died((uint64_t)memory, "DeviceMemory");
    REAL(vkFreeMemory)(device, memory, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL fault_vkQueueSubmit2(VkQueue queue, uint32_t count,
                                                           const VkSubmitInfo2 *infos,
                                                           VkFence fence)
{
    VkResult result = INJECT(vkQueueSubmit2, HOST, MEMORY, LOST);
    if (fault.in_flight)
        misuse("submitted before the last was waited for:", "vkQueueSubmit2");
    if (result == VK_SUCCESS)
        result = REAL(vkQueueSubmit2)(queue, count, infos, fence);
    fault.in_flight = result == VK_SUCCESS;
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL fault_vkWaitForFences(VkDevice device, uint32_t count,
                                                            const VkFence *fences, VkBool32 all,
                                                            uint64_t timeout)
{
    VkResult result = INJECT(vkWaitForFences, HOST, MEMORY, LOST);
    if (result == VK_SUCCESS)
        result = REAL(vkWaitForFences)(device, count, fences, all, timeout);
    if (result == VK_SUCCESS)
        fault.in_flight = false;
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL fault_vkDeviceWaitIdle(VkDevice device)
{
    VkResult result = INJECT(vkDeviceWaitIdle, HOST, MEMORY, LOST);
    REAL(vkDeviceWaitIdle)(device); /* whatever is said: destroying comes next */
    fault.in_flight = false;
    return result;
}

/* A device whose memory the host does not see. */
static VKAPI_ATTR void VKAPI_CALL fault_vkGetPhysicalDeviceMemoryProperties(
    VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties *properties)
{
    REAL(vkGetPhysicalDeviceMemoryProperties)(device, properties);
    if (!fault.discrete)
        return;
    const VkMemoryPropertyFlags flags[] = {
        VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
    };
    properties->memoryTypeCount = 3;
    for (uint32_t i = 0; i < 3; i++)
        properties->memoryTypes[i] = (VkMemoryType){ flags[i], 0 };
}

#define WRAP_REQUIREMENTS(type)                                                                    \
    static VKAPI_ATTR void VKAPI_CALL fault_vkGet##type##MemoryRequirements(                       \
        VkDevice device, Vk##type object, VkMemoryRequirements *needs)                             \
    {                                                                                              \
        REAL(vkGet##type##MemoryRequirements)(device, object, needs);                              \
        if (fault.discrete)                                                                        \
            needs->memoryTypeBits = 7;                                                             \
    }
WRAP_REQUIREMENTS(Buffer)
WRAP_REQUIREMENTS(Image)

#define WRAP_FORESEEN(type)                                                                        \
    static VKAPI_ATTR void VKAPI_CALL fault_vkGetDevice##type##MemoryRequirements(                 \
        VkDevice device, const VkDevice##type##MemoryRequirements *info,                           \
        VkMemoryRequirements2 *needs)                                                              \
    {                                                                                              \
        REAL(vkGetDevice##type##MemoryRequirements)(device, info, needs);                          \
        if (fault.discrete)                                                                        \
            needs->memoryRequirements.memoryTypeBits = 7;                                          \
    }
WRAP_FORESEEN(Buffer)
WRAP_FORESEEN(Image)

static VKAPI_ATTR VkResult VKAPI_CALL fault_vkCreateInstance(const VkInstanceCreateInfo *info,
                                                             const VkAllocationCallbacks *allocator,
                                                             VkInstance *instance)
{
    VkResult result = INJECT(vkCreateInstance, HOST, MEMORY, INIT);
    if (result == VK_SUCCESS)
        result = REAL(vkCreateInstance)(info, allocator, instance);
    if (result != VK_SUCCESS)
        return result;
    fault.instance = *instance;
    born((uint64_t)*instance);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL fault_vkDestroyInstance(VkInstance instance,
                                                          const VkAllocationCallbacks *allocator)
{
    died((uint64_t)instance, "Instance");
    REAL(vkDestroyInstance)(instance, allocator);
    fault.instance = NULL;
}

static VKAPI_ATTR VkResult VKAPI_CALL fault_vkEnumeratePhysicalDevices(VkInstance instance,
                                                                       uint32_t *count,
                                                                       VkPhysicalDevice *devices)
{
    VkResult result = INJECT(vkEnumeratePhysicalDevices, HOST, MEMORY, INIT);
    uint32_t room = *count, one = 1;
    VkPhysicalDevice first;
    if (result == VK_SUCCESS && !fault.crowd)
        return REAL(vkEnumeratePhysicalDevices)(instance, count, devices);
    if (result == VK_SUCCESS)
        result = REAL(vkEnumeratePhysicalDevices)(instance, &one, &first);
    if (result < VK_SUCCESS)
        return result;
    *count = !devices || room > fault.crowd ? fault.crowd : room;
    for (uint32_t i = 0; devices && i < *count; i++)
        devices[i] = first;
    return *count < fault.crowd ? VK_INCOMPLETE : VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL fault_vkCreateDevice(VkPhysicalDevice physical,
                                                           const VkDeviceCreateInfo *info,
                                                           const VkAllocationCallbacks *allocator,
                                                           VkDevice *device)
{
    VkResult result = INJECT(vkCreateDevice, HOST, MEMORY, LOST, INIT);
    if (result == VK_SUCCESS)
        result = REAL(vkCreateDevice)(physical, info, allocator, device);
    if (result != VK_SUCCESS)
        return result;
    fault.device_address = REAL(vkGetDeviceProcAddr);
    fault.device = *device;
    born((uint64_t)*device);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL fault_vkDestroyDevice(VkDevice device,
                                                        const VkAllocationCallbacks *allocator)
{
    PFN_vkDestroyDevice destroy = REAL(vkDestroyDevice);
    died((uint64_t)device, "Device");
    fault.device = NULL;
    destroy(device, allocator);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fault_vkGetDeviceProcAddr(VkDevice device,
                                                                          const char *name);

static PFN_vkVoidFunction wrapper(const char *name)
{
    /* clang-format off */
#define ENTRY(name, ...) { #name, (PFN_vkVoidFunction)fault_##name },
#define ENTRY_OBJECT(type, ...) ENTRY(vkCreate##type) ENTRY(vkDestroy##type)
    static const struct {
        const char *name;
        PFN_vkVoidFunction address;
    } table[] = {
        FAULT_PLAIN(ENTRY)
        FAULT_OBJECTS(ENTRY_OBJECT)
        ENTRY(vkCreateComputePipelines)
        ENTRY(vkCreateGraphicsPipelines)
        ENTRY(vkDestroyPipeline)
        ENTRY(vkAllocateMemory)
        ENTRY(vkFreeMemory)
        ENTRY(vkQueueSubmit2)
        ENTRY(vkWaitForFences)
        ENTRY(vkDeviceWaitIdle)
        ENTRY(vkGetPhysicalDeviceMemoryProperties)
        ENTRY(vkGetBufferMemoryRequirements)
        ENTRY(vkGetImageMemoryRequirements)
        ENTRY(vkGetDeviceBufferMemoryRequirements)
        ENTRY(vkGetDeviceImageMemoryRequirements)
        ENTRY(vkCreateInstance)
        ENTRY(vkEnumeratePhysicalDevices)
        ENTRY(vkDestroyInstance)
        ENTRY(vkCreateDevice)
        ENTRY(vkDestroyDevice)
        ENTRY(vkGetDeviceProcAddr)
    };
    /* clang-format on */
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(table[i].name, name) == 0)
            return table[i].address;
    return NULL;
}

static bool cannot_fail(const char *name)
{
#define NAME(name) #name,
    static const char *const names[] = { FAULT_VOID(NAME) };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i], name) == 0)
            return true;
    return false;
}

static PFN_vkVoidFunction address_of(const char *name, PFN_vkVoidFunction found)
{
    PFN_vkVoidFunction wrapped = wrapper(name);
    if (!wrapped && !cannot_fail(name))
        misuse("tests/fault/calls.h does not know", name);
    return wrapped && found ? wrapped : found;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL fault_vkGetDeviceProcAddr(VkDevice device,
                                                                          const char *name)
{
    return address_of(name, fault.device_address(device, name));
}

EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance instance,
                                                                      const char *name);
PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char *name)
{
    if (!fault.library)
        fault.library = dlopen(FAULT_REAL_LOADER, RTLD_NOW | RTLD_LOCAL);
    if (!fault.library)
        return NULL;
    fault.instance_address =
        (PFN_vkGetInstanceProcAddr)dlsym(fault.library, "vkGetInstanceProcAddr");
    return address_of(name, fault.instance_address(instance, name));
}
