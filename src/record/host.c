/* Frames in a command buffer of the host's. */
#include "record/resident.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/camera.h"

struct stp_frame {
    struct stp_context *context;
    struct stp_plan *plan; /* a copy; moved with the camera */
    struct record_frame record;
    struct pass_host host;
    uint32_t width, height; /* the most */
};

/* What no camera of a plan may break: its keys hold the depth of the whole scene. */
static enum stp_result check_keys(const struct stp_env *env, const struct stp_plan *plan)
{
    uint32_t bits = plan_least_depth_bits(plan);
    bool slabs = plan->voronoi == STP_VORONOI_SLAB;
    if (plan->constant[PLAN_PACKED] ? bits >= 8 : !slabs || bits >= 6)
        return STP_OK;
    return log_error(env, STP_ERROR_ARGUMENT,
                     "the scene is too deep for its epsilon: some views would not fit the keys; "
                     "make the plan with %s",
                     plan->constant[PLAN_PACKED] ? "STP_PAYLOAD_ID"
                                                 : "STP_VORONOI_OFF, or method exact or two-pass");
}

static enum stp_result check(const struct stp_env *env, const struct stp_context *context,
                             const struct stp_plan *plan,
                             const struct stp_host_frame_params *params)
{
    if (!context->imported)
        return log_error(env, STP_ERROR_ARGUMENT, "frames need an imported context");
    if (plan->share.count)
        return log_error(env, STP_ERROR_ARGUMENT, "a shared scene is for stp_render_share only");
    enum stp_result result = resident_check_method(env, plan);
    if (result != STP_OK)
        return result;
    if (!params)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "a frame needs params: the formats of its targets");
    if (pass_host_most(params->color_format) == 0)
        return log_error(env, STP_ERROR_ARGUMENT, "VkFormat %d is no color format of a target",
                         params->color_format);
    if (params->depth_format != VK_FORMAT_UNDEFINED && !pass_host_aspects(params->depth_format))
        return log_error(env, STP_ERROR_ARGUMENT, "VkFormat %d is no depth format of a target",
                         params->depth_format);
    result = record_check_features(env, context, plan);
    return result == STP_OK ? check_keys(env, plan) : result;
}

/* The frame's plan: a copy, which tests the host's depth where there are layers behind layers. */
static enum stp_result own_plan(const struct stp_env *env, const struct stp_plan *plan,
                                const struct stp_host_frame_params *params, struct stp_plan **own)
{
    struct stp_plan *made = NULL;
    enum stp_result result = plan_copy(env, plan, &made);
    if (result == STP_OK && params->composite == STP_COMPOSITE_OVER)
        result = plan_behind_host(env, made, pass_host_depth(params->depth_format));
    if (result != STP_OK) {
        stp_plan_destroy(&made);
        return result;
    }
    made->constant[PLAN_CUTS] = 1; /* a camera to come may be anywhere */
    *own = made;
    return STP_OK;
}

static enum stp_result fill(const struct stp_env *env, const struct stp_plan *plan,
                            const struct stp_host_frame_params *params, struct stp_frame *frame)
{
    frame->host = (struct pass_host){ .color_format = params->color_format,
                                      .depth_format = params->depth_format,
                                      .depth_reversed = params->depth_reversed,
                                      .depth_read_only = params->depth_read_only,
                                      .replace = params->composite == STP_COMPOSITE_REPLACE };
    frame->width = plan->camera.width;
    frame->height = plan->camera.height;
    struct record_host host = { .pass = frame->host, .scratch = params->scratch };
    enum stp_result result = own_plan(env, plan, params, &frame->plan);
    return result == STP_OK
               ? record_frame_create_hosted(env, frame->context, frame->plan, &host, &frame->record)
               : result;
}

enum stp_result stp_frame_scratch(const struct stp_env *env, struct stp_context *context,
                                  const struct stp_plan *plan,
                                  const struct stp_host_frame_params *params,
                                  VkMemoryRequirements *requirements)
{
    struct stp_plan *own = NULL;
    enum stp_result result = check(env, context, plan, params);
    if (result == STP_OK)
        result = own_plan(env, plan, params, &own);
    if (result == STP_OK) {
        *requirements = record_resources_need(context, own, RECORD_WITHOUT_SCENE);
        if (requirements->size > context->limits.max_allocation)
            requirements->memoryTypeBits = 0;
    }
    stp_plan_destroy(&own);
    return result;
}

