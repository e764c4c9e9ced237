/* From the settings to library objects: what several commands do in the same way. */
#include "cli.h"

int exit_of_input(enum stp_result result)
{
    switch (result) {
    case STP_OK:
        return EXIT_DONE;
    case STP_ERROR_IO:
    case STP_ERROR_FORMAT:
    case STP_ERROR_NO_POINTS:
        return EXIT_BAD_INPUT;
    case STP_ERROR_ARGUMENT:
        return EXIT_COMMAND_LINE;
    default:
        return EXIT_FAILED;
    }
}

/* Preparing knows no files: its lines get the file's name in front. */
struct named {
    struct console *console;
    const char *path;
};

static void log_named(void *user, enum stp_log_level level, const char *line)
{
    const struct named *named = user;
    char whole[2048];
    snprintf(whole, sizeof whole, "%s: %s", named->path, line);
    named->console->env.log(named->console, level, whole);
}

static void progress_named(void *user, const char *stage, double fraction)
{
    const struct named *named = user;
    named->console->env.progress(named->console, stage, fraction);
}

static enum stp_result prepare_named(struct console *console, const char *path,
                                     struct stp_scene *scene,
                                     const struct stp_prepare_params *params)
{
    struct named named = { console, path };
    struct stp_env env = {
        .threads = console->env.threads,
        .log = log_named,
        .progress = console->env.progress ? progress_named : NULL,
        .user = &named,
    };
    return stp_scene_prepare(&env, scene, params);
}

#define MOST_LOADED ((size_t)1 << 24) /* points: beyond it what can stay in its file does */

static size_t stream_above(const struct settings *settings)
{
    if (settings->stream == STP_AUTO)
        return settings->render.method == STP_METHOD_PYRAMID ? MOST_LOADED : 0;
    return settings->stream == STP_ON;
}

int load_and_prepare(struct console *console, const struct settings *settings, const char *path,
                     struct stp_scene **scene, struct run_times *times)
{
    struct stp_scene *loaded = NULL;
    double start = seconds_now();
    struct stp_load_params load = settings->load;
    load.optics = &settings->optics;
    load.stream_above = stream_above(settings);
    enum stp_result result = stp_scene_load(&console->env, path, &load, &loaded);
    if (result == STP_OK && settings->environment)
        result = stp_scene_load_environment(&console->env, loaded, settings->environment,
                                            &settings->around);
    double middle = seconds_now();
    if (result == STP_OK)
        result = prepare_named(console, path, loaded, &settings->prepare);
    if (times)
        *times = (struct run_times){ .load = (middle - start) * 1e3,
                                     .prepare = (seconds_now() - middle) * 1e3 };
    if (result == STP_OK)
        *scene = loaded;
    else
        stp_scene_destroy(&loaded);
    return exit_of_input(result);
}

static bool frames_scene(const struct settings *settings)
{
    return option_given(settings, "view") || option_given(settings, "fov") ||
           option_given(settings, "ortho");
}

bool camera_usage_right(const struct settings *settings)
{
    if (!settings->camera || !frames_scene(settings))
        return true;
    wrong_usage(settings->command, "--camera excludes --view, --fov and --ortho");
    return false;
}

static enum stp_result frame_scene(const struct stp_env *env, const struct settings *settings,
                                   const struct stp_scene *scene, struct stp_camera *camera)
{
    struct stp_frame_params frame = settings->frame;
    frame.up = settings->load.up;
    if (!option_given(settings, "view")) {
        frame.azimuth = STP_ISO_AZIMUTH;
        frame.elevation = STP_ISO_ELEVATION;
    }
    return stp_camera_frame(env, scene, &frame, camera);
}

int find_camera(struct console *console, const struct settings *settings,
                const struct stp_scene *scene, uint32_t frame, struct stp_camera *camera,
                uint32_t *count)
{
    uint32_t width = settings->frame.width, height = settings->frame.height;
    if (count)
        *count = 1;
    if (settings->camera)
        return exit_of_input(
            stp_camera_load(&console->env, settings->camera, frame, width, height, camera, count));
    if (!frames_scene(settings) && stp_scene_camera(scene, width, height, camera))
        return EXIT_DONE;
    return exit_of_input(frame_scene(&console->env, settings, scene, camera));
}

static int cover_if_needed(struct console *console, const struct settings *settings,
                           struct stp_scene *scene, const struct stp_limits *limits)
{
    const struct stp_facts *facts = stp_scene_facts(scene);
    struct stp_cover_params params = { .groups = settings->group.max_groups };
    if (facts->cover.groups || !stp_plan_needs_cover(facts, &settings->render, limits) ||
        stp_scene_cover(&console->env, scene, &params) == STP_OK)
        return EXIT_DONE;
    return EXIT_FAILED;
}

static int group_if_needed(struct console *console, const struct settings *settings,
                           struct stp_scene *scene, const struct stp_limits *limits)
{
    const struct stp_facts *facts = stp_scene_facts(scene);
    if (facts->grouping.groups || !stp_plan_needs_groups(facts, &settings->render, limits))
        return cover_if_needed(console, settings, scene, limits);
    if (stp_scene_group(&console->env, scene, &settings->group) == STP_OK)
        return EXIT_DONE;
    return EXIT_FAILED;
}

/* Options of groups where nothing is grouped: a line each, once for all frames. */
static void tell_unused(struct console *console, const struct settings *settings,
                        const struct stp_scene *scene, const struct stp_limits *limits)
{
    const struct stp_facts *facts = stp_scene_facts(scene);
    bool groups = stp_plan_needs_groups(facts, &settings->render, limits);
    bool cover = stp_plan_needs_cover(facts, &settings->render, limits);
    const struct {
        const char *option;
        bool used;
    } options[] = { { "overlap", groups }, { "relax", groups }, { "groups", groups || cover } };
    for (int i = 0; i < 3 && !console->told_unused; i++)
        if (option_given(settings, options[i].option) && !options[i].used)
            console_warning(console,
                            "--%s has no effect: only --method deferred groups splats, and opaque "
                            "ones",
                            options[i].option);
    console->told_unused = true;
}

bool facts_coarse(const struct stp_facts *facts)
{
    return facts->float_step > (double)facts->radius_median / 16;
}

int choose_way(struct console *console, const struct settings *settings, struct stp_scene *scene,
               const struct stp_camera *camera, const struct stp_limits *limits,
               struct stp_choice *choice)
{
    const struct stp_render_params *render = &settings->render;
    bool open = render->method == STP_METHOD_AUTO || render->max_error > 0;
    *choice = (struct stp_choice){ .params = *render, .met = true };
    if (open && render->method != STP_METHOD_REFERENCE &&
        stp_choose(&console->env, scene, camera, &settings->group, render, limits, choice) !=
            STP_OK)
        return EXIT_FAILED;
    if (choice->count)
        return EXIT_DONE;
    tell_unused(console, settings, scene, limits);
    return group_if_needed(console, settings, scene, limits);
}
