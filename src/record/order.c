/* The order of the splats in a frame: back to front, for the plans that blend. */
#include "record/record.h"

#include "base/log.h"
#include "base/memory.h"
#include "prepare/deferred_bsp.h"
#include "scene/scene.h"

/* Relative to the splats' origin; of an orthographic camera, against the view. */
static void eye_of(const struct stp_camera *camera, const double origin[3], double eye[4])
{
    const double *m = camera->world_to_camera;
    for (int a = 0; a < 3; a++) {
        eye[a] = -(m[a] * m[3] + m[4 + a] * m[7] + m[8 + a] * m[11]) - origin[a];
        if (camera->orthographic)
            eye[a] = m[8 + a]; /* the camera looks along -row 2 */
    }
    eye[3] = camera->orthographic ? 0 : 1;
}

enum stp_result record_order(const struct stp_env *env, struct record_frame *frame,
                             const struct stp_scene *scene)
{
    const struct stp_plan *plan = frame->plan;
    if (!plan_covers(plan))
        return STP_OK;
    struct gpu_buffer *buffer = &frame->resources.buffer[plan_find(plan, PLAN_ORDER)];
    size_t members = scene->cover.first[scene->cover.groups];
    double eye[4];
    eye_of(&plan->camera, scene->splats.origin, eye);
    uint32_t *order = gpu_fill_begin(env, buffer, members, sizeof *order, "the order of splats");
    if (!order)
        return STP_ERROR_MEMORY;
    enum stp_result result = bsp_order(env, &scene->cover, eye, order);
    if (result == STP_OK)
        return gpu_fill_end(env, frame->context, buffer, order, members * sizeof *order);
    gpu_fill_drop(buffer, order);
    return result;
}

/* Behind the members that a frame orders: splats by their first groups, in canonical order. */
enum stp_result record_upload_homes(const struct stp_env *env, struct record_frame *frame,
                                    const struct stp_scene *scene, struct gpu_buffer *buffer)
{
    size_t members = scene->cover.first[scene->cover.groups];
    size_t count =
        frame->plan->resource[plan_find(frame->plan, PLAN_ORDER)].bytes / sizeof(uint32_t);
    uint32_t next[STP_MAX_GROUPS], *order = mem_zalloc(count, sizeof *order);
    if (!order)
        return log_no_memory(env, count * sizeof *order, "the order of groups");
    for (unsigned k = 0; k < scene->cover.groups; k++)
        next[k] = (uint32_t)members + frame->plan->group_first[k];
    for (size_t i = 0; i < scene->splats.count; i++) {
        unsigned k = scene->cover.home[i];
        if (k < scene->cover.groups && next[k] < count)
            order[next[k]++] = (uint32_t)i;
    }
    enum stp_result result = gpu_upload(env, frame->context, buffer, order, count * sizeof *order);
    mem_free(order);
    return result;
}
