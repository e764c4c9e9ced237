/* The features that are asked of a device: one table for our own devices and for hosts. */
#include "gpu/gpu.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"

#define CORE(member) offsetof(struct stp_vulkan_features, core.features.member)
#define V12(member)  offsetof(struct stp_vulkan_features, v12.member)
#define V13(member)  offsetof(struct stp_vulkan_features, v13.member)

/* The order of `features`. */
static const struct stp_vulkan_feature list[] = {
    { "shaderInt64", true, NULL },
    { "bufferDeviceAddress", true, NULL },
    { "scalarBlockLayout", true, NULL },
    { "dynamicRendering", true, NULL },
    { "synchronization2", true, NULL },
    { "maintenance4", true, NULL },
    { "shaderBufferInt64Atomics", false, "exact sums in 32-bit atomics; deferred by rasteriser" },
    { "shaderOutputLayer", false, "the deferred rasteriser takes a pass a group" },
    { "independentBlend", false, "transparency fast and nearest are refused" },
    { "shaderFloat64", false, "centres are projected in float" },
    { "shaderStorageImageExtendedFormats", false, "compute paths only" },
};
#define FEATURES (sizeof list / sizeof *list)

static const struct {
    size_t offset;
    enum stp_feature feature;
} features[FEATURES] = {
    { CORE(shaderInt64), STP_FEATURE_INT64 },
    { V12(bufferDeviceAddress), 0 },
    { V12(scalarBlockLayout), 0 },
    { V13(dynamicRendering), 0 },
    { V13(synchronization2), 0 },
    { V13(maintenance4), 0 },
    { V12(shaderBufferInt64Atomics), STP_FEATURE_INT64_ATOMICS },
    { V12(shaderOutputLayer), STP_FEATURE_VERTEX_LAYER },
    { CORE(independentBlend), STP_FEATURE_INDEPENDENT_BLEND },
    { CORE(shaderFloat64), STP_FEATURE_FLOAT64 },
    { CORE(shaderStorageImageExtendedFormats), STP_FEATURE_STORAGE_FORMATS },
};

static VkBool32 *field(struct stp_vulkan_features *f, unsigned i)
{
    return (VkBool32 *)((char *)f + features[i].offset);
}

void gpu_features_chain(struct stp_vulkan_features *f)
{
    *f = (struct stp_vulkan_features){
        .core = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &f->v12 },
        .v12 = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &f->v13 },
        .v13 = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES },
    };
}

void stp_vulkan_wanted_features(const struct stp_vulkan_features *supported,
                                struct stp_vulkan_features *out)
{
    struct stp_vulkan_features all = { 0 };
    if (supported)
        all = *supported;
    gpu_features_chain(out);
    for (unsigned i = 0; i < FEATURES; i++)
        *field(out, i) = list[i].required || !supported || *field(&all, i);
}

void gpu_features_wanted(unsigned flags, struct stp_vulkan_features *out)
{
    gpu_features_chain(out);
    for (unsigned i = 0; i < FEATURES; i++)
        *field(out, i) = list[i].required || (flags & features[i].feature);
}

const struct stp_vulkan_feature *stp_vulkan_feature_list(unsigned *count)
{
    *count = FEATURES;
    return list;
}

unsigned gpu_features_lacking(struct stp_vulkan_features *f, bool required, char *lacks,
                              size_t size)
{
    unsigned count = 0;
    size_t used = strlen(lacks);
    for (unsigned i = 0; i < FEATURES; i++) {
        if (list[i].required != required || *field(f, i))
            continue;
        int wrote = snprintf(lacks + used, size - used, "%s%s%s", used ? ", " : "", list[i].name,
                             required ? " (required)" : "");
        used = wrote > 0 && used + (size_t)wrote < size ? used + (size_t)wrote : used;
        count++;
    }
    return count;
}

unsigned gpu_features_flags(struct stp_vulkan_features *f)
{
    unsigned flags = 0;
    for (unsigned i = 0; i < FEATURES; i++)
        if (*field(f, i))
            flags |= features[i].feature;
    return flags;
}

/* Structs of single features, as an application may chain instead of the 1.2 and 1.3 ones. */
static void read_single(const VkBaseInStructure *s, struct stp_vulkan_features *f)
{
    const void *at = s;
    switch (s->sType) {
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES:
        f->v12.bufferDeviceAddress |=
            ((const VkPhysicalDeviceBufferDeviceAddressFeatures *)at)->bufferDeviceAddress;
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES:
        f->v12.scalarBlockLayout |=
            ((const VkPhysicalDeviceScalarBlockLayoutFeatures *)at)->scalarBlockLayout;
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_INT64_FEATURES:
        f->v12.shaderBufferInt64Atomics |=
            ((const VkPhysicalDeviceShaderAtomicInt64Features *)at)->shaderBufferInt64Atomics;
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES:
        f->v13.dynamicRendering |=
            ((const VkPhysicalDeviceDynamicRenderingFeatures *)at)->dynamicRendering;
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES:
        f->v13.synchronization2 |=
            ((const VkPhysicalDeviceSynchronization2Features *)at)->synchronization2;
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_FEATURES:
        f->v13.maintenance4 |= ((const VkPhysicalDeviceMaintenance4Features *)at)->maintenance4;
        break;
    default:
        break;
    }
}

static void read_chain(const VkPhysicalDeviceFeatures2 *chain, struct stp_vulkan_features *f)
{
    gpu_features_chain(f);
    f->core.features = chain->features;
    for (const VkBaseInStructure *s = chain->pNext; s; s = s->pNext) {
        if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES)
            f->v12 = *(const VkPhysicalDeviceVulkan12Features *)(const void *)s;
        else if (s->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES)
            f->v13 = *(const VkPhysicalDeviceVulkan13Features *)(const void *)s;
        else
            read_single(s, f);
    }
}

enum stp_result gpu_features_enabled(const struct stp_env *env,
                                     const VkPhysicalDeviceFeatures2 *chain, const char *device,
                                     unsigned *flags)
{
    struct stp_vulkan_features f;
    char lacks[512] = "";
    read_chain(chain, &f);
    if (gpu_features_lacking(&f, true, lacks, sizeof lacks))
        return log_error(env, STP_ERROR_FEATURE, "%s was made without %s", device, lacks);
    *flags = gpu_features_flags(&f);
    return STP_OK;
}
