#include "gpu/memory.h"

#include "base/log.h"

/* The first type that has what is wanted, by falling wishes. */
static uint32_t memory_type(const struct stp_context *context, uint32_t allowed,
                            enum gpu_memory kind)
{
    const VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
    const VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    const VkMemoryPropertyFlags coherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    const VkMemoryPropertyFlags wishes[3][3] = {
        [GPU_DEVICE] = { local, 0, 0 },
        [GPU_UPLOAD] = { visible | coherent, visible | coherent, visible },
        [GPU_READ_BACK] = { visible | cached | coherent, visible | cached, visible },
    };
    for (int wish = 0; wish < 3; wish++)
        for (uint32_t i = 0; i < context->memory.memoryTypeCount; i++)
            if ((allowed >> i & 1) && (context->memory.memoryTypes[i].propertyFlags &
                                       wishes[kind][wish]) == wishes[kind][wish])
                return i;
    return 0;
}

/* Memory on a device that is the host: a copy would only cost. */
static bool is_shared(const struct stp_context *context, VkMemoryPropertyFlags flags)
{
    const VkMemoryPropertyFlags shared = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                         VK_MEMORY_PROPERTY_HOST_CACHED_BIT |
                                         VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    return (context->limits.features & STP_FEATURE_SHARED_MEMORY) && (flags & shared) == shared;
}

static VkResult allocate_own(struct stp_context *context, const VkMemoryRequirements *needs,
                             uint32_t type, bool map, struct gpu_memory_part *part)
{
    VkMemoryAllocateFlagsInfo with_address = { .sType =
                                                   VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                               .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT };
    VkMemoryAllocateInfo info = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .pNext = &with_address,
                                  .allocationSize = needs->size,
                                  .memoryTypeIndex = type };
    VkResult result =
        context->vk.vkAllocateMemory(context->device, &info, NULL, &part->where.memory);
    if (result != VK_SUCCESS || !map)
        return result;
    return context->vk.vkMapMemory(context->device, part->where.memory, 0, VK_WHOLE_SIZE, 0,
                                   &part->where.mapped);
}

void memory_release(struct stp_context *context, struct gpu_memory_part *part)
{
    if (part->ours && context->allocator.release)
        context->allocator.release(context->allocator.user, &part->where);
    else if (part->ours && part->where.memory)
        context->vk.vkFreeMemory(context->device, part->where.memory, NULL);
    context->allocated -= part->ours ? part->bytes : 0;
    *part = (struct gpu_memory_part){ 0 };
}

/* Hosts count allocations, and best practice asks for few and large ones. */
#define LEAST_OF_A_HOST ((VkDeviceSize)1 << 20)

enum stp_result memory_allocate(const struct stp_env *env, struct stp_context *context,
                                const VkMemoryRequirements *needs, enum gpu_memory kind,
                                const char *what, struct gpu_memory_part *part)
{
    uint32_t type = memory_type(context, needs->memoryTypeBits, kind);
    VkMemoryPropertyFlags flags = context->memory.memoryTypes[type].propertyFlags;
    bool map = kind != GPU_DEVICE || is_shared(context, flags);
    struct gpu_memory_part made = { .ours = true };
    VkMemoryRequirements padded = *needs;
    if (context->imported && padded.size < LEAST_OF_A_HOST)
        padded.size = LEAST_OF_A_HOST;
    const struct stp_device_allocator *host = &context->allocator;
    VkResult result = host->allocate ? host->allocate(host->user, &padded, type, &made.where)
                                     : allocate_own(context, &padded, type, map, &made);
    bool given = result == VK_SUCCESS || !host->allocate; /* a host that fails has given nothing */
    if (result == VK_SUCCESS && kind != GPU_DEVICE && !made.where.mapped)
        result = VK_ERROR_MEMORY_MAP_FAILED;
    if (result != VK_SUCCESS) {
        const char *call = host->allocate      ? "the host's allocator"
                           : made.where.memory ? "vkMapMemory"
                                               : "vkAllocateMemory";
        if (given)
            memory_release(context, &made);
        if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY)
            return gpu_error(env, result, call);
        return log_error(env, STP_ERROR_DEVICE_MEMORY,
                         "%s has no %llu bytes left for %s (%llu are in use); a smaller --size or "
                         "--tile-memory may fit",
                         context->limits.device, (unsigned long long)padded.size, what,
                         (unsigned long long)context->allocated);
    }
    made.bytes = padded.size;
    made.coherent = (flags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) != 0;
    if (!map)
        made.where.mapped = NULL;
    context->allocated += padded.size;
    if (context->allocated > context->peak)
        context->peak = context->allocated;
    *part = made;
    return STP_OK;
}

/* What a resource is aligned to in a block: every kind at the granularity, so that none shares a
 * page with another kind. */
static VkDeviceSize alignment(const struct stp_context *context, const VkMemoryRequirements *needs)
{
    return needs->alignment > context->granularity ? needs->alignment : context->granularity;
}

struct gpu_memory_part memory_take(const struct stp_context *context, struct gpu_block *block,
                                   const VkMemoryRequirements *needs)
{
    VkDeviceSize align = alignment(context, needs);
    VkDeviceSize at = (block->used + align - 1) / align * align;
    block->used = at + needs->size;
    struct gpu_memory_part part = block->part;
    part.ours = false;
    part.bytes = needs->size;
    part.where.offset += at;
    if (part.where.mapped)
        part.where.mapped = (char *)part.where.mapped + at;
    return part;
}

void gpu_needs_add(const struct stp_context *context, const VkMemoryRequirements *needs,
                   VkMemoryRequirements *sum)
{
    VkDeviceSize align = alignment(context, needs);
    sum->size = (sum->size + align - 1) / align * align + needs->size;
    sum->alignment = align > sum->alignment ? align : sum->alignment;
    sum->memoryTypeBits &= needs->memoryTypeBits;
}

enum stp_result gpu_block_create(const struct stp_env *env, struct stp_context *context,
                                 const VkMemoryRequirements *needs, enum gpu_memory kind,
                                 const char *what, struct gpu_block *block)
{
    *block = (struct gpu_block){ 0 };
    return memory_allocate(env, context, needs, kind, what, &block->part);
}

void gpu_block_destroy(struct stp_context *context, struct gpu_block *block)
{
    memory_release(context, &block->part);
    *block = (struct gpu_block){ 0 };
}
