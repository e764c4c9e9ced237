/* What a picture needs of the scene's environment: nothing, unless a surface meets it or it stands
 * behind. */
#include "plan/plan.h"

#include "base/vec.h"
#include "scene/environment.h"
#include "scene/scene.h"

_Static_assert(STP_ENVIRONMENT_LEVELS == ENVIRONMENT_LEVELS, "levels");

static void store(float row[3], const double *camera_rows, struct vec3 axis)
{
    for (int i = 0; i < 3; i++)
        row[i] = (float)v3_dot(axis, v3_load(camera_rows + 3 * i));
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
    store(f->environment_frame, f->rotation64, frame.right);
    store(f->environment_frame + 3, f->rotation64, frame.up);
    store(f->environment_frame + 6, f->rotation64, frame.centre);
    for (unsigned i = 0; i < e->level_count; i++)
        f->environment_levels[i] = (struct stp_level_gpu){ (uint32_t)e->level[i].first,
                                                           e->level[i].width, e->level[i].height };
}
