#include "passes/passes.h"

VkFormat pass_format(enum plan_format format)
{
    switch (format) {
    case PLAN_RG32UI:
    case PLAN_TEXELS_RG32UI:
        return VK_FORMAT_R32G32_UINT;
    case PLAN_RG32F:
        return VK_FORMAT_R32G32_SFLOAT;
    case PLAN_RGBA32F:
        return VK_FORMAT_R32G32B32A32_SFLOAT;
    case PLAN_D32F:
        return VK_FORMAT_D32_SFLOAT;
    case PLAN_RGBA32UI:
    case PLAN_TEXELS_RGBA32UI:
        return VK_FORMAT_R32G32B32A32_UINT;
    case PLAN_TEXELS_R32F:
        return VK_FORMAT_R32_SFLOAT;
    case PLAN_TEXELS_R32UI:
        return VK_FORMAT_R32_UINT;
    case PLAN_BUFFER:
        break;
    }
    return VK_FORMAT_UNDEFINED;
}

bool pass_is_texels(enum plan_format format)
{
    return format == PLAN_TEXELS_RGBA32UI || format == PLAN_TEXELS_R32F ||
           format == PLAN_TEXELS_RG32UI || format == PLAN_TEXELS_R32UI;
}

bool pass_is_image(enum plan_format format)
{
    return format != PLAN_BUFFER && !pass_is_texels(format);
}

/* The plan's resource indices of a pass's attachments; depth is PLAN_NONE where there is none. */
struct targets {
    uint32_t color_count;
    uint8_t color[PASS_MOST_COLORS];
    uint8_t depth;
};

static struct targets find_targets(const struct stp_plan *plan, const struct plan_pass *pass)
{
    struct targets t = { .depth = PLAN_NONE };
    for (unsigned i = 0; i < pass->access_count; i++) {
        uint8_t resource = pass->access[i].resource;
        if (!(pass->access[i].kind & PLAN_ATTACHMENT))
            continue;
        if (plan->resource[resource].format == PLAN_D32F)
            t.depth = resource;
        else
            t.color[t.color_count++] = resource;
    }
    return t;
}

/* State that no pass varies. */
static const VkPipelineVertexInputStateCreateInfo no_vertices = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO
};
static const VkPipelineInputAssemblyStateCreateInfo triangles = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
    .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST
};
static const VkPipelineViewportStateCreateInfo one_viewport = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
    .viewportCount = 1,
    .scissorCount = 1
};
static const VkPipelineRasterizationStateCreateInfo fill = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
    .polygonMode = VK_POLYGON_MODE_FILL,
    .lineWidth = 1
};
static const VkPipelineMultisampleStateCreateInfo one_sample = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
    .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT
};
static const VkDynamicState moving[] = { VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR };
static const VkPipelineDynamicStateCreateInfo set_late = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
    .dynamicStateCount = 2,
    .pDynamicStates = moving
};

static bool is_integer(VkFormat format)
{
    return format == VK_FORMAT_R32G32_UINT || format == VK_FORMAT_R32G32B32A32_UINT;
}

