/* What a picture needs of the scene's environment: nothing, unless a surface meets it or it stands
 * behind. */
#include "plan/plan.h"

#include "base/vec.h"
#include "scene/environment.h"
#include "scene/scene.h"

_Static_assert(STP_ENVIRONMENT_LEVELS == ENVIRONMENT_LEVELS, "levels");

void plan_turn_environment(struct stp_plan *plan)
{
    struct stp_frame_constants *f = &plan->frame;
    for (int row = 0; plan->constant[PLAN_OPTICS] && row < 3; row++)
        for (int i = 0; i < 3; i++)
            f->environment_frame[3 * row + i] =
                (float)v3_dot(v3_load(plan->environment_axes[row]), v3_load(f->rotation64 + 3 * i));
}

void plan_environment(struct stp_plan *plan, const struct stp_scene *scene)
{
    const struct stp_facts *facts = &plan->facts;
    const struct scene_environment *e = &scene->environment;
    struct stp_frame_constants *f = &plan->frame;
    uint32_t *optics = &plan->constant[PLAN_OPTICS];
    if (!facts->environment_levels)
        return;
    /* A scene that is shaded by depth has no normals that could mirror. */
    if (facts->reflects && !facts->eye_dome)
        *optics = STP_OPTICS_SURFACE | (facts->environment_levels > 1 ? STP_OPTICS_ROUGH : 0) |
                  (facts->between_levels ? STP_OPTICS_BETWEEN : 0) |
                  (facts->disperses && facts->transparent ? STP_OPTICS_DISPERSE : 0) |
                  (facts->mirrors ? STP_OPTICS_MIRRORS : 0);
    if (*optics && facts->transparent)
        *optics |= STP_OPTICS_GLASS | (facts->absorbs ? STP_OPTICS_ABSORBS : 0) |
                   (plan->params.layers == STP_LAYERS_MULTI ? STP_OPTICS_MULTI : 0);
    if (plan->params.environment_behind)
        *optics |= STP_OPTICS_BEHIND;
    if (!*optics)
        return;
    struct environment_frame frame = environment_frame(facts->up, e->params.rotation);
    v3_store(frame.right, plan->environment_axes[0]);
    v3_store(frame.up, plan->environment_axes[1]);
    v3_store(frame.centre, plan->environment_axes[2]);
    plan_turn_environment(plan);
    for (unsigned i = 0; i < e->level_count; i++)
        f->environment_levels[i] = (struct stp_level_gpu){ (uint32_t)e->level[i].first,
                                                           e->level[i].width, e->level[i].height };
}

void plan_environment_resources(struct stp_plan *plan)
{
    if (plan->constant[PLAN_OPTICS] & STP_OPTICS_SURFACE)
        plan_resource(plan, "optics", PLAN_OBJECT_OPTICS, PLAN_SCENE,
                      plan->facts.objects * sizeof(struct stp_optics_gpu));
    if (plan->constant[PLAN_OPTICS])
        plan_resource(plan, "environment", PLAN_ENVIRONMENT, PLAN_SCENE,
                      plan->facts.environment_texels * 12);
}
