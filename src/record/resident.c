/* A scene on a device of the host's, uploaded by commands that the host submits. */
#include "record/resident.h"

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

enum stp_result resident_check_method(const struct stp_env *env, const struct stp_plan *plan)
{
    if (plan->method == STP_METHOD_REFERENCE)
        return log_error(env, STP_ERROR_ARGUMENT, "method reference draws on no device");
    if (plan->method == STP_METHOD_PYRAMID)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method pyramid is not drawn into a host's frame; use exact or deferred");
    if (plan->method == STP_METHOD_AXIS)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method axis is not drawn into a host's frame: its lists are of one view");
    if (plan_covers(plan) || plan->transparency == STP_TRANSPARENCY_PEEL)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency %s is not drawn into a host's frame; use exact",
                         stp_transparency_name(plan->transparency));
    return STP_OK;
}

static enum stp_result check(const struct stp_env *env, const struct stp_context *context,
                             const struct stp_scene *scene, const struct stp_plan *plan,
                             const struct stp_resident_params *params)
{
    if (!context->imported)
        return log_error(env, STP_ERROR_ARGUMENT, "residents need an imported context");
    enum stp_result result = resident_check_method(env, plan);
    if (result != STP_OK)
        return result;
    result = plan_check_scene(env, plan, scene);
    if (result != STP_OK)
        return result;
    if (params->splats && params->splats_offset % 16)
        return log_error(env, STP_ERROR_ARGUMENT, "splats_offset %llu is no multiple of 16",
                         (unsigned long long)params->splats_offset);
    return STP_OK;
}

/* The host's own splats: only their address is ours. */
static void borrow(struct stp_resident *resident, const struct stp_resident_params *params)
{
    struct stp_context *c = resident->context;
    VkBufferDeviceAddressInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                       .buffer = params->splats };
    struct gpu_buffer *splats = &resident->buffer[PLAN_SPLATS];
    splats->address = c->vk.vkGetBufferDeviceAddress(c->device, &info) + params->splats_offset;
    resident->borrowed = params->splats;
}

static bool is_ours(const struct stp_resident *resident, const struct plan_resource *r)
{
    return r->lifetime == PLAN_SCENE && !(r->slot == PLAN_SPLATS && resident->borrowed);
}

/* One block, unless no allocation may be so large. */
static enum stp_result make_block(const struct stp_env *env, const struct stp_plan *plan,
                                  struct stp_resident *resident)
{
    VkMemoryRequirements sum = { .alignment = 1, .memoryTypeBits = UINT32_MAX };
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        if (!is_ours(resident, &plan->resource[i]))
            continue;
        VkMemoryRequirements needs = gpu_buffer_needs(resident->context, plan->resource[i].bytes);
        gpu_needs_add(resident->context, &needs, &sum);
    }
    if (sum.size > resident->context->limits.max_allocation)
        return STP_OK;
    return gpu_block_create(env, resident->context, &sum, GPU_DEVICE, "the scene",
                            &resident->block);
}

static enum stp_result make_buffer(const struct stp_env *env, const struct plan_resource *r,
                                   struct stp_resident *resident)
{
    struct stp_context *c = resident->context;
    struct gpu_buffer *buffer = &resident->buffer[r->slot];
    return resident->block.part.where.memory
               ? gpu_buffer_place(env, c, r->bytes, &resident->block, r->name, buffer)
               : gpu_buffer_create(env, c, r->bytes, GPU_DEVICE, r->name, buffer);
}

/* A frame of nothing but the scene's resources is what record_upload fills. */
static enum stp_result upload(const struct stp_env *env, const struct stp_scene *scene,
                              const struct stp_plan *plan, struct stp_resident *resident)
{
    struct record_frame holder = { .plan = plan, .context = resident->context };
    enum stp_result result = make_block(env, plan, resident);
    for (uint32_t i = 0; result == STP_OK && i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        if (r->lifetime == PLAN_SCENE) {
            resident->has[r->slot] = true;
            resident->bytes[r->slot] = r->bytes;
        }
        if (!is_ours(resident, r))
            continue;
        result = make_buffer(env, r, resident);
        holder.resources.buffer[i] = resident->buffer[r->slot];
    }
    return result == STP_OK ? record_upload(env, &holder, scene) : result;
}

static void take_pending(struct stp_resident *resident)
{
    struct stp_context *c = resident->context;
    resident->copies = c->pending_count;
    resident->staged = true;
    for (uint32_t i = 0; i < c->pending_count; i++)
        resident->pending[i] = c->pending[i];
    c->pending_count = 0;
}

