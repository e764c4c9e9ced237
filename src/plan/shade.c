/* Where the light is computed: per pixel, or, as baselines, per splat (BSK 6). */
#include <math.h>

#include "base/log.h"
#include "plan/plan.h"
#include "scene/scene.h"

enum stp_result plan_check_shade(const struct stp_env *env, const struct stp_plan *plan)
{
    if (plan->params.shade == STP_SHADE_PIXEL)
        return STP_OK;
    if (plan_axis_asked(plan) ||
        (plan->method != STP_METHOD_TWO_PASS && plan->method != STP_METHOD_REFERENCE))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method %s has a light of its own; --shade splat and flat take two-pass "
                         "or reference",
                         stp_method_name(plan->method));
    if (plan->facts.transparent || plan->facts.environment_levels || plan->share.count)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "--shade splat and flat draw opaque scenes without an environment, in one "
                         "process");
    if (plan->params.aovs & STP_AOV_ALBEDO)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "--shade splat and flat average no albedo: leave the aov out");
    if (plan->params.shade == STP_SHADE_FLAT && plan->params.path == STP_PATH_RASTER)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "--shade flat has no raster path; use --path compute");
    return STP_OK;
}

double plan_largest(const float *value, unsigned count)
{
    double most = 0;
    for (unsigned i = 0; i < count; i++)
        most = fmax(most, fabs((double)value[i]));
    return most;
}

double plan_most_light(const struct stp_plan *plan, const struct stp_scene *scene)
{
    double light = 0, most = 0;
    for (unsigned i = 0; i < scene->light_count; i++)
        light += plan_largest(scene->lights[i].color, 3);
    for (unsigned i = 0; i < scene->object_count; i++) {
        const struct stp_material *m = &scene->objects[i].material;
        double albedo = fmax(plan_largest(m->albedo, 3), (double)plan->facts.color_max);
        most = fmax(most, fabs((double)m->specular) +
                              albedo * (fabs((double)m->ambient) + fabs((double)m->diffuse)));
    }
    return most * light;
}
