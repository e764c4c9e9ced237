/* Layers kept one by one for deep pictures (docs/exr.md): a window of a few a pixel, which
 * recording empties as often as there are more. */
#include "plan/plan.h"

#include "base/log.h"

static const char *why_not(const struct stp_plan *plan)
{
    if (plan_of_medium(&plan->facts))
        return "volumes and ellipsoids of range images have no layers";
    if (plan_axis_asked(plan))
        return "method axis composites splats one by one, not layers; use exact";
    if (plan_samples(plan) > 1)
        return "several samples of a pixel have no common layers; leave samples at 1";
    if (plan->transparency == STP_TRANSPARENCY_AUTO)
        return NULL;
    if (plan->transparency != STP_TRANSPARENCY_EXACT &&
        plan->transparency != STP_TRANSPARENCY_REFERENCE)
        return "of a transparent scene, transparency exact and reference keep layers";
    if (plan->facts.eye_dome)
        return "shading by depth belongs to the pixel, not to its layers; give the points normals";
    return NULL;
}

enum stp_result plan_deep_check(const struct stp_env *env, struct stp_plan *plan)
{
    const char *why = plan->params.deep ? why_not(plan) : NULL;
    if (why)
        return log_error(env, STP_ERROR_ARGUMENT, "no deep picture: %s", why);
    plan->constant[PLAN_DEEP] = plan->params.deep && plan->transparency == STP_TRANSPARENCY_EXACT;
    return STP_OK;
}

void plan_deep_begin(struct stp_plan *plan)
{
    if (!plan->constant[PLAN_DEEP])
        return;
    uint64_t pixels = plan_pixels(plan);
    plan_resource(plan, "deep layers", PLAN_DEEP_LAYERS, PLAN_OUTPUT,
                  pixels * STP_DEEP_WINDOW * STP_DEEP_FLOATS * 4);
    plan_resource(plan, "deep counts", PLAN_DEEP_COUNTS, PLAN_OUTPUT, pixels * 4);
    plan_fill(plan, PLAN_DEEP_COUNTS, 0, "clear deep counts");
}

void plan_deep_write(struct stp_plan *plan)
{
    struct plan_pass *pass = &plan->pass[plan->pass_count - 1];
    plan_updates(plan, pass, PLAN_DEEP_LAYERS);
    plan_writes(plan, pass, PLAN_DEEP_COUNTS);
}
