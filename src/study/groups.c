#include "study/study.h"

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

static void show(struct stp_scene *scene, const struct study_grouping *grouping)
{
    scene->splats.group = grouping->group;
    scene->facts.grouping = grouping->facts;
}

void study_groups_begin(struct study_groups *groups, struct stp_scene *scene)
{
    *groups = (struct study_groups){ .scene = scene };
    groups->before.group = scene->splats.group;
    groups->before.facts = scene->facts.grouping;
}

enum stp_result study_groups_use(const struct stp_env *env, struct study_groups *groups,
                                 const struct stp_group_params *params, double overlap)
{
    struct stp_scene *scene = groups->scene;
    for (unsigned i = 0; i < groups->count; i++) {
        if (groups->at[i].asked == overlap) {
            show(scene, &groups->at[i]);
            return STP_OK;
        }
    }
    if (groups->count == STUDY_MAX_GROUPINGS)
        return log_error(env, STP_ERROR_ARGUMENT, "more than %d overlaps in one sweep",
                         STUDY_MAX_GROUPINGS);
    struct stp_group_params asked = *params;
    asked.overlap = overlap;
    /* What the scene shows is kept elsewhere: grouping must not free it. */
    scene->splats.group = NULL;
    enum stp_result result = stp_scene_group(env, scene, &asked);
    if (result == STP_OK)
        groups->at[groups->count++] =
            (struct study_grouping){ overlap, scene->facts.grouping, scene->splats.group };
    else
        show(scene, &groups->before);
    return result;
}

void study_groups_end(struct study_groups *groups)
{
    for (unsigned i = 0; i < groups->count; i++)
        mem_free(groups->at[i].group);
    if (groups->scene)
        show(groups->scene, &groups->before);
    *groups = (struct study_groups){ 0 };
}
