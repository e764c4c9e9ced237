/* stipple render: load, prepare, plan, render, write. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

struct run {
    struct settings *settings;
    struct console console;
    struct context_job job;
    struct stp_scene *scene;
    const struct stp_limits *limits; /* NULL: the reference, no device */
    struct run_times times;
    cJSON *stats; /* of each frame, an array; NULL without --stats */
    struct json_out building;
};

/* One frame's products. */
struct frame {
    struct stp_camera camera;
    struct stp_plan *plan;
    struct stp_image *image;
    struct stp_render_stats stats;
};

static double ms_since(double start)
{
    return (seconds_now() - start) * 1e3;
}

/* --- before anything is read ----------------------------------------------------------------- */

static int check_frames(const struct settings *settings)
{
    const struct command *command = settings->command;
    bool frames = option_given(settings, "frames");
    if (frames && !settings->camera)
        return wrong_usage(command, "--frames wants --camera with a camera path");
    if (frames && settings->write_camera)
        return wrong_usage(command, "--write-camera writes one camera; leave out --frames");
    if (frames && settings->output && !pattern_valid(settings->output))
        return wrong_usage(command, "--frames wants one %%d or %%04d in --output '%s'",
                           settings->output);
    if (frames && settings->preview && !pattern_valid(settings->preview))
        return wrong_usage(command, "--frames wants one %%d or %%04d in --preview '%s'",
                           settings->preview);
    return EXIT_DONE;
}

/* The outputs, NULL where not wanted. */
static void list_outputs(const struct settings *settings, const char *paths[4])
{
    paths[0] = settings->output;
    paths[1] = settings->preview;
    paths[2] = settings->stats;
    paths[3] = settings->write_camera;
}

static int check_usage(const struct settings *settings)
{
    const struct command *command = settings->command;
    const char *paths[4];
    if (!settings->output && !settings->preview && !settings->stats)
        return wrong_usage(command, "render wants -o OUT.exr (or --preview, or --stats alone)");
    if (!camera_usage_right(settings))
        return EXIT_COMMAND_LINE;
    list_outputs(settings, paths);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < i; j++)
            if (paths[i] && paths[j] && strcmp(paths[i], paths[j]) == 0)
                return wrong_usage(command, "'%s' is given for two outputs", paths[i]);
    return check_frames(settings);
}

static int check_outputs(struct run *run)
{
    const char *paths[4];
    list_outputs(run->settings, paths);
    for (int i = 0; i < 4; i++)
        if (paths[i] && !output_possible(&run->console, paths[i], run->settings))
            return EXIT_FAILED;
    return EXIT_DONE;
}

/* --- one frame ------------------------------------------------------------------------------- */

static bool is_half_channel(const char *name)
{
    return (strlen(name) == 1 && strchr("RGBA", *name)) || strncmp(name, "N.", 2) == 0 ||
           strncmp(name, "albedo.", 7) == 0;
}

static void mark_half(struct stp_image *image)
{
    for (unsigned i = 0; i < image->channel_count; i++)
        image->channels[i].half = is_half_channel(image->channels[i].name);
}

/* `path` itself, or the frame's path from the pattern; to be freed. */
static char *frame_path(const struct settings *settings, const char *path, uint32_t index)
{
    return option_given(settings, "frames") ? pattern_expand(path, index) : strdup(path);
}

static enum stp_result write_exr(struct run *run, const struct frame *frame, const char *path)
{
    struct stp_plan_summary summary;
    struct stp_exr_params params = run->settings->exr;
    stp_plan_summarize(frame->plan, &summary);
    params.comment = summary.why;
    return stp_image_write_exr(&run->console.env, frame->image, path, &params);
}

static int write_pictures(struct run *run, const struct frame *frame, uint32_t index)
{
    const struct settings *settings = run->settings;
    char *exr = settings->output ? frame_path(settings, settings->output, index) : NULL;
    char *png = settings->preview ? frame_path(settings, settings->preview, index) : NULL;
    bool named = (exr || !settings->output) && (png || !settings->preview);
    enum stp_result result = named ? STP_OK : STP_ERROR_MEMORY;
    if (!named)
        console_error(&run->console, "out of memory");
    signals_hold();
    if (result == STP_OK && exr)
        result = write_exr(run, frame, exr);
    if (result == STP_OK && png)
        result = stp_image_write_png(&run->console.env, frame->image, png, settings->exposure);
    signals_release();
    free(exr);
    free(png);
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}

