/* The finished picture into the images of a host. */
#include "passes/passes.h"

#include <float.h>
#include <math.h>

#include "base/log.h"

static const struct {
    VkFormat format;
    float most; /* the largest finite value */
} colors[] = {
    { VK_FORMAT_R32G32B32A32_SFLOAT, FLT_MAX },
    { VK_FORMAT_R16G16B16A16_SFLOAT, 65504 },
    { VK_FORMAT_B10G11R11_UFLOAT_PACK32, 64512 },
    { VK_FORMAT_R8G8B8A8_UNORM, 1 },
    { VK_FORMAT_R8G8B8A8_SRGB, 1 },
    { VK_FORMAT_B8G8R8A8_UNORM, 1 },
    { VK_FORMAT_B8G8R8A8_SRGB, 1 },
};

static const struct {
    VkFormat format;
    enum plan_host_depth copied; /* as the specification packs the depth aspect into a buffer */
    bool stencil;
} depths[] = {
    { VK_FORMAT_D32_SFLOAT, PLAN_HOST_DEPTH_FLOAT, false },
    { VK_FORMAT_D16_UNORM, PLAN_HOST_DEPTH_16, false },
    { VK_FORMAT_X8_D24_UNORM_PACK32, PLAN_HOST_DEPTH_24, false },
    { VK_FORMAT_D24_UNORM_S8_UINT, PLAN_HOST_DEPTH_24, true },
    { VK_FORMAT_D32_SFLOAT_S8_UINT, PLAN_HOST_DEPTH_FLOAT, true },
};

float pass_host_most(VkFormat format)
{
    for (unsigned i = 0; i < sizeof colors / sizeof *colors; i++)
        if (colors[i].format == format)
            return colors[i].most;
    return 0;
}

VkImageAspectFlags pass_host_aspects(VkFormat format)
{
    for (unsigned i = 0; i < sizeof depths / sizeof *depths; i++)
        if (depths[i].format == format)
            return VK_IMAGE_ASPECT_DEPTH_BIT |
                   (depths[i].stencil ? VK_IMAGE_ASPECT_STENCIL_BIT : 0);
    return 0;
}

enum plan_host_depth pass_host_depth(VkFormat format)
{
    for (unsigned i = 0; i < sizeof depths / sizeof *depths; i++)
        if (depths[i].format == format)
            return depths[i].copied;
    return PLAN_HOST_DEPTH_NONE;
}

enum stp_result pass_host_pipeline(const struct stp_env *env, struct stp_context *context,
                                   const struct stp_plan *plan, const struct pass_host *host,
                                   VkPipelineLayout layout, VkPipeline *pipeline)
{
    bool depth = host->depth_format != VK_FORMAT_UNDEFINED;
    bool tested = !host->replace && !plan->constant[PLAN_HOST_DEPTH];
    struct pass_graphics graphics = {
        .vertex = PLAN_SHADER_HOST_VERTEX,
        .fragment = depth ? PLAN_SHADER_HOST_FRAGMENT_DEPTH : PLAN_SHADER_HOST_FRAGMENT,
        .color_count = 1,
        .color = { host->color_format },
        .depth = host->depth_format,
        .blend = host->replace ? PASS_BLEND_NONE : PASS_BLEND_OVER,
        .depth_write = depth && !host->depth_read_only,
        .compare = !tested                ? VK_COMPARE_OP_ALWAYS
                   : host->depth_reversed ? VK_COMPARE_OP_GREATER
                                          : VK_COMPARE_OP_LESS,
    };
    return pass_graphics_pipeline(env, context, plan, NULL, &graphics, layout, pipeline);
}

/* Hardware depth of eye depth z: add + scale / z in perspective, add + scale * z orthographic. */
static void depth_convention(const struct stp_plan *plan, const struct pass_host *host, double near,
                             double far, struct stp_push_host *push)
{
    double add = 1, scale = -near;
    if (plan->constant[PLAN_ORTHOGRAPHIC]) {
        scale = 1 / (far - near);
        add = -near * scale;
    } else if (far < INFINITY) {
        add = far / (far - near);
        scale = -near * add;
    }
    push->push_add = (float)(host->depth_reversed ? 1 - add : add);
    push->push_scale = (float)(host->depth_reversed ? -scale : scale);
    push->push_none = host->depth_reversed ? 0 : 1;
}