static VkResult create_pipeline(struct stp_context *context, const struct pass_graphics *graphics,
                                const VkPipelineShaderStageCreateInfo *stages,
                                VkPipelineLayout layout, VkPipeline *pipeline)
{
    bool has_depth = graphics->depth != VK_FORMAT_UNDEFINED;
    VkPipelineRenderingCreateInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .colorAttachmentCount = graphics->color_count,
        .pColorAttachmentFormats = graphics->color,
        .depthAttachmentFormat = graphics->depth
    };
    VkPipelineDepthStencilStateCreateInfo depth = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = has_depth,
        .depthWriteEnable = graphics->depth_write,
        .depthCompareOp = graphics->compare
    };
    VkBlendFactor under = graphics->blend == PASS_BLEND_OVER ? VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA
                                                             : VK_BLEND_FACTOR_ONE;
    VkPipelineColorBlendAttachmentState attachments[PASS_MOST_COLORS];
    for (int i = 0; i < PASS_MOST_COLORS; i++)
        attachments[i] = (VkPipelineColorBlendAttachmentState){
            .blendEnable = graphics->blend != PASS_BLEND_NONE && !is_integer(graphics->color[i]),
            .srcColorBlendFactor = VK_BLEND_FACTOR_ONE,
            .dstColorBlendFactor = under,
            .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
            .dstAlphaBlendFactor = under,
            .colorWriteMask = 0xf,
        };
    VkPipelineColorBlendStateCreateInfo colors = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = graphics->color_count,
        .pAttachments = attachments
    };
    VkGraphicsPipelineCreateInfo info = { .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = &rendering,
                                          .stageCount = 2,
                                          .pStages = stages,
                                          .pVertexInputState = &no_vertices,
                                          .pInputAssemblyState = &triangles,
                                          .pViewportState = &one_viewport,
                                          .pRasterizationState = &fill,
                                          .pMultisampleState = &one_sample,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &colors,
                                          .pDynamicState = &set_late,
                                          .layout = layout };
    return context->vk.vkCreateGraphicsPipelines(context->device, context->cache, 1, &info, NULL,
                                                 pipeline);
}

enum stp_result pass_graphics_pipeline(const struct stp_env *env, struct stp_context *context,
                                       const struct stp_plan *plan, const struct plan_pass *pass,
                                       const struct pass_graphics *graphics,
                                       VkPipelineLayout layout, VkPipeline *pipeline)
{
    struct pass_specialization specialization;
    VkShaderModule modules[2] = { 0 };
    pass_specialize(plan, pass, &specialization);
    VkResult result = pass_module(context, plan, graphics->vertex, &modules[0]);
    if (result == VK_SUCCESS)
        result = pass_module(context, plan, graphics->fragment, &modules[1]);
    VkPipelineShaderStageCreateInfo stages[2];
    for (int i = 0; i < 2; i++)
        stages[i] = (VkPipelineShaderStageCreateInfo){
            .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
            .stage = i == 0 ? VK_SHADER_STAGE_VERTEX_BIT : VK_SHADER_STAGE_FRAGMENT_BIT,
            .module = modules[i],
            .pName = "main",
            .pSpecializationInfo = &specialization.info
        };
    if (result == VK_SUCCESS)
        result = create_pipeline(context, graphics, stages, layout, pipeline);
    for (int i = 0; i < 2; i++)
        if (modules[i])
            context->vk.vkDestroyShaderModule(context->device, modules[i], NULL);
    return result == VK_SUCCESS ? STP_OK : gpu_error(env, result, "vkCreateGraphicsPipelines");
}

void pass_raster_key(const struct stp_plan *plan, const struct plan_pass *pass,
                     uint32_t key[PASS_RASTER_KEY_WORDS])
{
    struct targets targets = find_targets(plan, pass);
    *key++ = pass->vertex;
    *key++ = pass->raster;
    *key++ = targets.depth != PLAN_NONE;
    for (uint32_t i = 0; i < targets.color_count; i++)
        *key++ = pass_format(plan->resource[targets.color[i]].format);
}

enum stp_result pass_raster_pipeline(const struct stp_env *env, struct stp_context *context,
                                     const struct stp_plan *plan, const struct plan_pass *pass,
                                     VkPipelineLayout layout, VkPipeline *pipeline)
{
    struct targets targets = find_targets(plan, pass);
    static const enum pass_blend blends[] = { [PLAN_RASTER_WINNER] = PASS_BLEND_NONE,
                                              [PLAN_RASTER_BLEND] = PASS_BLEND_ADD,
                                              [PLAN_RASTER_OVER] = PASS_BLEND_OVER };
    struct pass_graphics graphics = {
        .vertex = pass->vertex,
        .fragment = pass->shader,
        .color_count = targets.color_count,
        .depth = targets.depth == PLAN_NONE ? VK_FORMAT_UNDEFINED : VK_FORMAT_D32_SFLOAT,
        .blend = blends[pass->raster],
        .depth_write = pass->raster != PLAN_RASTER_BLEND,
        .compare = VK_COMPARE_OP_GREATER,
    };
    for (uint32_t i = 0; i < targets.color_count; i++)
        graphics.color[i] = pass_format(plan->resource[targets.color[i]].format);
    return pass_graphics_pipeline(env, context, plan, pass, &graphics, layout, pipeline);
}

