/* One line to the caller's log: control characters in what is printed become '?'. Nothing here
 * keeps state. */
#ifndef STP_BASE_LOG_H
#define STP_BASE_LOG_H

#include <stipple/result.h>

/* Logs and returns `result`, so that failures read `return log_error(env, STP_..., "...", ...)`. */
enum stp_result log_error(const struct stp_env *env, enum stp_result result, const char *format,
                          ...) __attribute__((format(printf, 3, 4)));
void log_warning(const struct stp_env *env, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void log_info(const struct stp_env *env, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void log_progress(const struct stp_env *env, const char *stage, double fraction);

/* An stp_env.log that drops every line: of what is only tried, and may fail. */
void log_nothing(void *user, enum stp_log_level level, const char *line);

/* The same line for every allocation that fails. */
enum stp_result log_no_memory(const struct stp_env *env, size_t bytes, const char *what);

#endif
