/* Is a plan for the scene that it meets? Its buffers have the sizes of what it was made of. */
#include "plan/plan.h"

#include "base/log.h"
#include "scene/scene.h"

const char *plan_differs(const struct stp_plan *plan, const struct scene_version *version)
{
    const struct scene_version *own = &plan->version;
    bool covers = plan_covers(plan);
    bool grouped = plan->method == STP_METHOD_DEFERRED && !covers;
    if (own->scene != version->scene)
        return "scene";
    if (own->content != version->content)
        return "content";
    if (grouped && own->groups != version->groups)
        return "grouping";
    return covers && own->cover != version->cover ? "cover" : NULL;
}

enum stp_result plan_check_scene(const struct stp_env *env, const struct stp_plan *plan,
                                 const struct stp_scene *scene)
{
    const char *what = plan_differs(plan, &scene->version);
    if (!what)
        return STP_OK;
    return log_error(env, STP_ERROR_ARGUMENT,
                     "the plan was made of another %s than the scene now has: make it again", what);
}
