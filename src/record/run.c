/* Frames of a plan: once, again, timed, and timed pass by pass. */
#include "record/record.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, unsigned count)
{
    qsort(values, count, sizeof *values, by_value);
    return count % 2 ? values[count / 2] : (values[count / 2 - 1] + values[count / 2]) / 2;
}

static enum stp_result run_part(const struct stp_env *env, struct record_frame *frame,
                                const struct plan_tile *tile, uint32_t part, bool timed)
{
    enum stp_result result = gpu_begin(env, frame->context);
    if (result != STP_OK)
        return result;
    record_walk(frame, frame->context->commands, tile, part, timed, RECORD_NO_PASS);
    return gpu_submit_and_wait(env, frame->context);
}

static enum stp_result add_timestamps(const struct stp_env *env, struct record_frame *frame,
                                      uint32_t part, double *ms)
{
    struct stp_context *c = frame->context;
    struct record_steps steps = record_steps(frame->plan, part);
    uint64_t ticks[RECORD_MAX_STEPS + 1];
    VkResult status = c->vk.vkGetQueryPoolResults(
        c->device, frame->queries, 0, steps.count + 1, sizeof ticks, ticks, sizeof *ticks,
        VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkGetQueryPoolResults");
    for (uint32_t i = 0; i < steps.count; i++) {
        uint32_t sample, pass = record_step(&steps, i, &sample);
        ms[pass] += (double)((ticks[i + 1] - ticks[i]) & c->timestamp_mask) * c->timestamp_ms;
    }
    return STP_OK;
}

/* Has the part that ran last left rays unfinished? */
static enum stp_result read_remaining(const struct stp_env *env, struct record_frame *frame,
                                      bool *remaining)
{
    struct stp_context *c = frame->context;
    *remaining = false;
    if (!frame->plan->loop_first)
        return STP_OK;
    VkMappedMemoryRange range = { .sType = VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE,
                                  .memory = frame->remaining.memory.where.memory,
                                  .size = VK_WHOLE_SIZE };
    VkResult status = frame->remaining.coherent
                          ? VK_SUCCESS
                          : c->vk.vkInvalidateMappedMemoryRanges(c->device, 1, &range);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "vkInvalidateMappedMemoryRanges");
    *remaining = *(const uint32_t *)frame->remaining.mapped != 0;
    return STP_OK;
}

/* The exchange that comes after a part, where there is one; collective. */
static enum stp_result exchange(const struct stp_env *env, struct record_frame *frame,
                                const struct stp_scene *scene, uint32_t part, double *pass_ms,
                                enum stp_result result)
{
    struct record_steps steps = record_steps(frame->plan, part);
    if (steps.exchange == RECORD_NO_PASS)
        return result;
    double start = clock_ms();
    result = record_exchange(env, frame, scene, &frame->plan->pass[steps.exchange],
                             steps.first_sample, result);
    if (pass_ms)
        pass_ms[steps.exchange] += clock_ms() - start;
    return result;
}

/* All parts of a tile; adds the passes' times where pass_ms is not NULL. */
static enum stp_result run_tile(const struct stp_env *env, struct record_frame *frame,
                                const struct stp_scene *scene, const struct plan_tile *tile,
                                double *pass_ms)
{
    uint32_t parts = record_parts(frame->plan);
    enum stp_result result = STP_OK;
    bool remaining = false;
    for (uint32_t part = 0; result == STP_OK && part < parts;) {
        bool loops = record_steps(frame->plan, part).loops;
        /* Later windows are of rays that are not mended: those are done with the first. */
        if (loops && (!remaining || (frame->deep && frame->deep->first > 0))) {
            part++;
            continue;
        }
        if (frame->plan->chunk_count)
            result = record_upload_chunk(env, frame, scene, record_steps(frame->plan, part).chunk);
        if (result == STP_OK)
            result = run_part(env, frame, tile, part, pass_ms != NULL);
        if (result == STP_OK && pass_ms)
            result = add_timestamps(env, frame, part, pass_ms);
        if (frame->share)
            result = exchange(env, frame, scene, part, pass_ms, result);
        if (result == STP_OK)
            result = read_remaining(env, frame, &remaining);
        if (result == STP_OK && frame->deep)
            result = record_deep_take(env, frame, tile, loops);
        part += !loops;
        if (frame->plan->chunk_count && !pass_ms)
            log_progress(env, "render",
                         ((double)(tile - frame->plan->tile) + (double)part / parts) /
                             frame->plan->tile_count);
    }
    return result;
}

/* The windows of a tile's layers behind the first; the picture has been read. */
static enum stp_result run_windows(const struct stp_env *env, struct record_frame *frame,
                                   const struct stp_scene *scene, const struct plan_tile *tile)
{
    enum stp_result result = STP_OK;
    while (result == STP_OK && record_deep_next(frame->deep))
        result = run_tile(env, frame, scene, tile, NULL);
    return result;
}

