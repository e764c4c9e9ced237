/* Layers in a host's frame. Its depth cuts them one by one, so the frame's plan copies that depth
 * first and makes an eye depth of it that ends each pixel's ray: passes over the splats leave out
 * what is behind it. A plan that is rendered alone has none of this. */
#include "plan/plan.h"

#include "base/log.h"
#include "base/memory.h"

void plan_limits(struct stp_plan *plan)
{
    if (!plan->constant[PLAN_HOST_DEPTH])
        return;
    uint64_t pixels = plan_pixels(plan);
    plan_resource(plan, "host depth", PLAN_HOST_WORDS, PLAN_TRANSIENT, pixels * 4);
    plan_resource(plan, "limits", PLAN_LIMITS, PLAN_TRANSIENT, pixels * 4);
    struct plan_pass *pass = plan_pass(plan, PLAN_COPY_DEPTH, "copy depth");
    plan_writes(plan, pass, PLAN_HOST_WORDS);
    pass = plan_pass(plan, PLAN_DISPATCH, "limits");
    pass->shader = PLAN_SHADER_HOST_LIMITS;
    plan_reads(plan, pass, PLAN_HOST_WORDS);
    plan_writes(plan, pass, PLAN_LIMITS);
}

enum stp_result plan_behind_host(const struct stp_env *env, struct stp_plan *plan,
                                 enum plan_host_depth depth)
{
    if (plan->transparency == STP_TRANSPARENCY_AUTO || depth == PLAN_HOST_DEPTH_NONE)
        return STP_OK;
    if (plan->transparency != STP_TRANSPARENCY_EXACT)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency %s is not cut by a host's depth; use exact, or a frame "
                         "without depth",
                         stp_transparency_name(plan->transparency));
    struct plan_tile *before = plan->tile;
    plan->constant[PLAN_HOST_DEPTH] = depth;
    enum stp_result result = plan_tiles(env, plan);
    if (result == STP_OK)
        mem_free(before);
    else
        plan->tile = before;
    return result;
}
