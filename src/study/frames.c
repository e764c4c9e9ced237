#include "study/study.h"

#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

#define TIMED 3 /* frames of a visit */

/* Frames of a software device share the host's memory with everything else. */
uint64_t study_budget(const struct stp_context *context)
{
    const struct stp_limits *limits = stp_context_limits(context);
    if (limits->processor != STP_PROCESSOR_CPU)
        return limits->heap_bytes / 2;
    long pages = sysconf(_SC_AVPHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (uint64_t)pages * (uint64_t)size / 2 : limits->heap_bytes / 2;
}

static uint64_t bytes_of(const struct study_frame *frame)
{
    return plan_bytes(frame->plan, PLAN_SCENE) + plan_bytes(frame->plan, PLAN_TRANSIENT) +
           plan_bytes(frame->plan, PLAN_OUTPUT);
}

void study_frame_sleep(struct study *study, struct study_frame *frame)
{
    if (!frame->alive)
        return;
    record_frame_destroy(&frame->frame);
    frame->alive = false;
    study->held -= bytes_of(frame);
}

static struct study_frame *least_recent(struct study *study)
{
    struct study_frame *found = NULL;
    for (unsigned i = 0; i < study->frame_count; i++) {
        struct study_frame *frame = &study->frame[i];
        if (frame->alive && (!found || frame->used < found->used))
            found = frame;
    }
    return found;
}

/* Makes the frame's resources if they are not there, taking away those least recently used when the
 * budget is spent. */
static enum stp_result wake(struct study *study, struct study_frame *frame)
{
    frame->used = ++study->turn;
    if (frame->alive)
        return STP_OK;
    struct study_frame *old;
    while (study->held + bytes_of(frame) > study->budget && (old = least_recent(study)))
        study_frame_sleep(study, old);
    enum stp_result result = STP_OK;
    if (frame->config.overlap > 0)
        result = groupings_use(&study->quiet, &study->groups, &study->params.group,
                               frame->config.overlap);
    if (result == STP_OK)
        result = record_frame_create(&study->quiet, study->context, frame->plan, &frame->frame);
    if (result != STP_OK)
        return result;
    frame->alive = true;
    study->held += bytes_of(frame);
    return record_upload(&study->quiet, &frame->frame, study->scene);
}

static enum stp_result run(struct study *study, struct study_frame *frame, struct stp_image *image,
                           double *ms)
{
    double unused;
    return image ? record_run(&study->quiet, &frame->frame, study->scene, image, ms, &unused)
                 : record_again(&study->quiet, &frame->frame, study->scene, ms);
}

static enum stp_result measure(struct study *study, struct study_frame *frame,
                               struct report_row *row)
{
    struct stp_compare_params params = { .epsilon = study->epsilon,
                                         .exposure = study->params.exposure };
    struct stp_image *image = NULL;
    double unused;
    enum stp_result result = record_picture(&study->quiet, frame->plan, &image);
    if (result == STP_OK)
        result = run(study, frame, image, &unused);
    if (result == STP_OK)
        result = stp_compare(&study->quiet, image, study->reference, &params, &row->error);
    if (result == STP_OK)
        result = heat_measure(&study->quiet, image, study->reference, &frame->heat);
    stp_image_destroy(&image);
    return result;
}

static enum stp_result visit(struct study *study, unsigned index)
{
    struct study_frame *frame = &study->frame[index];
    double unused;
    enum stp_result result = wake(study, frame);
    if (result == STP_OK && frame->count == 0)
        result = measure(study, frame, &study->report.row[index]);
    if (result == STP_OK)
        result = run(study, frame, NULL, &unused);
    for (unsigned i = 0; result == STP_OK && i < TIMED; i++)
        result = run(study, frame, NULL, &frame->ms[frame->count++]);
    return result;
}

/* Another order each round: no frame always follows the same one. */
static void shuffle(unsigned *order, unsigned count, unsigned round)
{
    uint32_t state = 0x9e3779b9u * (round + 1);
    for (unsigned i = 0; i < count; i++)
        order[i] = i;
    for (unsigned i = count; i > 1; i--) {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        unsigned k = state % i, kept = order[i - 1];
        order[i - 1] = order[k];
        order[k] = kept;
    }
}

static enum stp_result make_room(struct study *study)
{
    for (unsigned i = 0; i < study->frame_count; i++) {
        study->frame[i].ms = mem_alloc((size_t)study->report.rounds * TIMED, sizeof(double));
        if (!study->frame[i].ms)
            return log_no_memory(study->env, study->report.rounds * TIMED * sizeof(double),
                                 "times");
    }
    return STP_OK;
}

static void summarise(struct study *study)
{
    for (unsigned i = 0; i < study->frame_count; i++)
        study->report.row[i].ms = report_times(study->frame[i].ms, study->frame[i].count);
}

/* What the first round found outclassed takes most of a sweep's time and is seen no more. */
static void leave_out(struct study *study)
{
    for (unsigned i = 0; i < study->frame_count; i++)
        study->frame[i].done = report_outclassed(&study->report, &study->report.row[i]);
}

enum stp_result study_time(struct study *study)
{
    unsigned order[STUDY_MAX_CONFIGS + REPORT_MAX_PICKS], rounds = study->report.rounds,
                                                          count = study->frame_count;
    enum stp_result result = make_room(study);
    for (unsigned round = 0; result == STP_OK && round < rounds; round++) {
        shuffle(order, count, round);
        for (unsigned i = 0; result == STP_OK && i < count; i++) {
            if (!study->frame[order[i]].done)
                result = visit(study, order[i]);
            log_progress(study->env, "report", (round * count + i + 1.0) / (rounds * count));
        }
        if (result == STP_OK)
            summarise(study);
        if (result == STP_OK && round == 0)
            leave_out(study);
    }
    return result;
}

enum stp_result study_profile(struct study *study)
{
    struct stp_render_stats stats;
    enum stp_result result = STP_OK;
    for (unsigned i = 0; result == STP_OK && i < study->frame_count; i++) {
        struct report_row *row = &study->report.row[i];
        if (!row->on_front && study->frame[i].config.method != STP_METHOD_TWO_PASS)
            continue;
        stats = (struct stp_render_stats){ 0 };
        result = wake(study, &study->frame[i]);
        if (result == STP_OK)
            result = record_profile(&study->quiet, &study->frame[i].frame, study->scene,
                                    RECORD_PROFILED, &stats);
        for (unsigned k = 0; k < stats.pass_count && k < STP_MAX_PASSES; k++)
            row->pass[k] = stats.pass[k];
    }
    return result;
}
