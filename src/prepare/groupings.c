#include "prepare/groupings.h"

#include "base/log.h"
#include "base/memory.h"
#include "prepare/prepare.h"

static void show(struct stp_scene *scene, const struct grouping_at *grouping)
{
    scene->splats.group = grouping->group;
    scene->facts.grouping = grouping->facts;
    scene->version.groups = grouping->version;
}

void groupings_begin(struct groupings *groupings, struct stp_scene *scene)
{
    *groupings = (struct groupings){ .scene = scene };
    groupings->before.group = scene->splats.group;
    groupings->before.facts = scene->facts.grouping;
    groupings->before.version = scene->version.groups;
}

enum stp_result groupings_use(const struct stp_env *env, struct groupings *groupings,
                              const struct stp_group_params *params, double overlap)
{
    struct stp_scene *scene = groupings->scene;
    for (unsigned i = 0; i < groupings->count; i++) {
        if (groupings->at[i].asked == overlap) {
            show(scene, &groupings->at[i]);
            return STP_OK;
        }
    }
    if (groupings->count == MAX_GROUPINGS)
        return log_error(env, STP_ERROR_ARGUMENT, "more than %d overlaps in one sweep",
                         MAX_GROUPINGS);
    struct stp_group_params asked = *params;
    asked.overlap = overlap;
    /* What the scene shows is kept elsewhere: grouping must not free it. */
    scene->splats.group = NULL;
    enum stp_result result = scene_check_whole(env, scene, "grouping");
    if (result == STP_OK)
        result = group_scene(env, scene, &asked);
    if (result == STP_OK)
        groupings->at[groupings->count++] =
            (struct grouping_at){ overlap, scene->facts.grouping, scene->splats.group,
                                  scene->version.groups };
    else
        show(scene, &groupings->before);
    return result;
}

void groupings_end(struct groupings *groupings, bool keep)
{
    struct stp_scene *scene = groupings->scene;
    const uint8_t *shown = keep && scene ? scene->splats.group : NULL;
    for (unsigned i = 0; i < groupings->count; i++)
        if (groupings->at[i].group != shown)
            mem_free(groupings->at[i].group);
    if (shown && shown != groupings->before.group)
        mem_free(groupings->before.group);
    else if (scene)
        show(scene, &groupings->before);
    *groupings = (struct groupings){ 0 };
}
