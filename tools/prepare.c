/* stipple prepare: the prepared splats, or fewer fitted to them, as a PLY. */
#include "cli.h"

static int save(struct console *console, const struct settings *settings,
                const struct stp_scene *scene)
{
    signals_hold();
    enum stp_result result = stp_scene_save(&console->env, scene, settings->output);
    signals_release();
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}

static bool wants_fit(const struct settings *settings)
{
    return option_given(settings, "fit") || option_given(settings, "fit-count");
}

static bool has_fit_option(const struct settings *settings)
{
    return option_given(settings, "fit-color") || settings->fit.flat || settings->fit.alone ||
           settings->fit.smooth;
}

/* Fits, and says what came of it. */
static int fit(struct console *console, const struct settings *settings, struct stp_scene *scene)
{
    struct stp_fit_params params = settings->fit;
    struct stp_fit made;
    params.count = settings->fit_count;
    if (stp_scene_fit(&console->env, scene, &params, &made) != STP_OK)
        return EXIT_FAILED;
    if (!console->quiet)
        fprintf(stderr,
                "%zu points -> %zu splats, tolerance %g, deviation %g, %zu of one point, %zu "
                "clipped, %.0f ms\n",
                made.points, made.splats, made.tolerance, made.deviation, made.single, made.clipped,
                made.milliseconds);
    return EXIT_DONE;
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
    if (option_given(settings, "fit") && option_given(settings, "fit-count"))
        return wrong_usage(settings->command, "--fit and --fit-count are two ways to say the same");
    if (has_fit_option(settings) && !wants_fit(settings))
        return wrong_usage(settings->command,
                           "--fit-color, --fit-flat, --fit-alone and --fit-smooth want --fit or "
                           "--fit-count");
    console_open(&console, settings);
    int status = output_possible(&console, settings->output, settings) ? EXIT_DONE : EXIT_FAILED;
    if (status == EXIT_DONE)
        status = load_and_prepare(&console, settings, settings->files[0], &scene, NULL);
    if (status == EXIT_DONE && wants_fit(settings))
        status = fit(&console, settings, scene);
    if (status == EXIT_DONE && settings->with_groups &&
        stp_scene_group(&console.env, scene, &settings->group) != STP_OK)
        status = EXIT_FAILED;
    if (status == EXIT_DONE)
        status = save(&console, settings, scene);
    stp_scene_destroy(&scene);
    console_close(&console);
    return status;
}