enum stp_result stp_resident_create(const struct stp_env *env, struct stp_context *context,
                                    const struct stp_scene *scene, const struct stp_plan *plan,
                                    const struct stp_resident_params *params,
                                    struct stp_resident **resident)
{
    const struct stp_resident_params none = { 0 };
    if (!params)
        params = &none;
    enum stp_result result = check(env, context, scene, plan, params);
    if (result != STP_OK)
        return result;
    struct stp_resident *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return log_no_memory(env, sizeof *made, "the resident scene");
    made->context = context;
    made->splats = scene->splats.count;
    made->version = scene->version;
    made->material = plan_material(plan, &scene->objects[0]);
    if (params->splats)
        borrow(made, params);
    result = upload(env, scene, plan, made);
    take_pending(made);
    if (result != STP_OK)
        stp_resident_destroy(&made);
    else
        *resident = made;
    return result;
}

/* To whatever comes later: the host's own shaders may read the splats, too. */
static void make_visible(struct stp_resident *resident, VkCommandBuffer commands)
{
    VkMemoryBarrier2 memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
        .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_HOST_WRITE_BIT,
        .dstStageMask = RECORD_HOST_STAGES,
        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT
    };
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .memoryBarrierCount = 1,
                              .pMemoryBarriers = &memory };
    resident->context->vk.vkCmdPipelineBarrier2(commands, &info);
}

/* One half of handing the copied buffers from one queue family to another. The acquire's first
 * scope is all commands, so that it chains with whatever stage the host's semaphore waits at. */
static void hand_over(struct stp_resident *resident, VkCommandBuffer commands, uint32_t from,
                      bool release)
{
    VkBufferMemoryBarrier2 barriers[GPU_MOST_PENDING];
    for (uint32_t i = 0; i < resident->copies; i++)
        barriers[i] =
            (VkBufferMemoryBarrier2){ .sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2,
                                      .srcStageMask = release
                                                          ? VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT
                                                          : VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                      .srcAccessMask = release ? VK_ACCESS_2_TRANSFER_WRITE_BIT : 0,
                                      .dstStageMask = release ? 0 : RECORD_HOST_STAGES,
                                      .dstAccessMask = release ? 0 : VK_ACCESS_2_MEMORY_READ_BIT,
                                      .srcQueueFamilyIndex = from,
                                      .dstQueueFamilyIndex = resident->context->family,
                                      .buffer = resident->pending[i].target,
                                      .size = VK_WHOLE_SIZE };
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .bufferMemoryBarrierCount = resident->copies,
                              .pBufferMemoryBarriers = barriers };
    if (resident->copies)
        resident->context->vk.vkCmdPipelineBarrier2(commands, &info);
}

enum stp_result stp_resident_record_upload(const struct stp_env *env, struct stp_resident *resident,
                                           VkCommandBuffer commands, uint32_t from)
{
    if (resident->recorded)
        return log_error(env, STP_ERROR_ARGUMENT, "the upload was recorded before");
    if (!resident->staged)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "there is nothing left to upload: the staging memory was released before");
    for (uint32_t i = 0; i < resident->copies; i++) {
        const struct gpu_pending *p = &resident->pending[i];
        resident->context->vk.vkCmdCopyBuffer(commands, p->staging.handle, p->target, 1,
                                              &p->region);
    }
    if (from == resident->context->family)
        make_visible(resident, commands);
    else
        hand_over(resident, commands, from, true);
    resident->recorded = true;
    return STP_OK;
}

void stp_resident_record_acquire(struct stp_resident *resident, VkCommandBuffer commands,
                                 uint32_t from)
{
    if (from != resident->context->family)
        hand_over(resident, commands, from, false);
}

void stp_resident_release_staging(struct stp_resident *resident)
{
    for (uint32_t i = 0; resident->staged && i < resident->copies; i++)
        gpu_buffer_destroy(resident->context, &resident->pending[i].staging);
    resident->staged = false;
}

VkBuffer stp_resident_splats(const struct stp_resident *resident, VkDeviceSize *bytes)
{
    if (bytes)
        *bytes = resident->splats * 32;
    return resident->borrowed ? resident->borrowed : resident->buffer[PLAN_SPLATS].handle;
}

void stp_resident_destroy(struct stp_resident **resident)
{
    if (!resident || !*resident)
        return;
    struct stp_resident *r = *resident;
    stp_resident_release_staging(r);
    for (uint32_t i = 0; i < PLAN_BUFFER_SLOTS; i++)
        gpu_buffer_destroy(r->context, &r->buffer[i]);
    gpu_block_destroy(r->context, &r->block);
    mem_free(r);
    *resident = NULL;
}
