#include "base/log.h"

#include <stdarg.h>
#include <stdio.h>

/* Names out of files and paths may hold line feeds and escape sequences of terminals. */
static void keep_to_one_line(char *line)
{
    for (; *line; line++)
        if ((unsigned char)*line < ' ' || *line == 0x7f)
            *line = '?';
}

static void emit(const struct stp_env *env, enum stp_log_level level, const char *format,
                 va_list args)
{
    char line[1024];
    vsnprintf(line, sizeof line, format, args);
    keep_to_one_line(line);
    if (env && env->log)
        env->log(env->user, level, line);
    else if (level < STP_LOG_INFO)
        fprintf(stderr, "stipple: %s%s\n", level == STP_LOG_WARNING ? "warning: " : "", line);
}

enum stp_result log_error(const struct stp_env *env, enum stp_result result, const char *format,
                          ...)
{
    va_list args;
    va_start(args, format);
    emit(env, STP_LOG_ERROR, format, args);
    va_end(args);
    return result;
}

void log_warning(const struct stp_env *env, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    emit(env, STP_LOG_WARNING, format, args);
    va_end(args);
}

void log_info(const struct stp_env *env, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    emit(env, STP_LOG_INFO, format, args);
    va_end(args);
}

void log_progress(const struct stp_env *env, const char *stage, double fraction)
{
    if (env && env->progress)
        env->progress(env->user, stage, fraction);
}

void log_nothing(void *user, enum stp_log_level level, const char *line)
{
    (void)user;
    (void)level;
    (void)line;
}

enum stp_result log_no_memory(const struct stp_env *env, size_t bytes, const char *what)
{
    return log_error(env, STP_ERROR_MEMORY, "out of memory: %zu bytes for %s", bytes, what);
}
