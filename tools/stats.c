/* What --stats writes. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <sys/resource.h>

#include "cli.h"

static void add_build(struct json_out *out, cJSON *stats)
{
    cJSON *build = json_object(out, stats, "build");
    json_text(out, build, "version", stp_version());
    json_text(out, build, "type", STP_BUILD_TYPE);
    json_text(out, build, "compiler", STP_COMPILER);
}

static void add_grouping(struct json_out *out, cJSON *stats, const struct stp_grouping *grouping)
{
    json_number(out, stats, "groups", grouping->groups);
    cJSON *object = json_object(out, stats, "grouping");
    json_number(out, object, "ms", grouping->milliseconds);
    json_number(out, object, "K", grouping->groups);
    json_number(out, object, "overlap", grouping->overlap);
    json_number(out, object, "max_degree", grouping->max_degree);
    json_number(out, object, "avg_degree", grouping->avg_degree);
    json_number(out, object, "duplicates", 0); /* no splat is in two groups */
    json_array(out, object, "coverage");       /* empty: not measured */
}

/* In its place, where the groups each cover the surface. */
static void add_cover(struct json_out *out, cJSON *stats, const struct stp_cover *cover)
{
    json_number(out, stats, "groups", cover->groups);
    cJSON *object = json_object(out, stats, "grouping");
    json_number(out, object, "ms", cover->milliseconds);
    json_number(out, object, "K", cover->groups);
    json_number(out, object, "duplicates", cover->duplicates);
    json_number(out, object, "error", cover->error);
    int count = (int)cover->groups;
    json_numbers(out, object, "before", cover->before, count);
    json_numbers(out, object, "coverage", cover->coverage, count);
    json_numbers(out, object, "factor", cover->factor, count);
}

static void add_passes(struct json_out *out, cJSON *stats, const struct stp_render_stats *render)
{
    cJSON *passes = json_array(out, stats, "passes");
    for (unsigned i = 0; i < render->pass_count; i++) {
        cJSON *pass = json_object(out, passes, NULL);
        json_text(out, pass, "name", render->pass[i].name);
        json_number(out, pass, "ms", render->pass[i].milliseconds);
    }
}

static void add_times(struct json_out *out, cJSON *stats, const struct stp_render_stats *render,
                      const struct run_times *times)
{
    cJSON *frame = json_object(out, stats, "frame_ms");
    json_number(out, frame, "min", render->frame_ms_min);
    json_number(out, frame, "median", render->frame_ms_median);
    json_number(out, frame, "max", render->frame_ms_max);
    cJSON *cold = json_object(out, stats, "cold_ms");
    json_number(out, cold, "load", times->load);
    json_number(out, cold, "prepare", times->prepare);
    json_number(out, cold, "upload", render->upload_ms);
    json_number(out, cold, "first_frame", render->first_frame_ms);
    json_number(out, cold, "write", times->write);
}

static void add_bytes(struct json_out *out, cJSON *stats, const struct stp_render_stats *render)
{
    struct rusage usage = { 0 };
    getrusage(RUSAGE_SELF, &usage);
    cJSON *bytes = json_object(out, stats, "bytes");
    json_number(out, bytes, "scene", (double)render->bytes_scene);
    json_number(out, bytes, "transient", (double)render->bytes_transient);
    json_number(out, bytes, "peak", (double)render->bytes_peak);
    json_number(out, stats, "peak_rss", (double)usage.ru_maxrss * 1024);
}

/* Of a channel that --aov asked for: the most of a pixel, and the mean over what is covered. */
static void add_plane(struct json_out *out, cJSON *stats, const struct stp_image *image,
                      const char *name)
{
    const struct stp_channel *channel = image ? stp_image_find(image, name) : NULL;
    double most = 0, sum = 0, covered = 0;
    if (!channel)
        return;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++) {
        double value = (double)channel->data.f[i];
        most = fmax(most, value);
        sum += value;
        covered += value > 0;
    }
    cJSON *object = json_object(out, stats, name);
    json_number(out, object, "max", most);
    json_number(out, object, "mean", covered > 0 ? sum / covered : 0);
}

static void add_plan(struct json_out *out, cJSON *stats, const struct stp_plan *plan)
{
    char *text = stp_plan_print(plan);
    json_text(out, stats, "plan", text ? text : "");
    out->failed |= !text;
    free(text);
}

void stats_add(struct json_out *out, cJSON *list, const struct stp_limits *limits,
               const struct stp_facts *facts, const struct stp_plan *plan,
               const struct stp_render_stats *render, const struct run_times *times,
               const struct stp_image *image)
{
    struct stp_plan_summary summary;
    stp_plan_summarize(plan, &summary);
    cJSON *stats = json_object(out, list, NULL);
    add_build(out, stats);
    json_text(out, stats, "device", limits ? limits->device : "none");
    json_text(out, stats, "driver", limits ? limits->driver : "none");
    json_number(out, stats, "points", (double)facts->points);
    json_number(out, stats, "splats", (double)facts->splats);
    json_number(out, stats, "splats_drawn",
                render->splats_drawn ? (double)render->splats_drawn : NAN); /* null */
    if (facts->cover.groups)
        add_cover(out, stats, &facts->cover);
    else
        add_grouping(out, stats, &facts->grouping);
    json_text(out, stats, "method", stp_method_name(summary.method));
    json_text(out, stats, "path", stp_path_name(summary.path));
    add_passes(out, stats, render);
    add_times(out, stats, render, times);
    add_bytes(out, stats, render);
    add_plane(out, stats, image, "layers");
    add_plane(out, stats, image, "fragments");
    add_plan(out, stats, plan);
}
