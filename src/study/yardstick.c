#include "study/yardstick.h"

#include <math.h>

#include "base/log.h"

enum stp_result yardstick_make(const struct stp_env *env, struct stp_context *context,
                               const struct stp_scene *scene, const struct stp_camera *camera,
                               struct yardstick *yardstick)
{
    const struct stp_env silent = { .threads = env->threads, .log = log_nothing };
    struct stp_plan *plan = NULL;
    double unused;
    *yardstick = (struct yardstick){ .scene = scene };
    enum stp_result result = stp_plan_create(&silent, scene, camera, NULL, &context->limits, &plan);
    if (result == STP_ERROR_FEATURE || result == STP_ERROR_ARGUMENT)
        return STP_OK; /* without one */
    bool none = result == STP_OK && plan->method == STP_METHOD_REFERENCE;
    if (result == STP_OK && !none)
        result = record_frame_create(env, context, plan, &yardstick->frame);
    if (result != STP_OK || none) {
        stp_plan_destroy(&plan);
        return result;
    }
    yardstick->plan = plan;
    result = record_upload(env, &yardstick->frame, scene);
    if (result == STP_OK) /* compiles, and touches the memory */
        result = record_run(env, &yardstick->frame, scene, NULL, &unused, &unused);
    return result;
}

enum stp_result yardstick_read(const struct stp_env *env, struct yardstick *yardstick)
{
    enum stp_result result = STP_OK;
    double each, unused;
    if (!yardstick->plan)
        return STP_OK;
    yardstick->ms = INFINITY;
    for (unsigned i = 0; result == STP_OK && i < YARDSTICK_FRAMES; i++) {
        result = record_run(env, &yardstick->frame, yardstick->scene, NULL, &each, &unused);
        yardstick->ms = fmin(yardstick->ms, each);
    }
    return result;
}

void yardstick_release(struct yardstick *yardstick)
{
    if (!yardstick->plan)
        return;
    record_frame_destroy(&yardstick->frame);
    stp_plan_destroy(&yardstick->plan);
    *yardstick = (struct yardstick){ 0 };
}