enum stp_result record_run(const struct stp_env *env, struct record_frame *frame,
                           const struct stp_scene *scene, struct stp_image *image, double *ms,
                           double *read_back_ms)
{
    const struct stp_plan *plan = frame->plan;
    double begin = clock_ms();
    enum stp_result ordered = record_order(env, frame, scene);
    if (ordered != STP_OK)
        return ordered;
    *ms = clock_ms() - begin;
    *read_back_ms = 0;
    for (uint32_t i = 0; i < plan->tile_count; i++) {
        double start = clock_ms();
        if (frame->deep)
            record_deep_begin(frame->deep, &plan->tile[i]);
        enum stp_result result = run_tile(env, frame, scene, &plan->tile[i], NULL);
        if (result != STP_OK)
            return result;
        double end = clock_ms();
        *ms += end - start;
        if (image) {
            result = record_read_back(env, frame, scene, &plan->tile[i], image);
            if (result == STP_OK && frame->deep)
                result = run_windows(env, frame, scene, &plan->tile[i]);
            if (result != STP_OK)
                return result;
            *read_back_ms += clock_ms() - end;
            log_progress(env, "render", (i + 1.0) / plan->tile_count);
        }
    }
    return STP_OK;
}

enum stp_result record_again(const struct stp_env *env, struct record_frame *frame,
                             const struct stp_scene *scene, double *ms)
{
    double unused, start = clock_ms();
    enum stp_result result = record_view(env, frame, scene);
    double view = clock_ms() - start;
    if (result == STP_OK)
        result = record_run(env, frame, scene, NULL, ms, &unused);
    if (result == STP_OK)
        *ms += view;
    return result;
}

/* What a view takes of the CPU, as a pass besides the others. */
static enum stp_result profile_view(const struct stp_env *env, struct record_frame *frame,
                                    const struct stp_scene *scene, struct stp_render_stats *stats)
{
    double ms[RECORD_PROFILED];
    bool axis = frame->plan->method == STP_METHOD_AXIS;
    if (!(axis || plan_covers(frame->plan)) || stats->pass_count == STP_MAX_PASSES)
        return STP_OK;
    for (unsigned f = 0; f < RECORD_PROFILED; f++) {
        double start = clock_ms();
        enum stp_result result =
            axis ? record_view(env, frame, scene) : record_order(env, frame, scene);
        if (result != STP_OK)
            return result;
        ms[f] = clock_ms() - start;
    }
    struct stp_pass_time *pass = &stats->pass[stats->pass_count++];
    snprintf(pass->name, sizeof pass->name, "%s, on the CPU", axis ? "lists" : "order");
    pass->milliseconds = median(ms, RECORD_PROFILED);
    return STP_OK;
}

/* Frames with a timestamp and a full barrier after every pass: the medians. */
enum stp_result record_profile(const struct stp_env *env, struct record_frame *frame,
                               const struct stp_scene *scene, unsigned frames,
                               struct stp_render_stats *stats)
{
    const struct stp_plan *plan = frame->plan;
    double ms[RECORD_PROFILED][PLAN_MAX_PASSES] = { 0 }, column[RECORD_PROFILED];
    if (!frame->queries)
        return STP_OK;
    for (unsigned f = 0; f < frames; f++) {
        for (uint32_t t = 0; t < plan->tile_count; t++) {
            enum stp_result result = run_tile(env, frame, scene, &plan->tile[t], ms[f]);
            if (result != STP_OK)
                return result;
        }
    }
    stats->pass_count = plan->pass_count;
    for (uint32_t i = 0; i < plan->pass_count; i++) {
        for (unsigned f = 0; f < frames; f++)
            column[f] = ms[f][i];
        memcpy(stats->pass[i].name, plan->pass[i].name, sizeof plan->pass[i].name);
        stats->pass[i].milliseconds = median(column, frames);
    }
    return profile_view(env, frame, scene, stats);
}

enum stp_result record_time(const struct stp_env *env, struct record_frame *frame,
                            const struct stp_scene *scene, unsigned repeat,
                            struct stp_render_stats *stats)
{
    double *ms = mem_alloc(repeat, sizeof *ms);
    enum stp_result result = ms ? STP_OK : log_no_memory(env, repeat * sizeof *ms, "times");
    for (unsigned i = 0; result == STP_OK && i < repeat; i++)
        result = record_again(env, frame, scene, &ms[i]);
    if (result == STP_OK) {
        stats->frames = repeat;
        stats->frame_ms_median = median(ms, repeat);
        stats->frame_ms_min = ms[0];
        stats->frame_ms_max = ms[repeat - 1];
        result = record_profile(env, frame, scene,
                                repeat < RECORD_PROFILED ? repeat : RECORD_PROFILED, stats);
    }
    mem_free(ms);
    return result;
}