static int64_t most(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t least(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* A part of the picture in the host's image; empty where nothing of it is inside. The picture may
 * lie anywhere: sums of its corner and its size may exceed 32 bits, and no end of an area may
 * exceed 31. */
static VkRect2D inside(uint32_t left, uint32_t top, uint32_t right, uint32_t bottom,
                       const struct stp_targets *targets)
{
    int64_t x = most((int64_t)targets->x + left, 0), y = most((int64_t)targets->y + top, 0);
    int64_t end_x = least((int64_t)targets->x + right, least(targets->width, INT32_MAX));
    int64_t end_y = least((int64_t)targets->y + bottom, least(targets->height, INT32_MAX));
    if (x >= end_x || y >= end_y)
        return (VkRect2D){ 0 };
    return (VkRect2D){ { (int32_t)x, (int32_t)y },
                       { (uint32_t)(end_x - x), (uint32_t)(end_y - y) } };
}

static VkRect2D tile_inside(const struct plan_tile *tile, const struct stp_targets *targets)
{
    return inside(tile->x, tile->y, tile->x + tile->width, tile->y + tile->height, targets);
}

void pass_push_host(struct stp_context *context, VkCommandBuffer commands,
                    const struct stp_plan *plan, const struct plan_tile *tile,
                    const struct pass_resources *resources)
{
    const struct stp_targets *targets = resources->targets;
    VkRect2D area = tile_inside(tile, targets);
    struct stp_push_host push = { .push_corner = { targets->x, targets->y },
                                  .push_low = { area.offset.x, area.offset.y },
                                  .push_high = { area.offset.x + (int32_t)area.extent.width,
                                                 area.offset.y + (int32_t)area.extent.height },
                                  .push_most = pass_host_most(resources->host->color_format),
                                  .push_replace = resources->host->replace };
    depth_convention(plan, resources->host, targets->depth_near, targets->depth_far, &push);
    context->vk.vkCmdPushConstants(commands, resources->layout, PASS_PUSH_STAGES, PASS_PUSH_HOST,
                                   sizeof push, &push);
}

/* Between attachment and copy source; what the copy reads is what was rendered before it. */
static void change_depth(struct stp_context *context, VkCommandBuffer commands,
                         const struct pass_resources *resources, bool to_copy)
{
    const struct stp_host_image *depth = &resources->targets->depth;
    const VkImageLayout own = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    const VkImageLayout copied = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    const VkPipelineStageFlags2 tests =
        VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
    const VkAccessFlags2 tested = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                  VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    const VkPipelineStageFlags2 copy = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
    VkImageMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = to_copy ? tests : copy,
        .srcAccessMask = to_copy ? tested : 0,
        .dstStageMask = to_copy ? copy : tests,
        .dstAccessMask = to_copy ? VK_ACCESS_2_TRANSFER_READ_BIT : tested,
        .oldLayout = to_copy ? own : copied,
        .newLayout = to_copy ? copied : own,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = depth->image,
        .subresourceRange = { pass_host_aspects(resources->host->depth_format), depth->level, 1,
                              depth->layer, 1 }
    };
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .imageMemoryBarrierCount = 1,
                              .pImageMemoryBarriers = &barrier };
    context->vk.vkCmdPipelineBarrier2(commands, &info);
}

void pass_record_copy_depth(struct stp_context *context, VkCommandBuffer commands,
                            const struct stp_plan *plan, const struct plan_pass *,
                            const struct plan_tile *tile, const struct pass_resources *resources)
{
    const struct stp_host_image *depth = &resources->targets->depth;
    const struct gpu_buffer *words = &resources->buffer[plan_find(plan, PLAN_HOST_WORDS)];
    VkRect2D area = tile_inside(tile, resources->targets);
    if (area.extent.width == 0)
        return;
    VkBufferImageCopy part = { .imageSubresource = { VK_IMAGE_ASPECT_DEPTH_BIT, depth->level,
                                                     depth->layer, 1 },
                               .imageOffset = { area.offset.x, area.offset.y, 0 },
                               .imageExtent = { area.extent.width, area.extent.height, 1 } };
    change_depth(context, commands, resources, true);
    context->vk.vkCmdCopyImageToBuffer(commands, depth->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                       words->handle, 1, &part);
    change_depth(context, commands, resources, false);
}

static VkRenderingAttachmentInfo attachment(const struct stp_host_image *image,
                                            VkImageLayout layout)
{
    return (VkRenderingAttachmentInfo){ .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                        .imageView = image->view,
                                        .imageLayout = layout,
                                        .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                        .storeOp = VK_ATTACHMENT_STORE_OP_STORE };
}

void pass_record_host(struct stp_context *context, VkCommandBuffer commands,
                      const struct plan_tile *tile, const struct pass_resources *resources,
                      VkPipeline pipeline)
{
    const struct stp_targets *targets = resources->targets;
    VkRect2D area = inside(tile->keep[0], tile->keep[1], tile->keep[2], tile->keep[3], targets);
    if (area.extent.width == 0)
        return;
    VkRenderingAttachmentInfo color =
        attachment(&targets->color, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    VkRenderingAttachmentInfo depth =
        attachment(&targets->depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    bool has_depth = resources->host->depth_format != VK_FORMAT_UNDEFINED;
    VkRenderingInfo rendering = { .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = area,
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &color,
                                  .pDepthAttachment = has_depth ? &depth : NULL };
    VkViewport viewport = { (float)area.offset.x,
                            (float)area.offset.y,
                            (float)area.extent.width,
                            (float)area.extent.height,
                            0,
                            1 };
    context->vk.vkCmdBeginRendering(commands, &rendering);
    context->vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    context->vk.vkCmdSetViewport(commands, 0, 1, &viewport);
    context->vk.vkCmdSetScissor(commands, 0, 1, &area);
    context->vk.vkCmdDraw(commands, 3, 1, 0, 0);
    context->vk.vkCmdEndRendering(commands);
}
