/* Error against the number of samples: a reduced picture, where splats are small against pixels,
 * beside the reference's own picture of many samples. */
#include "study/study.h"

#include "base/log.h"
#include "base/memory.h"
#include "reference/reference.h"
#include "scene/camera_json.h"
#include "scene/scene.h"

#define SIDE       192 /* pixels of the longer one, at most */
#define QUICK_SIDE 128
#define TIMED      3

/* The same view in fewer pixels. */
static struct stp_camera reduced(const struct study *study)
{
    struct stp_camera camera = *study->camera;
    uint32_t most = study->params.quick ? QUICK_SIDE : SIDE;
    uint32_t side = camera.width > camera.height ? camera.width : camera.height;
    if (side <= most)
        return camera;
    double scale = (double)most / side;
    uint32_t width = (uint32_t)(camera.width * scale + 0.5);
    uint32_t height = (uint32_t)(camera.height * scale + 0.5);
    camera_resize(&camera, true, width ? width : 1, height ? height : 1);
    return camera;
}

static struct stp_render_params params_of(const struct study *study, enum stp_method method,
                                          unsigned samples)
{
    struct stp_render_params params = study->params.render;
    params.method = method;
    params.samples = samples;
    params.aovs = 0;
    return params;
}

static enum stp_result time_and_compare(struct study *study, struct record_frame *frame,
                                        const struct stp_image *truth, struct stp_image *image,
                                        struct report_samples *row)
{
    struct stp_compare_params compare = { .epsilon = study->epsilon,
                                          .exposure = study->params.exposure };
    double ms[TIMED], unused;
    enum stp_result result =
        record_run(&study->quiet, frame, study->scene, image, &unused, &unused);
    if (result == STP_OK)
        result = stp_compare(&study->quiet, image, truth, &compare, &row->error);
    for (unsigned i = 0; result == STP_OK && i < TIMED; i++)
        result = record_run(&study->quiet, frame, study->scene, NULL, &ms[i], &unused);
    if (result == STP_OK)
        row->ms = report_times(ms, TIMED);
    return result;
}

static enum stp_result measure(struct study *study, const struct stp_plan *plan,
                               const struct stp_image *truth, struct report_samples *row)
{
    struct record_frame frame;
    struct stp_image *image = NULL;
    enum stp_result result = record_frame_create(&study->quiet, study->context, plan, &frame);
    if (result != STP_OK)
        return result;
    result = record_upload(&study->quiet, &frame, study->scene);
    if (result == STP_OK)
        result = record_picture(&study->quiet, plan, &image);
    if (result == STP_OK)
        result = time_and_compare(study, &frame, truth, image, row);
    stp_image_destroy(&image);
    record_frame_destroy(&frame);
    return result;
}

static enum stp_result add(struct study *study, const struct stp_camera *camera,
                           const struct stp_image *truth, unsigned samples)
{
    struct report *report = &study->report;
    struct report_samples *row = &report->samples[report->samples_count];
    struct stp_render_params params = params_of(study, STP_METHOD_EXACT, samples);
    struct stp_plan *plan = NULL;
    enum stp_result result = stp_plan_create(&study->quiet, study->scene, camera, &params,
                                             stp_context_limits(study->context), &plan);
    if (result != STP_OK)
        return result;
    row->count = samples;
    result = measure(study, plan, truth, row);
    stp_plan_destroy(&plan);
    report->samples_count += result == STP_OK;
    return result;
}

enum stp_result study_samples(struct study *study)
{
    static const unsigned all[] = { 1, 4, 9, 16, 36, 64 }, quick[] = { 1, 4, 16 };
    const unsigned *samples = study->params.quick ? quick : all;
    unsigned count = study->params.quick ? sizeof quick / sizeof *quick : sizeof all / sizeof *all;
    if (!study->has_exact)
        return STP_OK;
    struct stp_camera camera = reduced(study);
    unsigned most = study->params.quick ? 64 : 256;
    struct stp_render_params params = params_of(study, STP_METHOD_REFERENCE, most);
    struct stp_image *truth = NULL;
    study->report.samples_truth = most;
    study->report.samples_width = camera.width;
    study->report.samples_height = camera.height;
    enum stp_result result =
        reference_render(&study->quiet, study->scene, &camera, &params, &truth);
    for (unsigned i = 0; result == STP_OK && i < count; i++) {
        result = add(study, &camera, truth, samples[i]);
        log_progress(study->env, "samples", (i + 1.0) / count);
    }
    stp_image_destroy(&truth);
    return result;
}
