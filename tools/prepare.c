/* stipple prepare: the prepared splats as a PLY. */
#include "cli.h"

static int save(struct console *console, const struct settings *settings,
                const struct stp_scene *scene)
{
    signals_hold();
    enum stp_result result = stp_scene_save(&console->env, scene, settings->output);
    signals_release();
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}

int run_prepare(struct settings *settings)
{
    struct console console;
    struct stp_scene *scene = NULL;
    if (!settings->output)
        return wrong_usage(settings->command, "prepare wants -o OUT.ply");
    if (!settings->with_groups &&
        (option_given(settings, "overlap") || option_given(settings, "groups") ||
         option_given(settings, "relax")))
        return wrong_usage(settings->command, "--overlap, --groups and --relax want --group");
    console_open(&console, settings);
    int status = output_possible(&console, settings->output, settings) ? EXIT_DONE : EXIT_FAILED;
    if (status == EXIT_DONE)
        status = load_and_prepare(&console, settings, settings->files[0], &scene, NULL);
    if (status == EXIT_DONE && settings->with_groups &&
        stp_scene_group(&console.env, scene, &settings->group) != STP_OK)
        status = EXIT_FAILED;
    if (status == EXIT_DONE)
        status = save(&console, settings, scene);
    stp_scene_destroy(&scene);
    console_close(&console);
    return status;
}
