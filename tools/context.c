/* The device's context, made on a thread of its own while the scene is loaded. */
#include "cli.h"

/* Kept: context_finish adds advice to it. */
static void keep_error(void *user, enum stp_log_level level, const char *line)
{
    struct context_job *job = user;
    if (level == STP_LOG_ERROR)
        snprintf(job->error, sizeof job->error, "%s", line);
    else
        job->console->env.log(job->console, level, line);
}

static void *create_context(void *user)
{
    struct context_job *job = user;
    struct stp_env env = { .threads = job->console->env.threads, .log = keep_error, .user = job };
    job->result = stp_context_create(&env, &job->params, &job->context);
    return NULL;
}

void context_start(struct context_job *job, struct console *console,
                   const struct stp_context_params *params)
{
    job->console = console;
    job->params = *params;
    job->threaded = pthread_create(&job->thread, NULL, create_context, job) == 0;
}

static void join(struct context_job *job)
{
    if (job->threaded)
        pthread_join(job->thread, NULL);
    job->threaded = false;
}

int context_finish(struct context_job *job, const struct stp_limits **limits)
{
    if (job->threaded)
        join(job);
    else
        create_context(job);
    if (job->result == STP_OK) {
        *limits = stp_context_limits(job->context);
        return EXIT_DONE;
    }
    bool no_device = job->result == STP_ERROR_NO_DEVICE && !job->params.device;
    console_error(job->console, "%s%s", job->error,
                  no_device ? "; install a Vulkan driver (mesa-vulkan-drivers needs no GPU), or "
                              "use --method reference"
                            : "");
    return EXIT_FAILED;
}

void context_close(struct context_job *job)
{
    join(job);
    stp_context_destroy(&job->context);
}
