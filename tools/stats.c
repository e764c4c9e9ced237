/* What --stats writes. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <sys/resource.h>

#include "cli.h"

static cJSON *add_object(cJSON *parent, const char *key)
{
    return cJSON_AddObjectToObject(parent, key);
}

static void add_build(cJSON *stats)
{
    cJSON *build = add_object(stats, "build");
    cJSON_AddStringToObject(build, "version", stp_version());
    cJSON_AddStringToObject(build, "type", STP_BUILD_TYPE);
    cJSON_AddStringToObject(build, "compiler", STP_COMPILER);
}

static void add_grouping(cJSON *stats, const struct stp_grouping *grouping)
{
    cJSON_AddNumberToObject(stats, "groups", grouping->groups);
    cJSON *object = add_object(stats, "grouping");
    cJSON_AddNumberToObject(object, "ms", grouping->milliseconds);
    cJSON_AddNumberToObject(object, "K", grouping->groups);
    cJSON_AddNumberToObject(object, "overlap", grouping->overlap);
    cJSON_AddNumberToObject(object, "max_degree", grouping->max_degree);
    cJSON_AddNumberToObject(object, "avg_degree", grouping->avg_degree);
    cJSON_AddNumberToObject(object, "duplicates", 0); /* no splat is in two groups */
    cJSON_AddArrayToObject(object, "coverage");       /* empty: not measured */
}

static void add_passes(cJSON *stats, const struct stp_render_stats *render)
{
    cJSON *passes = cJSON_AddArrayToObject(stats, "passes");
    for (unsigned i = 0; i < render->pass_count; i++) {
        cJSON *pass = cJSON_CreateObject();
        cJSON_AddStringToObject(pass, "name", render->pass[i].name);
        cJSON_AddNumberToObject(pass, "ms", render->pass[i].milliseconds);
        cJSON_AddItemToArray(passes, pass);
    }
}

static void add_times(cJSON *stats, const struct stp_render_stats *render,
                      const struct run_times *times)
{
    cJSON *frame = add_object(stats, "frame_ms");
    cJSON_AddNumberToObject(frame, "min", render->frame_ms_min);
    cJSON_AddNumberToObject(frame, "median", render->frame_ms_median);
    cJSON_AddNumberToObject(frame, "max", render->frame_ms_max);
    cJSON *cold = add_object(stats, "cold_ms");
    cJSON_AddNumberToObject(cold, "load", times->load);
    cJSON_AddNumberToObject(cold, "prepare", times->prepare);
    cJSON_AddNumberToObject(cold, "upload", render->upload_ms);
    cJSON_AddNumberToObject(cold, "first_frame", render->first_frame_ms);
    cJSON_AddNumberToObject(cold, "write", times->write);
}

static void add_bytes(cJSON *stats, const struct stp_render_stats *render)
{
    struct rusage usage = { 0 };
    getrusage(RUSAGE_SELF, &usage);
    cJSON *bytes = add_object(stats, "bytes");
    cJSON_AddNumberToObject(bytes, "scene", (double)render->bytes_scene);
    cJSON_AddNumberToObject(bytes, "transient", (double)render->bytes_transient);
    cJSON_AddNumberToObject(bytes, "peak", (double)render->bytes_peak);
    cJSON_AddNumberToObject(stats, "peak_rss", (double)usage.ru_maxrss * 1024);
}

/* NULL when the plan's text could not be had, as cJSON's own failures are. */
static void *add_plan(cJSON *stats, const struct stp_plan *plan)
{
    char *text = stp_plan_print(plan);
    void *added = text ? cJSON_AddStringToObject(stats, "plan", text) : NULL;
    free(text);
    return added;
}

cJSON *stats_object(const struct stp_limits *limits, const struct stp_facts *facts,
                    const struct stp_plan *plan, const struct stp_render_stats *render,
                    const struct run_times *times)
{
    struct stp_plan_summary summary;
    stp_plan_summarize(plan, &summary);
    cJSON *stats = cJSON_CreateObject();
    add_build(stats);
    cJSON_AddStringToObject(stats, "device", limits ? limits->device : "none");
    cJSON_AddStringToObject(stats, "driver", limits ? limits->driver : "none");
    cJSON_AddNumberToObject(stats, "points", (double)facts->points);
    cJSON_AddNumberToObject(stats, "splats", (double)facts->splats);
    cJSON_AddNumberToObject(stats, "splats_drawn", (double)render->splats_drawn);
    add_grouping(stats, &facts->grouping);
    cJSON_AddStringToObject(stats, "method", stp_method_name(summary.method));
    cJSON_AddStringToObject(stats, "path", stp_path_name(summary.path));
    add_passes(stats, render);
    add_times(stats, render, times);
    add_bytes(stats, render);
    if (add_plan(stats, plan))
        return stats;
    cJSON_Delete(stats);
    return NULL;
}
