/* Which way layers are composited, what it needs, and why. */
#include <stdio.h>

#include "base/log.h"
#include "plan/plan.h"

enum stp_transparency plan_resolve_transparency(const struct stp_facts *facts,
                                                const struct stp_render_params *params,
                                                const struct stp_limits *limits)
{
    if (!facts->transparent)
        return STP_TRANSPARENCY_AUTO;
    if (params->transparency != STP_TRANSPARENCY_AUTO)
        return params->transparency;
    switch (params->method) {
    case STP_METHOD_AXIS: /* which composites splats, and has no layers */
        return STP_TRANSPARENCY_AUTO;
    case STP_METHOD_DEFERRED:
        return STP_TRANSPARENCY_FAST;
    case STP_METHOD_TWO_PASS:
        return STP_TRANSPARENCY_PEEL;
    case STP_METHOD_REFERENCE:
        return STP_TRANSPARENCY_REFERENCE;
    case STP_METHOD_EXACT:
        return STP_TRANSPARENCY_EXACT;
    default:
        return limits->features & STP_FEATURE_INT64_ATOMICS ? STP_TRANSPARENCY_EXACT
                                                            : STP_TRANSPARENCY_REFERENCE;
    }
}

enum stp_method plan_transparency_method(enum stp_transparency transparency)
{
    static const enum stp_method methods[] = { STP_METHOD_AUTO,     STP_METHOD_DEFERRED,
                                               STP_METHOD_DEFERRED, STP_METHOD_TWO_PASS,
                                               STP_METHOD_EXACT,    STP_METHOD_REFERENCE };
    return methods[transparency];
}

bool plan_covers(const struct stp_plan *plan)
{
    return plan->transparency == STP_TRANSPARENCY_FAST ||
           plan->transparency == STP_TRANSPARENCY_NEAREST;
}

bool stp_plan_needs_cover(const struct stp_facts *facts, const struct stp_render_params *params,
                          const struct stp_limits *limits)
{
    params = plan_params(params);
    enum stp_transparency t = plan_resolve_transparency(facts, params, limits);
    return t == STP_TRANSPARENCY_FAST || t == STP_TRANSPARENCY_NEAREST;
}

static enum stp_result check_cover(const struct stp_env *env, const struct stp_plan *plan)
{
    const char *name = stp_transparency_name(plan->transparency);
    if (plan->params.path == STP_PATH_COMPUTE || plan_samples(plan) > 1)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency %s is drawn by the rasteriser, with one sample a pixel; "
                         "transparency exact has a compute path and samples",
                         name);
    if (plan->params.aovs & STP_AOV_LAYERS)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency %s does not count layers; --aov layers takes exact or peel",
                         name);
    if (!(plan->limits.features & STP_FEATURE_INDEPENDENT_BLEND))
        return log_error(env, STP_ERROR_FEATURE,
                         "transparency %s needs independentBlend, which the device lacks; ask for "
                         "exact",
                         name);
    if (plan->facts.cover.groups == 0)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency %s needs stp_scene_cover before its plan", name);
    return STP_OK;
}

static enum stp_result check_peel(const struct stp_env *env, const struct stp_plan *plan)
{
    if (plan_samples(plan) > 1)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency peel has one sample a pixel; ask for exact");
    if (plan->constant[PLAN_OPTICS] & STP_OPTICS_GLASS)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "transparency peel draws no glass before an environment; ask for exact, "
                         "nearest or fast");
    if (plan->params.path == STP_PATH_COMPUTE &&
        !(plan->limits.features & STP_FEATURE_INT64_ATOMICS))
        return log_error(env, STP_ERROR_FEATURE,
                         "transparency peel --path compute needs shaderBufferInt64Atomics, which "
                         "the device lacks; use --path raster");
    return STP_OK;
}

enum stp_result plan_choose_transparency(const struct stp_env *env, struct stp_plan *plan)
{
    enum stp_method asked = plan->params.method;
    plan->transparency = plan_resolve_transparency(&plan->facts, &plan->params, &plan->limits);
    if (plan->transparency == STP_TRANSPARENCY_AUTO)
        return STP_OK;
    enum stp_method method = plan_transparency_method(plan->transparency);
    if (asked != STP_METHOD_AUTO && asked != method)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method %s does not draw transparency %s, method %s does: ask for one of "
                         "the two only",
                         stp_method_name(asked), stp_transparency_name(plan->transparency),
                         stp_method_name(method));
    if (plan_covers(plan))
        return check_cover(env, plan);
    if (plan->transparency == STP_TRANSPARENCY_PEEL)
        return check_peel(env, plan);
    if (plan->transparency == STP_TRANSPARENCY_EXACT &&
        !(plan->limits.features & STP_FEATURE_INT64_ATOMICS))
        return log_error(env, STP_ERROR_FEATURE,
                         "transparency exact needs shaderBufferInt64Atomics, which the device "
                         "lacks; leave the choice to auto");
    return STP_OK;
}

void plan_explain_layers(struct stp_plan *plan, const char *asked)
{
    const struct stp_cover *cover = &plan->facts.cover;
    const char *name = stp_transparency_name(plan->transparency);
    double least = 1;
    for (unsigned k = 0; k < cover->groups; k++)
        least = cover->coverage[k] < least ? cover->coverage[k] : least;
    if (plan->transparency == STP_TRANSPARENCY_PEEL)
        snprintf(plan->why, sizeof plan->why,
                 "%s is %s: the %u nearest layers, two geometry passes by %s for each.", name,
                 asked, plan_repeats(plan), stp_path_name(plan->path));
    else
        snprintf(plan->why, sizeof plan->why,
                 "%s is %s: %u groups that each cover %.1f %% of the surface or more, %.0f "
                 "%% duplicates, blended back to front by the rasteriser%s.",
                 name, asked, cover->groups, 100 * least, 100 * cover->duplicates,
                 plan->transparency == STP_TRANSPARENCY_NEAREST ? ", the nearest layer apart" : "");
}
