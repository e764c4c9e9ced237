/* BSK 4.1: lighting over normals, precomputed into a cube map. */
#include <math.h>

#include "base/log.h"
#include "plan/plan.h"
#include "scene/scene.h"

static const char *why_not(const struct stp_plan *plan)
{
    if (plan_of_medium(&plan->facts))
        return "volumes and range images";
    if (plan->method == STP_METHOD_PYRAMID)
        return "method pyramid";
    if (plan->facts.eye_dome)
        return "a scene that is shaded by depth";
    if (plan->facts.positional_lights)
        return "lights that have a place";
    if (plan->params.local_viewer)
        return "a local viewer";
    if (plan->constant[PLAN_SQUARINGS] > 16)
        return "a shininess that is no power of two, or not one for all objects";
    return NULL;
}

enum stp_result plan_light_cube(const struct stp_env *env, struct stp_plan *plan)
{
    if (plan->params.light_cube != STP_ON || plan->method == STP_METHOD_REFERENCE)
        return STP_OK;
    const char *why = why_not(plan);
    if (why)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "a light cube cannot hold the light of %s; leave --light-cube out", why);
    plan->constant[PLAN_LIGHT_CUBE] = 1;
    plan->constant[PLAN_HEAD_LIGHT] = 0;
    return STP_OK;
}

void plan_light_cube_steps(struct stp_plan *plan)
{
    if (!plan->constant[PLAN_LIGHT_CUBE])
        return;
    const uint32_t texels = 6 * STP_LIGHT_CUBE * STP_LIGHT_CUBE;
    plan_resource(plan, "light cube", PLAN_LIGHTS, PLAN_TRANSIENT, texels * 24);
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "light cube");
    pass->shader = PLAN_SHADER_LIGHT_CUBE;
    pass->groups = (texels + STP_GROUP - 1) / STP_GROUP;
    plan_writes(plan, pass, PLAN_LIGHTS);
}

/* Texels are d apart on a face of half side 1, where a step turns the normal by no more than its
 * own length. Bilinear interpolation is off by at most d^2 / 8 of each second derivative: 1 of a
 * diffuse term away from its edge, 2 s of a specular one of exponent s; and by a quarter of the
 * diagonal where the diffuse term bends. */
double plan_light_cube_error(const struct stp_plan *plan, const struct stp_scene *scene)
{
    if (!plan->constant[PLAN_LIGHT_CUBE])
        return 0;
    double d = 2.0 / (STP_LIGHT_CUBE - 1), light = 0, most = 0;
    for (unsigned i = 0; i < scene->light_count; i++)
        light += plan_largest(scene->lights[i].color, 3);
    for (unsigned i = 0; i < scene->object_count; i++) {
        const struct stp_material *m = &scene->objects[i].material;
        double albedo = fmax(plan_largest(m->albedo, 3), (double)plan->facts.color_max);
        double peak = fmin(1, (double)m->shininess * d * d / 2);
        most = fmax(most, fabs((double)m->specular) * peak +
                              albedo * fabs((double)m->diffuse) * (M_SQRT2 * d + d * d) / 4);
    }
    return most * light;
}
