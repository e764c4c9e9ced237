/* stipple report: load, prepare, sweep, write a folder. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"

struct job {
    struct settings *settings;
    struct console console;
    struct context_job context;
    struct stp_scene *scene;
};

/* Where the scene's file is says nothing about the report. */
static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* As a shell takes it for one word. */
static void put_word(FILE *out, const char *word)
{
    static const char special[] = " \t\n!\"#$&'()*;<>?[\\]^`{|}~";
    if (word[0] && !strpbrk(word, special)) {
        fputs(word, out);
        return;
    }
    fputc('\'', out);
    for (const char *c = word; *c; c++)
        fputs(*c == '\'' ? "'\\''" : (char[]){ *c, 0 }, out);
    fputc('\'', out);
}

/* The command line, files without their folders; to be freed. NULL: out of memory. */
static char *command_line(const struct settings *settings)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputs("stipple", out);
    for (int i = 0; i < settings->word_count; i++) {
        fputc(' ', out);
        put_word(out, last_part(settings->words[i]));
    }
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}

static int make_folder(struct console *console, const char *path, bool *made)
{
    struct stat st;
    *made = mkdir(path, 0777) == 0;
    if (*made)
        return EXIT_DONE;
    int error = errno;
    if (error == EEXIST && stat(path, &st) == 0)
        error = !S_ISDIR(st.st_mode) ? ENOTDIR : access(path, W_OK | X_OK) != 0 ? errno : 0;
    if (!error)
        return EXIT_DONE;
    console_error(console, "%s: cannot write a report there: %s", path, strerror(error));
    return EXIT_FAILED;
}

static int sweep(struct job *job)
{
    const struct settings *settings = job->settings;
    struct stp_camera camera;
    int status = find_camera(&job->console, settings, job->scene, 0, &camera, NULL);
    if (status != EXIT_DONE)
        return status;
    char *command = command_line(settings);
    struct stp_report_params params = {
        .render = settings->render,
        .group = settings->group,
        .rounds = settings->rounds,
        .quick = settings->quick,
        .exposure = settings->compare.exposure,
        .title = last_part(settings->files[0]),
        .command = command,
    };
    enum stp_result result = stp_report(&job->console.env, job->context.context, job->scene,
                                        &camera, &params, settings->output);
    free(command);
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}

static int report_all(struct job *job)
{
    const struct settings *settings = job->settings;
    const struct stp_calibrate_params cached = { .only_cached = true };
    const struct stp_limits *limits;
    bool made;
    int status = make_folder(&job->console, settings->output, &made);
    if (status != EXIT_DONE)
        return status;
    context_start(&job->context, &job->console, &settings->context);
    status = load_and_prepare(&job->console, settings, settings->files[0], &job->scene, NULL);
    if (status == EXIT_DONE)
        status = context_finish(&job->context, &limits);
    if (status == EXIT_DONE &&
        stp_calibrate(&job->console.env, job->context.context, &cached) != STP_OK)
        status = EXIT_FAILED;
    if (status == EXIT_DONE)
        status = sweep(job);
    if (status != EXIT_DONE && made)
        rmdir(settings->output); /* stays where something was written */
    return status;
}

int run_report(struct settings *settings)
{
    struct job job = { .settings = settings };
    if (!settings->output)
        return wrong_usage(settings->command, "report wants -o DIR");
    if (!camera_usage_right(settings))
        return EXIT_COMMAND_LINE;
    console_open(&job.console, settings);
    int status = report_all(&job);
    context_close(&job.context);
    stp_scene_destroy(&job.scene);
    console_close(&job.console);
    return status;
}
