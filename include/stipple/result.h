/* Results, logging and the environment of a call. */
#ifndef STIPPLE_RESULT_H
#define STIPPLE_RESULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define STP_API __attribute__((visibility("default")))
#else
#define STP_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The numbers are pinned: they never change meaning between versions. */
enum stp_result {
    STP_OK = 0,
    STP_ERROR_ARGUMENT = 1,      /* the caller passed something out of range */
    STP_ERROR_MEMORY = 2,        /* host memory ran out */
    STP_ERROR_IO = 3,            /* open, read, write or rename failed */
    STP_ERROR_FORMAT = 4,        /* a file is damaged, or not a format that is read */
    STP_ERROR_NO_POINTS = 5,     /* nothing is left to draw */
    STP_ERROR_NO_DEVICE = 6,     /* no Vulkan device fits */
    STP_ERROR_DEVICE = 7,        /* a Vulkan call failed, or the device was lost */
    STP_ERROR_DEVICE_MEMORY = 8, /* the plan does not fit the device, even in tiles */
    STP_ERROR_FEATURE = 9,       /* a required feature is missing; the log line names it */
    STP_ERROR_VALIDATION = 10,   /* a validation layer spoke */
};

/* A short English phrase, never NULL; static storage. */
STP_API const char *stp_result_text(enum stp_result result);

/* The version of these headers; test for one with STP_VERSION_NUMBER >= 100 (0.1.0). */
#define STP_VERSION_MAJOR                      0
#define STP_VERSION_MINOR                      1
#define STP_VERSION_PATCH                      0
#define STP_VERSION_NUMBER                     (10000 * STP_VERSION_MAJOR + 100 * STP_VERSION_MINOR + STP_VERSION_PATCH)
#define STP_VERSION                            STP_VERSION_TEXT(STP_VERSION_MAJOR, STP_VERSION_MINOR, STP_VERSION_PATCH)
#define STP_VERSION_TEXT(major, minor, patch)  STP_VERSION_TEXT_(major, minor, patch)
#define STP_VERSION_TEXT_(major, minor, patch) #major "." #minor "." #patch

/* The library's version, "major.minor.patch"; static storage. */
STP_API const char *stp_version(void);

enum stp_log_level { STP_LOG_ERROR = 0, STP_LOG_WARNING = 1, STP_LOG_INFO = 2 };

/* Where a call reports and what it may use. NULL means all defaults. The callbacks are called
 * from the thread that made the call, and only during it. */
struct stp_env {
    unsigned threads; /* 0: one per processor that is online */
    /* One line without a newline; NULL: errors and warnings go to stderr. */
    void (*log)(void *user, enum stp_log_level level, const char *line);
    /* fraction in [0, 1]; NULL: nothing. */
    void (*progress)(void *user, const char *stage, double fraction);
    void *user;
};

/* A text file, as a profile, statistics or a plan in words: the text and a newline. As every file
 * that is written: beside its place, then renamed, so that what was there before stays whole when
 * it fails; with the rights of any new file. */
STP_API enum stp_result stp_text_save(const struct stp_env *env, const char *path,
                                      const char *text);

#ifdef __cplusplus
}
#endif
#endif
