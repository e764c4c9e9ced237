/* Barriers of a walk: one memory barrier a pass at most, of what its resources ask for. */
#include "record/hazards.h"

static struct hazard_scope attachment_scope(const struct plan_resource *resource)
{
    if (resource->format == PLAN_D32F)
        return (struct hazard_scope){ VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |
                                          VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
                                      VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                          VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT };
    return (struct hazard_scope){ VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                  VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT |
                                      VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT };
}

static struct hazard_scope scope_of(const struct stp_plan *plan, const struct plan_pass *pass,
                                    const struct plan_access *access)
{
    const struct plan_resource *resource = &plan->resource[access->resource];
    if (pass->kind == PLAN_FILL || pass->kind == PLAN_ARGUMENTS || pass->kind == PLAN_COPY_DEPTH)
        return (struct hazard_scope){ VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                      VK_ACCESS_2_TRANSFER_WRITE_BIT };
    if (access->kind & PLAN_ATTACHMENT)
        return attachment_scope(resource);
    struct hazard_scope scope = { pass->kind == PLAN_DRAW
                                      ? VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                                            VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT
                                      : VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                  0 };
    if (access->kind & PLAN_READ)
        scope.access |= VK_ACCESS_2_SHADER_READ_BIT; /* as storage or as texels */
    if (access->kind & PLAN_WRITE)
        scope.access |= VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
    if (pass->kind == PLAN_DISPATCH_INDIRECT && resource->slot == PLAN_WORK) {
        scope.stages |= VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
        scope.access |= VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT;
    }
    return scope;
}

static bool is_visible(const struct hazard *hazard, const struct hazard_scope *scope)
{
    return !(scope->stages & ~hazard->visible.stages) && !(scope->access & ~hazard->visible.access);
}

/* Of what is attached layer by layer, the pass's own. */
static uint64_t layers_of(const struct stp_plan *plan, const struct plan_pass *pass,
                          const struct plan_access *access)
{
    bool one = (access->kind & PLAN_ATTACHMENT) && pass->layer_count == 1 && pass->layer < 64 &&
               plan->resource[access->resource].layers > 1;
    return one ? (uint64_t)1 << pass->layer : UINT64_MAX;
}

static void wait_for(const struct hazard *hazard, const struct hazard_scope *scope,
                     VkPipelineStageFlags2 read, VkMemoryBarrier2 *memory)
{
    memory->srcStageMask |= hazard->written.stages | read;
    memory->srcAccessMask |= hazard->written.access;
    memory->dstStageMask |= scope->stages;
    memory->dstAccessMask |= scope->access;
}

/* Later readers' stages are shown with every access so far: visible is a product of both. */
static void add_read(struct hazard *hazard, const struct hazard_scope *scope,
                     VkMemoryBarrier2 *memory)
{
    if (hazard->written.stages && !is_visible(hazard, scope)) {
        hazard->visible.stages |= scope->stages;
        hazard->visible.access |= scope->access;
        wait_for(hazard, &hazard->visible, 0, memory);
    }
    hazard->read |= scope->stages;
}

static void add_write(struct hazard *hazard, const struct hazard_scope *scope, uint64_t layers,
                      VkMemoryBarrier2 *memory)
{
    bool again = hazard->written.stages && (hazard->layers & layers);
    if (!again && !hazard->read) {
        hazard->written.stages |= scope->stages;
        hazard->written.access |= scope->access;
        hazard->layers |= layers;
        return;
    }
    wait_for(hazard, scope, hazard->read, memory);
    *hazard = (struct hazard){ .written = *scope, .layers = layers };
}

void hazards_add(struct hazards *hazards, const struct stp_plan *plan, const struct plan_pass *pass,
                 VkMemoryBarrier2 *memory)
{
    for (unsigned i = 0; i < pass->access_count; i++) {
        const struct plan_access *access = &pass->access[i];
        struct hazard *hazard = &hazards->of[access->resource];
        struct hazard_scope scope = scope_of(plan, pass, access);
        if (access->kind & PLAN_WRITE)
            add_write(hazard, &scope, layers_of(plan, pass, access), memory);
        else
            add_read(hazard, &scope, memory);
    }
}
