/* stipple render: load, prepare, plan, render, write. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "machines.h"

struct run {
    struct settings *settings;
    struct console console;
    struct context_job job;
    struct stp_scene *scene;
    const struct stp_limits *limits; /* NULL: the reference, no device */
    struct run_times times;
    cJSON *stats; /* of each frame, an array; NULL without --stats */
    struct json_out building;
    struct stp_machines exchange;
    bool ended;               /* all processes know that one has failed */
    bool shared;              /* every process has its share of the points */
    struct stp_camera camera; /* shared, without --camera: framed while the scene was whole */
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
    if (frames && settings->deep && !pattern_valid(settings->deep))
        return wrong_usage(command, "--frames wants one %%d or %%04d in --deep '%s'",
                           settings->deep);
    if (frames && settings->preview && !pattern_valid(settings->preview))
        return wrong_usage(command, "--frames wants one %%d or %%04d in --preview '%s'",
                           settings->preview);
    return EXIT_DONE;
}

#define OUTPUTS 5
/* The outputs, NULL where not wanted. */
static void list_outputs(const struct settings *settings, const char *paths[OUTPUTS])
{
    paths[0] = settings->output;
    paths[1] = settings->preview;
    paths[2] = settings->stats;
    paths[3] = settings->write_camera;
    paths[4] = settings->deep;
}

static int check_split(const struct settings *settings)
{
    const struct command *command = settings->command;
    if (!option_given(settings, "split"))
        return EXIT_DONE;
    if (!machines_possible())
        return wrong_usage(command, "--split wants a build with MPI (meson setup -Dmpi=enabled)");
    if (settings->split == SPLIT_FRAMES && !option_given(settings, "frames"))
        return wrong_usage(command, "--split frames wants --frames");
    if (settings->split == SPLIT_FRAMES && settings->stats)
        return wrong_usage(command, "--stats goes with --split points only");
    return EXIT_DONE;
}

static int check_usage(const struct settings *settings)
{
    const struct command *command = settings->command;
    const char *paths[OUTPUTS];
    if (!settings->output && !settings->deep && !settings->preview && !settings->stats)
        return wrong_usage(command,
                           "render wants -o OUT.exr (or --deep, --preview, or --stats alone)");
    if (!camera_usage_right(settings))
        return EXIT_COMMAND_LINE;
    list_outputs(settings, paths);
    for (int i = 0; i < OUTPUTS; i++)
        for (int j = 0; j < i; j++)
            if (paths[i] && paths[j] && strcmp(paths[i], paths[j]) == 0)
                return wrong_usage(command, "'%s' is given for two outputs", paths[i]);
    int status = check_frames(settings);
    return status == EXIT_DONE ? check_split(settings) : status;
}

static int check_outputs(struct run *run)
{
    const char *paths[OUTPUTS];
    list_outputs(run->settings, paths);
    for (int i = 0; i < OUTPUTS; i++)
        if (paths[i] && !output_possible(&run->console, paths[i], run->settings))
            return EXIT_FAILED;
    return EXIT_DONE;
}

/* The worst of all processes' status; of those that failed the first says why. Whoever fails asks
 * once more, at its next call, and so does everyone else at theirs; then nobody asks again. */
static int together(struct run *run, int status)
{
    if (run->exchange.count > 1 && !run->ended) {
        status = machines_agree(&run->exchange, &run->console, status);
        run->ended = status != EXIT_DONE;
    }
    return status;
}

/* Collective, also where the plan could not be made. */
static int render_share(struct run *run, struct frame *frame, enum stp_result planned)
{
    int status = together(run, planned == STP_OK ? EXIT_DONE : EXIT_FAILED);
    if (status != EXIT_DONE)
        return status;
    enum stp_result result =
        stp_render_share(&run->console.env, run->job.context, run->scene, frame->plan,
                         &run->exchange, run->settings->repeat, &frame->image, &frame->stats);
    return together(run, result == STP_OK ? EXIT_DONE : EXIT_FAILED);
}

static void tell_why(struct run *run, const struct stp_plan *plan)
{
    struct stp_plan_summary summary;
    stp_plan_summarize(plan, &summary);
    console_info(&run->console, "%s", summary.why);
}