enum stp_result stp_frame_create(const struct stp_env *env, struct stp_context *context,
                                 const struct stp_plan *plan,
                                 const struct stp_host_frame_params *params,
                                 struct stp_frame **frame)
{
    enum stp_result result = check(env, context, plan, params);
    if (result != STP_OK)
        return result;
    struct stp_frame *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return log_no_memory(env, sizeof *made, "a frame");
    made->context = context;
    result = fill(env, plan, params, made);
    if (result != STP_OK)
        stp_frame_destroy(&made);
    else
        *frame = made;
    return result;
}

void stp_frame_destroy(struct stp_frame **frame)
{
    if (!frame || !*frame)
        return;
    record_frame_destroy(&(*frame)->record);
    stp_plan_destroy(&(*frame)->plan);
    mem_free(*frame);
    *frame = NULL;
}

/* Every buffer of the scene that the frame's passes read must be there, and hold this scene. */
static enum stp_result check_resident(const struct stp_env *env, const struct stp_plan *plan,
                                      const struct stp_resident *resident)
{
    if (memcmp(&resident->material, &plan->frame.material, sizeof resident->material) != 0)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the frame's plan has another material or epsilon than the resident; make "
                         "it with the resident's scene and epsilon");
    const char *what = plan_differs(plan, &resident->version);
    if (what)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the frame's plan was made of another %s than the resident", what);
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        if (r->lifetime != PLAN_SCENE)
            continue;
        if (!resident->has[r->slot] || resident->bytes[r->slot] < r->bytes)
            return log_error(env, STP_ERROR_ARGUMENT,
                             "the frame reads the buffer \"%s\", which the resident's plan had "
                             "not: make the resident with the frame's plan",
                             r->name);
    }
    if (!resident->recorded)
        return log_error(env, STP_ERROR_ARGUMENT, "the scene's upload has not been recorded");
    return STP_OK;
}

static enum stp_result check_record(const struct stp_env *env, const struct stp_frame *frame,
                                    const struct stp_resident *resident,
                                    const struct stp_camera *camera,
                                    const struct stp_targets *targets)
{
    const struct stp_plan *plan = frame->plan;
    enum stp_result result = check_resident(env, plan, resident);
    if (result != STP_OK)
        return result;
    if (camera->width == 0 || camera->height == 0 || camera->width > frame->width ||
        camera->height > frame->height)
        return log_error(env, STP_ERROR_ARGUMENT, "%u x %u: the frame is for at most %u x %u",
                         camera->width, camera->height, frame->width, frame->height);
    if (camera->orthographic != (plan->constant[PLAN_ORTHOGRAPHIC] != 0))
        return log_error(env, STP_ERROR_ARGUMENT, "the frame's plan is for the other projection");
    result = camera_check(env, camera);
    if (result != STP_OK)
        return result;
    if (!targets->color.view || !targets->color.image)
        return log_error(env, STP_ERROR_ARGUMENT, "there is no color target");
    if (frame->host.depth_format == VK_FORMAT_UNDEFINED)
        return STP_OK;
    if (!targets->depth.view || !targets->depth.image)
        return log_error(env, STP_ERROR_ARGUMENT, "there is no depth target");
    if (!(targets->depth_near < targets->depth_far) ||
        (camera->orthographic ? !isfinite(targets->depth_far) : !(targets->depth_near > 0)))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the target's depth needs 0 < near < far, and a finite far when "
                         "orthographic");
    return STP_OK;
}

/* What may touch an image in a layout: the host's side of a barrier, as far as it can be known. */
static VkAccessFlags2 access_in(VkImageLayout layout)
{
    switch (layout) {
    case VK_IMAGE_LAYOUT_UNDEFINED:
    case VK_IMAGE_LAYOUT_PRESENT_SRC_KHR:
        return 0;
    case VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL:
        return VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    case VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL:
        return VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
               VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    case VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL:
        return VK_ACCESS_2_SHADER_READ_BIT;
    case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
        return VK_ACCESS_2_TRANSFER_READ_BIT;
    case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
        return VK_ACCESS_2_TRANSFER_WRITE_BIT;
    default:
        return VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    }
}

