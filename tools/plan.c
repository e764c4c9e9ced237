/* stipple plan: the plan in words. No Vulkan device is touched. */
#include <stdlib.h>

#include "cli.h"

static int find_limits(struct console *console, const struct settings *settings,
                       struct stp_limits *limits)
{
    if (settings->limits)
        return exit_of_input(stp_limits_load(&console->env, settings->limits, limits));
    stp_limits_lavapipe(limits);
    return EXIT_DONE;
}

static int print_plan(struct console *console, const struct settings *settings,
                      const struct stp_scene *scene, const struct stp_camera *camera,
                      const struct stp_limits *limits)
{
    struct stp_plan *plan = NULL;
    if (stp_plan_create(&console->env, scene, camera, &settings->render, limits, &plan) != STP_OK)
        return EXIT_FAILED;
    char *text = stp_plan_print(plan);
    stp_plan_destroy(&plan);
    if (!text) {
        console_error(console, "out of memory");
        return EXIT_FAILED;
    }
    fputs(text, stdout);
    free(text);
    return EXIT_DONE;
}

int run_plan(struct settings *settings)
{
    struct console console;
    struct stp_scene *scene = NULL;
    struct stp_limits limits;
    struct stp_camera camera;
    if (!camera_usage_right(settings))
        return EXIT_COMMAND_LINE;
    console_open(&console, settings);
    int status = find_limits(&console, settings, &limits);
    if (status == EXIT_DONE)
        status = load_and_prepare(&console, settings, settings->files[0], &scene, NULL);
    if (status == EXIT_DONE)
        status = find_camera(&console, settings, scene, 0, &camera, NULL);
    if (status == EXIT_DONE)
        status = group_if_needed(&console, settings, scene, &limits);
    console_close(&console);
    if (status == EXIT_DONE)
        status = print_plan(&console, settings, scene, &camera, &limits);
    stp_scene_destroy(&scene);
    return status;
}