static int render_frame(struct run *run, struct frame *frame)
{
    const struct settings *settings = run->settings;
    struct stp_limits none;
    if (!run->limits)
        stp_limits_lavapipe(&none); /* the reference plans without a device */
    const struct stp_limits *limits = run->limits ? run->limits : &none;
    double start = seconds_now();
    struct stp_choice choice = { .params = settings->render };
    int status = EXIT_DONE;
    if (!run->shared) /* several processes have but one way */
        status = choose_way(&run->console, settings, run->scene, &frame->camera, limits, &choice);
    run->times.prepare += ms_since(start);
    if (status != EXIT_DONE)
        return status;
    const struct stp_env *env = &run->console.env;
    enum stp_result result =
        stp_plan_create(env, run->scene, &frame->camera, &choice.params, limits, &frame->plan);
    if (result == STP_OK)
        tell_why(run, frame->plan);
    if (run->shared)
        return render_share(run, frame, result);
    if (result == STP_OK)
        result = stp_render(env, run->job.context, run->scene, frame->plan, settings->repeat,
                            &frame->image, settings->stats ? &frame->stats : NULL);
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}

static int add_stats(struct run *run, const struct frame *frame)
{
    if (!run->settings->stats)
        return EXIT_DONE;
    stats_add(&run->building, run->stats, run->limits, stp_scene_facts(run->scene), frame->plan,
              &frame->stats, &run->times, frame->image);
    if (!run->building.failed)
        return EXIT_DONE;
    console_error(&run->console, "out of memory");
    return EXIT_FAILED;
}

static int find_frame_camera(struct run *run, uint32_t index, struct stp_camera *camera)
{
    if (!run->shared || run->settings->camera)
        return find_camera(&run->console, run->settings, run->scene, index, camera, NULL);
    *camera = run->camera;
    return EXIT_DONE;
}

static int write_frame(struct run *run, struct frame *frame, uint32_t index)
{
    const struct settings *settings = run->settings;
    double start = seconds_now();
    int status = write_pictures(&run->console, settings, frame->plan, frame->image, index);
    run->times.write = ms_since(start);
    if (status == EXIT_DONE)
        status = add_stats(run, frame);
    if (status == EXIT_DONE && settings->write_camera &&
        stp_camera_save(&run->console.env, settings->write_camera, &frame->camera) != STP_OK)
        status = EXIT_FAILED;
    return status;
}

static int do_frame(struct run *run, uint32_t index)
{
    struct frame frame = { 0 };
    int status = find_frame_camera(run, index, &frame.camera);
    if (status == EXIT_DONE)
        status = render_frame(run, &frame);
    if (status == EXIT_DONE && frame.image)
        status = write_frame(run, &frame, index);
    stp_image_destroy(&frame.image);
    stp_plan_destroy(&frame.plan);
    return status;
}

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

/* Frames what is to be framed, then keeps this process's share. */
static int share_scene(struct run *run)
{
    const struct settings *settings = run->settings;
    int status = EXIT_DONE;
    if (!settings->camera)
        status = find_camera(&run->console, settings, run->scene, 0, &run->camera, NULL);
    if (status == EXIT_DONE && stp_scene_share(&run->console.env, run->scene, run->exchange.rank,
                                               run->exchange.count) != STP_OK)
        status = EXIT_FAILED;
    return status;
}

/* Of several processes, each has a frame in turn, or all make every one; a failure ends all at the
 * end of the frame. */
static int render_frames(struct run *run)
{
    const struct settings *settings = run->settings;
    bool mine = run->exchange.count > 1 && !run->shared;
    uint32_t step = mine ? run->exchange.count : 1, rank = mine ? run->exchange.rank : 0;
    int status = EXIT_DONE;
    for (uint64_t i = settings->first_frame; status == EXIT_DONE && i <= settings->last_frame;
         i += step) {
        if (i + rank <= settings->last_frame)
            status = do_frame(run, (uint32_t)(i + rank));
        status = together(run, status);
    }
    return status;
}

