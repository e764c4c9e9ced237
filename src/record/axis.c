#include "record/record.h"

#include "base/log.h"
#include "prepare/axis_region.h"

enum stp_result record_lists(const struct stp_env *env, struct record_frame *frame,
                             const struct axis_lists *lists, const struct axis_blocks *blocks)
{
    const struct stp_plan *plan = frame->plan;
    bool by_raster = plan->path == STP_PATH_RASTER;
    uint8_t order = plan_find(plan, PLAN_ORDER), starts = plan_find(plan, PLAN_COUNTS);
    enum stp_result result = STP_OK;
    if (order != PLAN_NONE)
        result = gpu_upload(env, frame->context, &frame->resources.buffer[order],
                            by_raster ? lists->order : blocks->entry, plan->resource[order].bytes);
    if (result == STP_OK && starts != PLAN_NONE)
        result = gpu_upload(env, frame->context, &frame->resources.buffer[starts], blocks->first,
                            plan->resource[starts].bytes);
    return result;
}

/* The view's blocks: where the host may write to device memory, straight into it. */
static enum stp_result record_blocks(const struct stp_env *env, struct record_frame *frame)
{
    const struct stp_plan *plan = frame->plan;
    struct axis_blocks *blocks = &frame->axis_blocks;
    struct gpu_buffer *order = &frame->resources.buffer[plan_find(plan, PLAN_ORDER)];
    uint32_t *view = gpu_view(order);
    if (!view) {
        enum stp_result result = axis_blocks_update(env, &frame->axis, blocks);
        return result == STP_OK ? record_lists(env, frame, &frame->axis, blocks) : result;
    }
    enum stp_result result = axis_blocks_count(env, &frame->axis, blocks);
    if (result != STP_OK)
        return result;
    if (blocks->count * sizeof *view > plan->resource[plan_find(plan, PLAN_ORDER)].bytes)
        return log_error(env, STP_ERROR_ARGUMENT, "the scene is not the one that was planned");
    uint8_t starts = plan_find(plan, PLAN_COUNTS);
    axis_blocks_fill(env, &frame->axis, blocks, view);
    return gpu_upload(env, frame->context, &frame->resources.buffer[starts], blocks->first,
                      plan->resource[starts].bytes);
}

enum stp_result record_view(const struct stp_env *env, struct record_frame *frame,
                            const struct stp_scene *scene)
{
    const struct stp_plan *plan = frame->plan;
    if (plan->method != STP_METHOD_AXIS || !plan->axis.count)
        return STP_OK;
    frame->axis.merge = plan->axis.merge;
    frame->axis.h = plan->axis.h;
    frame->axis.look = plan->axis.look;
    enum stp_result result = axis_lists_update(env, scene, &plan->camera, &frame->axis);
    if (result == STP_OK &&
        plan->constant[PLAN_AXIS_SHAPE] == AXIS_ELLIPSOIDS) /* the view weights */
        result = upload_ellipsoids(env, frame, scene,
                                   &frame->resources.buffer[plan_find(plan, PLAN_SPLATS)]);
    if (result != STP_OK)
        return result;
    return plan->path == STP_PATH_COMPUTE ? record_blocks(env, frame)
                                          : record_lists(env, frame, &frame->axis, NULL);
}
