/* What axis lists need of a surface: its own splats as flat Gaussians, and what they cannot show.
 */
#include "base/log.h"
#include "plan/plan.h"
#include "prepare/axis_region.h"

bool plan_axis_asked(const struct stp_plan *plan)
{
    return plan->params.method == STP_METHOD_AXIS && !plan_of_medium(&plan->facts);
}

enum stp_result plan_check_axis_surface(const struct stp_env *env, const struct stp_plan *plan)
{
    if (!plan_axis_asked(plan))
        return STP_OK;
    if (plan->constant[PLAN_OPTICS] & STP_OPTICS_SURFACE)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method axis lights splats one by one and mirrors nothing: leave the "
                         "environment out, or use exact");
    if (plan->facts.transparent && (plan->params.aovs & STP_AOV_LAYERS))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method axis composites splats, not layers: --aov layers takes exact");
    return STP_OK;
}

void plan_axis_surface_project(struct stp_plan *plan)
{
    uint64_t splats = plan->facts.splats;
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "project");
    pass->shader = PLAN_SHADER_AXIS_SURFACE;
    pass->groups = (uint32_t)((splats + STP_GROUP - 1) / STP_GROUP);
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OPACITIES);
    plan_reads(plan, pass, PLAN_MATERIALS);
    plan_writes(plan, pass, PLAN_PROJECTED);
}