static void tell_lost(struct run *run)
{
    const struct stp_facts *facts = stp_scene_facts(run->scene);
    size_t dropped = facts->volume.dims[0] > 0 ? 0 : facts->not_finite;
    if (dropped)
        console_warning(&run->console, "%s: %zu %s dropped", run->settings->files[0], dropped,
                        dropped == 1 ? "point is not finite, or beyond 1e18:"
                                     : "points are not finite, or beyond 1e18:");
    if (facts_coarse(facts))
        console_warning(&run->console,
                        "%s: coordinates are float32 in steps of %.3g, too coarse for radii of "
                        "%.3g: where points lie is lost in the file",
                        run->settings->files[0], facts->float_step, (double)facts->radius_median);
}

static int load(struct run *run)
{
    const struct settings *settings = run->settings;
    bool on_device = settings->render.method != STP_METHOD_REFERENCE;
    /* An opaque scene ignores it, and it is not known yet what the scene is. */
    bool perhaps = on_device && settings->render.transparency == STP_TRANSPARENCY_REFERENCE;
    if (on_device && !perhaps)
        context_start(&run->job, &run->console, &settings->context);
    int status =
        load_and_prepare(&run->console, settings, settings->files[0], &run->scene, &run->times);
    if (status == EXIT_DONE)
        tell_lost(run);
    if (status == EXIT_DONE && perhaps) {
        on_device = !stp_scene_facts(run->scene)->transparent;
        if (on_device)
            context_start(&run->job, &run->console, &settings->context);
    }
    if (status == EXIT_DONE && on_device)
        status = context_finish(&run->job, &run->limits);
    if (status == EXIT_DONE && run->limits && !run->shared)
        status = context_calibrate(&run->job, settings, stp_scene_facts(run->scene));
    if (status == EXIT_DONE && run->shared)
        status = share_scene(run);
    return status;
}

static int render_all(struct run *run)
{
    bool writes = run->exchange.rank == 0 || !run->shared;
    int status = writes ? check_outputs(run) : EXIT_DONE;
    if (status == EXIT_DONE)
        status = check_camera_path(run);
    status = together(run, status);
    if (status == EXIT_DONE)
        status = together(run, load(run));
    if (status == EXIT_DONE)
        status = render_frames(run);
    if (status == EXIT_DONE && run->exchange.rank == 0)
        status = write_stats(run);
    return together(run, status);
}

/* Of several processes one speaks: the first that fails, else the root. */
static int join(struct run *run)
{
    struct console *console = &run->console;
    const struct settings *settings = run->settings;
    enum stp_method method = settings->render.method;
    machines_open(&run->exchange);
    if (run->exchange.count == 1)
        return EXIT_DONE;
    console->holds = true;
    if (run->exchange.rank > 0) {
        console->quiet = true;
        console->verbose = false;
        console->env.progress = NULL;
    }
    run->shared = settings->split == SPLIT_POINTS;
    if (run->shared && ((method != STP_METHOD_AUTO && method != STP_METHOD_TWO_PASS) ||
                        settings->render.path == STP_PATH_RASTER))
        return wrong_usage(settings->command, "several processes make one picture by --method "
                                              "two-pass --path compute only; or --split frames");
    if (run->shared && run->settings->render.max_error > 0)
        return wrong_usage(settings->command, "--max-error chooses among methods, of which several "
                                              "processes have one; or --split frames");
    if (run->shared) {
        run->settings->render.method = STP_METHOD_TWO_PASS;
        run->settings->render.path = STP_PATH_COMPUTE;
    }
    return EXIT_DONE;
}

int run_render(struct settings *settings)
{
    struct run run = { .settings = settings };
    settings->render.deep = settings->deep != NULL;
    int status = check_usage(settings);
    if (status != EXIT_DONE)
        return status;
    console_open(&run.console, settings);
    status = join(&run);
    if (settings->half && settings->render.max_error > 0)
        console_warning(&run.console,
                        "--half rounds colours by up to 1/2048 of their size, beyond what "
                        "--max-error bounds");
    run.stats = settings->stats ? json_begin(&run.building, cJSON_CreateArray()) : NULL;
    if (status == EXIT_DONE)
        status = render_all(&run);
    context_close(&run.job);
    stp_scene_destroy(&run.scene);
    cJSON_Delete(run.stats);
    console_close(&run.console);
    machines_close(&run.exchange);
    return status;
}