static int render_frame(struct run *run, struct frame *frame)
{
    const struct settings *settings = run->settings;
    struct stp_limits none;
    if (!run->limits)
        stp_limits_lavapipe(&none); /* the reference plans without a device */
    const struct stp_limits *limits = run->limits ? run->limits : &none;
    double start = seconds_now();
    struct stp_choice choice;
    int status = choose_way(&run->console, settings, run->scene, &frame->camera, limits, &choice);
    run->times.prepare += ms_since(start);
    if (status != EXIT_DONE)
        return status;
    const struct stp_env *env = &run->console.env;
    enum stp_result result =
        stp_plan_create(env, run->scene, &frame->camera, &choice.params, limits, &frame->plan);
    if (result == STP_OK)
        result = stp_render(env, run->job.context, run->scene, frame->plan, settings->repeat,
                            &frame->image, &frame->stats);
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}

static int add_stats(struct run *run, const struct frame *frame)
{
    if (!run->settings->stats)
        return EXIT_DONE;
    stats_add(&run->building, run->stats, run->limits, stp_scene_facts(run->scene), frame->plan,
              &frame->stats, &run->times);
    if (!run->building.failed)
        return EXIT_DONE;
    console_error(&run->console, "out of memory");
    return EXIT_FAILED;
}

static int do_frame(struct run *run, uint32_t index)
{
    struct frame frame = { 0 };
    int status = find_camera(&run->console, run->settings, run->scene, index, &frame.camera, NULL);
    if (status == EXIT_DONE)
        status = render_frame(run, &frame);
    if (status == EXIT_DONE && run->settings->half)
        mark_half(frame.image);
    double start = seconds_now();
    if (status == EXIT_DONE)
        status = write_pictures(run, &frame, index);
    run->times.write = ms_since(start);
    if (status == EXIT_DONE)
        status = add_stats(run, &frame);
    if (status == EXIT_DONE && run->settings->write_camera &&
        stp_camera_save(&run->console.env, run->settings->write_camera, &frame.camera) != STP_OK)
        status = EXIT_FAILED;
    stp_image_destroy(&frame.image);
    stp_plan_destroy(&frame.plan);
    return status;
}

/* --- all of it ------------------------------------------------------------------------------- */

static int check_camera_path(struct run *run)
{
    const struct settings *settings = run->settings;
    struct stp_camera camera;
    uint32_t count;
    if (!settings->camera)
        return EXIT_DONE;
    int status = find_camera(&run->console, settings, NULL, 0, &camera, &count);
    if (status != EXIT_DONE)
        return status;
    if (!option_given(settings, "frames") && count > 1)
        console_warning(&run->console,
                        "%s holds %u cameras; the first is used, --frames 0:%u "
                        "renders all",
                        settings->camera, count, count - 1);
    if (settings->last_frame < count)
        return EXIT_DONE;
    return wrong_usage(settings->command, "--frames %u:%u: %s holds %u cameras, 0 to %u",
                       settings->first_frame, settings->last_frame, settings->camera, count,
                       count - 1);
}

/* One frame's object as it is; several as an array. */
static int write_stats(struct run *run)
{
    if (!run->settings->stats)
        return EXIT_DONE;
    bool many = option_given(run->settings, "frames");
    char *text = cJSON_Print(many ? run->stats : cJSON_GetArrayItem(run->stats, 0));
    if (!text)
        console_error(&run->console, "out of memory");
    bool done = text && output_text(&run->console, run->settings->stats, text);
    free(text);
    return done ? EXIT_DONE : EXIT_FAILED;
}

/* Only who asks for a bound waits for measurements. */
static int calibrate(struct run *run)
{
    const struct settings *settings = run->settings;
    struct stp_calibrate_params params = {
        .again = settings->calibrate,
        .only_cached = !settings->calibrate && !(settings->render.max_error > 0),
    };
    enum stp_result result = stp_calibrate(&run->console.env, run->job.context, &params);
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}

static int render_all(struct run *run)
{
    int status = check_outputs(run);
    if (status == EXIT_DONE)
        status = check_camera_path(run);
    if (status != EXIT_DONE)
        return status;
    if (run->settings->render.method != STP_METHOD_REFERENCE)
        context_start(&run->job, &run->console, &run->settings->context);
    status = load_and_prepare(&run->console, run->settings, run->settings->files[0], &run->scene,
                              &run->times);
    if (status == EXIT_DONE && run->settings->render.method != STP_METHOD_REFERENCE)
        status = context_finish(&run->job, &run->limits);
    if (status == EXIT_DONE && run->limits)
        status = calibrate(run);
    for (uint32_t i = run->settings->first_frame;
         status == EXIT_DONE && i <= run->settings->last_frame; i++)
        status = do_frame(run, i);
    return status == EXIT_DONE ? write_stats(run) : status;
}

int run_render(struct settings *settings)
{
    struct run run = { .settings = settings };
    int status = check_usage(settings);
    if (status != EXIT_DONE)
        return status;
    console_open(&run.console, settings);
    run.stats = settings->stats ? json_begin(&run.building, cJSON_CreateArray()) : NULL;
    status = render_all(&run);
    context_close(&run.job);
    stp_scene_destroy(&run.scene);
    cJSON_Delete(run.stats);
    console_close(&run.console);
    return status;
}
