/* stipple plan: the plan in words. No Vulkan device is touched. */
#include <math.h>
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

static void print_way(const struct stp_considered *c)
{
    static const char *const payload[] = { "", "", ", packed" };
    static const char *const voronoi[] = { "", "", ", Voronoi slab", ", Voronoi exact" };
    static const char *const verdict[] = { "", "chosen", "beyond the bound" };
    char name[96];
    int used = snprintf(name, sizeof name, "%s %s%s", stp_method_name(c->method),
                        stp_path_name(c->path), payload[c->payload]);
    if (c->transparency != STP_TRANSPARENCY_AUTO)
        used += snprintf(name + used, sizeof name - (size_t)used, ", transparency %s",
                         stp_transparency_name(c->transparency));
    if (c->peel_layers)
        snprintf(name + used, sizeof name - (size_t)used, ", %u layer%s", c->peel_layers,
                 c->peel_layers > 1 ? "s" : "");
    if (c->overlap > 0)
        snprintf(name + used, sizeof name - (size_t)used, ", c %g, %u groups%s", c->overlap,
                 c->groups, voronoi[c->voronoi]);
    printf("  %-60s %9.4g ms", name, c->milliseconds);
    if (isnan(c->error))
        printf("  error not judged");
    else
        printf("  error %.2g", c->error);
    printf("%s%s\n", verdict[c->verdict][0] ? "  " : "", verdict[c->verdict]);
}

static void print_considered(const struct stp_choice *choice)
{
    if (choice->count)
        printf("considered (predicted, the cheapest first):\n");
    for (unsigned i = 0; i < choice->count; i++)
        print_way(&choice->considered[i]);
}

static int print_plan(struct console *console, const struct settings *settings,
                      struct stp_scene *scene, const struct stp_camera *camera,
                      const struct stp_limits *limits)
{
    struct stp_plan *plan = NULL;
    struct stp_choice choice;
    int status = choose_way(console, settings, scene, camera, limits, &choice);
    if (status != EXIT_DONE)
        return status;
    if (stp_plan_create(&console->env, scene, camera, &choice.params, limits, &plan) != STP_OK)
        return EXIT_FAILED;
    char *text = stp_plan_print(plan);
    stp_plan_destroy(&plan);
    if (!text) {
        console_error(console, "out of memory");
        return EXIT_FAILED;
    }
    fputs(text, stdout);
    print_considered(&choice);
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
        status = print_plan(&console, settings, scene, &camera, &limits);
    console_close(&console);
    stp_scene_destroy(&scene);
    return status;
}
