#include "passes/passes.h"

enum stp_result pass_compute_pipeline(const struct stp_env *env, struct stp_context *context,
                                      const struct stp_plan *plan, const struct plan_pass *pass,
                                      VkPipelineLayout layout, VkPipeline *pipeline)
{
    struct pass_specialization specialization;
    VkShaderModule module;
    VkResult result = pass_module(context, plan, pass->shader, &module);
    if (result != VK_SUCCESS)
        return gpu_error(env, result, "vkCreateShaderModule");
    pass_specialize(plan, pass, &specialization);
    VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = { .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                   .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                   .module = module,
                   .pName = "main",
                   .pSpecializationInfo = &specialization.info },
        .layout = layout
    };
    result = context->vk.vkCreateComputePipelines(context->device, context->cache, 1, &info, NULL,
                                                  pipeline);
    context->vk.vkDestroyShaderModule(context->device, module, NULL);
    return result == VK_SUCCESS ? STP_OK : gpu_error(env, result, "vkCreateComputePipelines");
}

/* The level that a pass writes, or, of level 0, the points that it takes. */
static void push_pyramid(struct stp_context *context, VkCommandBuffer commands,
                         const struct plan_pass *pass, const struct pass_resources *resources)
{
    const uint32_t first = pass->level ? pass->level : resources->points.first;
    const uint32_t count = resources->points.count;
    context->vk.vkCmdPushConstants(commands, resources->layout, PASS_PUSH_STAGES, PASS_PUSH_FIRST,
                                   sizeof first, &first);
    context->vk.vkCmdPushConstants(commands, resources->layout, PASS_PUSH_STAGES, PASS_PUSH_COUNT,
                                   sizeof count, &count);
}

void pass_record_compute(struct stp_context *context, VkCommandBuffer commands,
                         const struct stp_plan *plan, const struct plan_pass *pass,
                         const struct plan_tile *tile, const struct pass_resources *resources,
                         VkPipeline pipeline)
{
    context->vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    if (plan->method == STP_METHOD_PYRAMID)
        push_pyramid(context, commands, pass, resources);
    if (pass->kind == PLAN_DISPATCH_INDIRECT) {
        const struct gpu_buffer *work = &resources->buffer[plan_find(plan, PLAN_WORK)];
        context->vk.vkCmdDispatchIndirect(commands, work->handle, pass->offset);
        return;
    }
    uint32_t blocks =
        ((tile->width + STP_BLOCK - 1) / STP_BLOCK) * ((tile->height + STP_BLOCK - 1) / STP_BLOCK);
    uint32_t groups = pass->groups ? pass->groups : blocks;
    if (pass->of_grid) {
        struct plan_grid grid = plan_tile_grid(plan, tile);
        groups = plan_level_blocks(&grid, pass->level);
    }
    if (pass->of_points)
        groups = (resources->points.count + STP_POINT_RUN - 1) / STP_POINT_RUN;
    /* Rows: no device need take more than 65535 along x. */
    context->vk.vkCmdDispatch(commands, groups < STP_ROW ? groups : STP_ROW,
                              (groups + STP_ROW - 1) / STP_ROW, 1);
}
