/* Inputs made in code, and the readers run on them. */
#ifndef TEST_LOAD_SUPPORT_H
#define TEST_LOAD_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "load/readers.h"

/* A growing buffer; the test program ends when memory does. */
struct buffer {
    unsigned char *data;
    size_t size, capacity;
};
void put_bytes(struct buffer *buffer, const void *data, size_t size);
void put_text(struct buffer *buffer, const char *format, ...) __attribute__((format(printf, 2, 3)));
void put_reversed(struct buffer *buffer, const void *data, size_t size); /* last byte first */
void drop(struct buffer *buffer);

/* The log of a call: the last line of each level, and how many there were. */
struct lines {
    char error[1100], warning[1100];
    unsigned errors, warnings;
};

/* Reads a buffer from a block of exactly its size, so that the sanitizer sees every byte too many.
 * Checks that a failure left the cloud alone and logged one line, and that a success logged none.
 */
enum stp_result read_buffer(const struct buffer *buffer, const struct load_options *options,
                            unsigned threads, struct cloud *cloud, struct lines *lines);

/* The same of a text, with default options; it must succeed. */
struct cloud read_text(const char *text);

/* A file on disk, with default options. */
enum stp_result read_file(const struct stp_env *env, const char *path, struct cloud *cloud);

/* It must fail with `expected`, and the line must contain `words`. */
void refuse_text(const char *text, enum stp_result expected, const char *words);
void refuse_buffer(const struct buffer *buffer, enum stp_result expected, const char *words);

/* Each allocation of a reading that succeeds fails in turn: one line, the right result, nothing
 * leaked (the sanitizer sees). */
void fail_each_allocation(const struct buffer *buffer, const char *color_by);

/* xorshift: the same numbers on every machine. */
uint64_t next_random(uint64_t *state);

bool same_cloud(const struct cloud *a, const struct cloud *b);

#endif
