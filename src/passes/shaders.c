#include "passes/passes.h"

#include <string.h>

#include "shader_list.h"

struct words {
    const uint32_t *words;
    size_t bytes;
};

/* In the order of enum plan_shader; [1] is compiled with double. */
static const struct words shaders[][2] = { { { 0 } },
#define SHADER(name)                                                                               \
    { { spv_f32_##name, sizeof spv_f32_##name }, { spv_f64_##name, sizeof spv_f64_##name } },
                                           SHADER_LIST };
_Static_assert(sizeof shaders / sizeof *shaders == PLAN_SHADERS, "one variant a plan_shader");

VkResult pass_module(struct stp_context *context, const struct stp_plan *plan,
                     enum plan_shader shader, VkShaderModule *module)
{
    struct words words = shaders[shader][plan->constant[PLAN_FLOAT64] != 0];
    VkShaderModuleCreateInfo info = { .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                      .codeSize = words.bytes,
                                      .pCode = words.words };
    return context->vk.vkCreateShaderModule(context->device, &info, NULL, module);
}

static uint32_t axis_walk(const struct stp_plan *plan, const struct plan_pass *pass)
{
    return plan->method == STP_METHOD_AXIS ? pass->layer : 0;
}

void pass_specialize(const struct stp_plan *plan, const struct plan_pass *pass,
                     struct pass_specialization *s)
{
    for (uint32_t i = 0; i < PLAN_CONSTANTS; i++) {
        s->values[i] = !pass                 ? plan->constant[i]
                       : i == PLAN_REPAIR    ? pass->repair
                       : i == PLAN_AXIS_WALK ? axis_walk(plan, pass)
                       : i == PLAN_AXIS_PART ? pass->part
                                             : plan->constant[i];
        s->entries[i] = (VkSpecializationMapEntry){ i, i * 4, 4 };
    }
    s->info = (VkSpecializationInfo){ PLAN_CONSTANTS, s->entries, sizeof s->values, s->values };
}

void pass_key(const struct stp_plan *plan, const struct plan_pass *pass,
              uint32_t key[PASS_KEY_WORDS])
{
    bool draw = pass->kind == PLAN_DRAW;
    memset(key, 0, PASS_KEY_WORDS * sizeof *key);
    if (!draw && pass->kind != PLAN_DISPATCH && pass->kind != PLAN_DISPATCH_INDIRECT)
        return;
    *key++ = draw ? 2 : 1;
    *key++ = pass->shader;
    *key++ = pass->repair;
    *key++ = axis_walk(plan, pass);
    *key++ = pass->part;
    if (draw)
        pass_raster_key(plan, pass, key);
}

enum stp_result pass_pipeline(const struct stp_env *env, struct stp_context *context,
                              const struct stp_plan *plan, const struct plan_pass *pass,
                              VkPipelineLayout layout, VkPipeline *pipeline)
{
    if (pass->kind == PLAN_DRAW)
        return pass_raster_pipeline(env, context, plan, pass, layout, pipeline);
    if (pass->kind == PLAN_DISPATCH || pass->kind == PLAN_DISPATCH_INDIRECT)
        return pass_compute_pipeline(env, context, plan, pass, layout, pipeline);
    return STP_OK;
}

void pass_record(struct stp_context *context, VkCommandBuffer commands, const struct stp_plan *plan,
                 const struct plan_pass *pass, const struct plan_tile *tile,
                 const struct pass_resources *resources, VkPipeline pipeline)
{
    switch (pass->kind) {
    case PLAN_FILL:
    case PLAN_ARGUMENTS:
        pass_record_transfer(context, commands, plan, pass, tile, resources);
        break;
    case PLAN_DISPATCH:
    case PLAN_DISPATCH_INDIRECT:
        pass_record_compute(context, commands, plan, pass, tile, resources, pipeline);
        break;
    case PLAN_DRAW:
        pass_record_raster(context, commands, plan, pass, tile, resources, pipeline);
        break;
    case PLAN_COPY_DEPTH:
        pass_record_copy_depth(context, commands, plan, pass, tile, resources);
        break;
    case PLAN_EXCHANGE: /* the host's work: record/exchange.c */
        break;
    }
}
