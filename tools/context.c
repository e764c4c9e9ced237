/* The device's context, made on a thread of its own while the scene is loaded. */
#include "cli.h"

/* Kept until context_finish: when the input is bad, that is the one line to print. */
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
    console_error(job->console, "%s", job->error);
    return EXIT_FAILED;
}

int context_calibrate(struct context_job *job, const struct settings *settings,
                      const struct stp_facts *facts)
{
    const struct stp_render_params *render = &settings->render;
    bool priced = render->max_error > 0 && stp_choose_estimates(facts, render);
    struct stp_calibrate_params params = {
        .again = settings->calibrate,
        .only_cached = !settings->calibrate && !priced,
    };
    return stp_calibrate(&job->console->env, job->context, &params) == STP_OK ? EXIT_DONE
                                                                              : EXIT_FAILED;
}

void context_close(struct context_job *job)
{
    join(job);
    stp_context_destroy(&job->context);
}
