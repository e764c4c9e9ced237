/* Botsch, Spernat & Kobbelt 2004: what ellipses with normal fields add to any plan of surfaces. */
#include "base/log.h"
#include "plan/plan.h"

enum stp_result plan_check_phong(const struct stp_env *env, const struct stp_plan *plan)
{
    if (!plan->facts.phong)
        return STP_OK;
    if (plan->method == STP_METHOD_PYRAMID)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method pyramid draws discs, and the scene has ellipses with normal "
                         "fields; use exact, deferred or two-pass");
    if (plan->transparency == STP_TRANSPARENCY_FAST ||
        plan->transparency == STP_TRANSPARENCY_NEAREST ||
        plan->transparency == STP_TRANSPARENCY_PEEL)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency %s draws discs, and the scene has ellipses with normal "
                         "fields; use exact",
                         stp_transparency_name(plan->transparency));
    if (plan->share.count)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "several processes make one picture of discs only, and the scene has "
                         "ellipses with normal fields: split frames (--split frames)");
    return STP_OK;
}

void plan_phong_resources(struct stp_plan *plan)
{
    uint64_t n = plan_splats(plan);
    if (plan->constant[PLAN_PHONG])
        plan_resource(plan, "ellipses", PLAN_ELLIPSES, PLAN_SCENE,
                      n * sizeof(struct stp_phong_gpu));
    if (plan->constant[PLAN_PHONG] == 2)
        plan_resource(plan, "clip lines", PLAN_CLIPS, PLAN_SCENE, n * sizeof(struct stp_clip_gpu));
}

enum plan_shader plan_raster_shader(const struct stp_plan *plan, enum plan_shader shader)
{
    return plan->constant[PLAN_PHONG]
               ? PLAN_SHADER_RASTER_PHONG + (shader - PLAN_SHADER_RASTER_VERTEX)
               : shader;
}
