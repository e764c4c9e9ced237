#include "device.h"

#include "record/record.h"

static void keep_line(void *user, enum stp_log_level level, const char *line)
{
    struct device *device = user;
    if (level == STP_LOG_INFO)
        return;
    device->lines++;
    snprintf(device->last, sizeof device->last, "%s", line);
}

void device_open(struct device *device, unsigned mask_features)
{
    struct stp_context_params params = { .validate = true, .mask_features = mask_features };
    *device = (struct device){ .env = { .threads = 2, .log = keep_line, .user = device } };
    enum stp_result result = stp_context_create(&device->env, &params, &device->context);
    if (result != STP_OK)
        fail_msg("no validated device (%s): %s", stp_result_text(result), device->last);
}

void device_close(struct device *device)
{
    unsigned messages = stp_context_messages(device->context);
    if (messages)
        fail_msg("%u validation messages, the last: %s", messages, device->last);
    stp_context_destroy(&device->context);
}

enum stp_result device_plan(struct device *device, const struct stp_scene *scene,
                            const struct stp_camera *camera, const struct stp_render_params *params,
                            struct stp_plan **plan)
{
    return stp_plan_create(&device->env, scene, camera, params, stp_context_limits(device->context),
                           plan);
}

struct stp_image *device_render_plan(struct device *device, const struct stp_scene *scene,
                                     const struct stp_plan *plan)
{
    struct stp_image *image = NULL;
    unsigned lines = device->lines;
    enum stp_result result =
        stp_render(&device->env, device->context, scene, plan, 0, &image, NULL);
    if (result != STP_OK || device->lines != lines)
        fail_msg("%s by %s: %s: %s", stp_method_name(plan->method), stp_path_name(plan->path),
                 stp_result_text(result), device->last);
    return image;
}

struct stp_image *device_render(struct device *device, const struct stp_scene *scene,
                                const struct stp_camera *camera,
                                const struct stp_render_params *params)
{
    struct stp_plan *plan = NULL;
    enum stp_result result = device_plan(device, scene, camera, params, &plan);
    if (result != STP_OK)
        fail_msg("no plan: %s", device->last);
    struct stp_image *image = device_render_plan(device, scene, plan);
    stp_plan_destroy(&plan);
    return image;
}