static VkImageMemoryBarrier2 change(const struct stp_host_image *image, VkImageAspectFlags aspects,
                                    VkImageLayout from, VkImageLayout to)
{
    return (
        VkImageMemoryBarrier2){ .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                .srcStageMask = RECORD_HOST_STAGES,
                                .srcAccessMask = access_in(from),
                                .dstStageMask = RECORD_HOST_STAGES,
                                .dstAccessMask = access_in(to),
                                .oldLayout = from,
                                .newLayout = to,
                                .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                .image = image->image,
                                .subresourceRange = { aspects, image->level, 1, image->layer, 1 } };
}

/* What the host did before and does after may be in any stage, also in those that stipple has not.
 */
static void barriers(const struct stp_frame *frame, const struct stp_targets *targets,
                     VkCommandBuffer commands, bool enter)
{
    const VkImageLayout color = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const VkImageLayout depth = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    VkImageAspectFlags aspects = pass_host_aspects(frame->host.depth_format);
    VkImageMemoryBarrier2 images[2] = {
        change(&targets->color, VK_IMAGE_ASPECT_COLOR_BIT, enter ? targets->color.before : color,
               enter ? color : targets->color.after),
    };
    if (aspects)
        images[1] = change(&targets->depth, aspects, enter ? targets->depth.before : depth,
                           enter ? depth : targets->depth.after);
    VkMemoryBarrier2 memory = record_everything();
    memory.srcStageMask = memory.dstStageMask = RECORD_HOST_STAGES;
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .memoryBarrierCount = 1,
                              .pMemoryBarriers = &memory,
                              .imageMemoryBarrierCount = aspects ? 2 : 1,
                              .pImageMemoryBarriers = images };
    frame->context->vk.vkCmdPipelineBarrier2(commands, &info);
}

/* The scene's buffers and the targets are the frame's only while it records. */
static void lend(struct stp_frame *frame, const struct stp_resident *resident,
                 const struct stp_targets *targets)
{
    frame->record.resources.host = &frame->host;
    frame->record.resources.targets = targets;
    for (uint32_t i = 0; i < frame->plan->resource_count; i++) {
        const struct plan_resource *r = &frame->plan->resource[i];
        if (r->lifetime == PLAN_SCENE)
            frame->record.resources.buffer[i] =
                resident ? resident->buffer[r->slot] : (struct gpu_buffer){ 0 };
    }
}

/* One tile: its passes, then the part that is kept into the targets. */
static void record_tile(struct stp_frame *frame, const struct plan_tile *tile,
                        VkCommandBuffer commands)
{
    const struct record_frame *r = &frame->record;
    uint32_t parts = record_parts(frame->plan);
    VkMemoryBarrier2 memory = { .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |
                                                VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                .srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
                                                 VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                .dstStageMask = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                                .dstAccessMask = VK_ACCESS_2_SHADER_STORAGE_READ_BIT };
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .memoryBarrierCount = 1,
                              .pMemoryBarriers = &memory };
    pass_push_host(frame->context, commands, frame->plan, tile, &r->resources);
    for (uint32_t part = 0; part < parts; part++)
        record_walk(&frame->record, commands, tile, part, false, RECORD_NO_PASS);
    frame->context->vk.vkCmdPipelineBarrier2(commands, &info);
    pass_record_host(frame->context, commands, tile, &r->resources, r->pipelines->host);
}

enum stp_result stp_frame_record(const struct stp_env *env, struct stp_frame *frame,
                                 const struct stp_resident *resident,
                                 const struct stp_camera *camera, const struct stp_targets *targets,
                                 VkCommandBuffer commands)
{
    enum stp_result result = check_record(env, frame, resident, camera, targets);
    if (result != STP_OK)
        return result;
    struct stp_plan *plan = frame->plan;
    plan_move(plan, camera);
    lend(frame, resident, targets);
    barriers(frame, targets, commands, true);
    for (uint32_t i = 0; i < plan->tile_count; i++)
        record_tile(frame, &plan->tile[i], commands);
    barriers(frame, targets, commands, false);
    lend(frame, NULL, NULL);
    return STP_OK;
}
