/* A log that counts its lines and keeps the last of each level. */
#ifndef TEST_LOG_BOOK_H
#define TEST_LOG_BOOK_H

#include <stdio.h>
#include <stipple/result.h>

struct log_book {
    unsigned errors, warnings;
    char error[1024], warning[1024];
};

static inline void take_line(void *user, enum stp_log_level level, const char *line)
{
    struct log_book *book = user;
    if (level == STP_LOG_ERROR) {
        book->errors++;
        snprintf(book->error, sizeof book->error, "%s", line);
    } else if (level == STP_LOG_WARNING) {
        book->warnings++;
        snprintf(book->warning, sizeof book->warning, "%s", line);
    }
}

static inline struct stp_env logged_env(struct log_book *book, unsigned threads)
{
    *book = (struct log_book){ 0 };
    return (struct stp_env){ .threads = threads, .log = take_line, .user = book };
}

#endif