static VkImageView view_of(const struct gpu_image *image, const struct plan_pass *pass)
{
    return image->layers && pass->layer_count == 1 ? image->layers[pass->layer] : image->all;
}

/* Every attachment starts cleared: ids to none, depth to far, sums to zero. */
static VkRenderingAttachmentInfo attachment(const struct stp_plan *plan,
                                            const struct plan_pass *pass,
                                            const struct pass_resources *resources,
                                            uint8_t resource)
{
    VkClearValue clear = { 0 };
    if (plan->resource[resource].slot == PLAN_IMAGE_ID)
        for (int i = 0; i < 4; i++)
            clear.color.uint32[i] = STP_NO_ID;
    return (VkRenderingAttachmentInfo){ .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                        .imageView = view_of(&resources->image[resource], pass),
                                        .imageLayout = VK_IMAGE_LAYOUT_GENERAL,
                                        .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                        .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                        .clearValue = clear };
}

_Static_assert(offsetof(struct stp_push, push_shift) == PASS_PUSH_DRAW + sizeof(float),
               "pushed together");

static void push_draw(struct stp_context *context, VkCommandBuffer commands,
                      const struct plan_pass *pass, const struct pass_resources *resources)
{
    const float draw[] = { pass->scale > 0 ? pass->scale : 1, pass->shift };
    context->vk.vkCmdPushConstants(commands, resources->layout, PASS_PUSH_STAGES, PASS_PUSH_FIRST,
                                   sizeof pass->first_splat, &pass->first_splat);
    context->vk.vkCmdPushConstants(commands, resources->layout, PASS_PUSH_STAGES, PASS_PUSH_DRAW,
                                   sizeof draw, draw);
}

void pass_record_raster(struct stp_context *context, VkCommandBuffer commands,
                        const struct stp_plan *plan, const struct plan_pass *pass,
                        const struct plan_tile *tile, const struct pass_resources *resources,
                        VkPipeline pipeline)
{
    struct targets targets = find_targets(plan, pass);
    VkRenderingAttachmentInfo colors[PASS_MOST_COLORS], depth;
    for (uint32_t i = 0; i < targets.color_count; i++)
        colors[i] = attachment(plan, pass, resources, targets.color[i]);
    if (targets.depth != PLAN_NONE)
        depth = attachment(plan, pass, resources, targets.depth);
    VkRect2D area = { .extent = { tile->width, tile->height } };
    VkRenderingInfo rendering = { .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = area,
                                  .layerCount = pass->layer_count,
                                  .colorAttachmentCount = targets.color_count,
                                  .pColorAttachments = colors,
                                  .pDepthAttachment = targets.depth == PLAN_NONE ? NULL : &depth };
    float guard = pass_guard(plan, tile), around = (guard - 1) / 2;
    VkViewport viewport = { .x = -around * (float)tile->width,
                            .y = -around * (float)tile->height,
                            .width = guard * (float)tile->width,
                            .height = guard * (float)tile->height,
                            .maxDepth = 1 };
    context->vk.vkCmdBeginRendering(commands, &rendering);
    context->vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    push_draw(context, commands, pass, resources);
    context->vk.vkCmdSetViewport(commands, 0, 1, &viewport);
    context->vk.vkCmdSetScissor(commands, 0, 1, &area);
    if (pass->splat_count)
        context->vk.vkCmdDraw(commands, pass->splat_count * 3, 1, 0, 0);
    context->vk.vkCmdEndRendering(commands);
}
