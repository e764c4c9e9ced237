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
    VkImageAspectFlags aspects;
} depths[] = {
    { VK_FORMAT_D32_SFLOAT, VK_IMAGE_ASPECT_DEPTH_BIT },
    { VK_FORMAT_D16_UNORM, VK_IMAGE_ASPECT_DEPTH_BIT },
    { VK_FORMAT_X8_D24_UNORM_PACK32, VK_IMAGE_ASPECT_DEPTH_BIT },
    { VK_FORMAT_D24_UNORM_S8_UINT, VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT },
    { VK_FORMAT_D32_SFLOAT_S8_UINT, VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT },
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
            return depths[i].aspects;
    return 0;
}

enum stp_result pass_host_pipeline(const struct stp_env *env, struct stp_context *context,
                                   const struct stp_plan *plan, const struct pass_host *host,
                                   VkPipelineLayout layout, VkPipeline *pipeline)
{
    bool depth = host->depth_format != VK_FORMAT_UNDEFINED;
    struct pass_graphics graphics = {
        .vertex = PLAN_SHADER_HOST_VERTEX,
        .fragment = depth ? PLAN_SHADER_HOST_FRAGMENT_DEPTH : PLAN_SHADER_HOST_FRAGMENT,
        .color_count = 1,
        .color = { host->color_format },
        .depth = host->depth_format,
        .blend = host->replace ? PASS_BLEND_NONE : PASS_BLEND_OVER,
        .depth_write = depth && !host->depth_read_only,
        .compare = host->replace          ? VK_COMPARE_OP_ALWAYS
                   : host->depth_reversed ? VK_COMPARE_OP_GREATER
                                          : VK_COMPARE_OP_LESS,
    };
    return pass_graphics_pipeline(env, context, plan, NULL, &graphics, layout, pipeline);
}

/* Hardware depth of eye depth z: add + scale / z in perspective, add + scale * z orthographic. */
static void depth_convention(const struct stp_plan *plan, const struct pass_host *host, double near,
                             double far, struct pass_host_push *push)
{
    double add = 1, scale = -near;
    if (plan->constant[PLAN_ORTHOGRAPHIC]) {
        scale = 1 / (far - near);
        add = -near * scale;
    } else if (far < INFINITY) {
        add = far / (far - near);
        scale = -near * add;
    }
    push->depth_add = (float)(host->depth_reversed ? 1 - add : add);
    push->depth_scale = (float)(host->depth_reversed ? -scale : scale);
    push->depth_none = host->depth_reversed ? 0 : 1;
}

static int32_t most(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* The part of a tile that is kept, in the host's image; false when nothing of it is inside. */
static bool visible(const struct plan_tile *tile, const struct stp_targets *targets, VkRect2D *area)
{
    int32_t left = most(targets->x + (int32_t)tile->keep[0], 0);
    int32_t top = most(targets->y + (int32_t)tile->keep[1], 0);
    int32_t right = least(targets->x + (int32_t)tile->keep[2], (int32_t)targets->width);
    int32_t bottom = least(targets->y + (int32_t)tile->keep[3], (int32_t)targets->height);
    if (left >= right || top >= bottom)
        return false;
    *area = (VkRect2D){ { left, top }, { (uint32_t)(right - left), (uint32_t)(bottom - top) } };
    return true;
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
                      const struct stp_plan *plan, const struct plan_tile *tile,
                      const struct pass_host *host, const struct stp_targets *targets,
                      VkPipelineLayout layout, VkPipeline pipeline)
{
    VkRect2D area;
    if (!visible(tile, targets, &area))
        return;
    struct pass_host_push push = { .corner = { targets->x, targets->y },
                                   .most = pass_host_most(host->color_format),
                                   .replace = host->replace };
    depth_convention(plan, host, targets->depth_near, targets->depth_far, &push);
    VkRenderingAttachmentInfo color =
        attachment(&targets->color, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    VkRenderingAttachmentInfo depth =
        attachment(&targets->depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    bool has_depth = host->depth_format != VK_FORMAT_UNDEFINED;
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
    context->vk.vkCmdPushConstants(commands, layout, PASS_PUSH_STAGES, PASS_PUSH_HOST, sizeof push,
                                   &push);
    context->vk.vkCmdDraw(commands, 3, 1, 0, 0);
    context->vk.vkCmdEndRendering(commands);
}
