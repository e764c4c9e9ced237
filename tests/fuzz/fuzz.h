/* What the fuzz targets share. Each target is a file that defines LLVMFuzzerTestOneInput: linked
 * with libFuzzer it searches, linked with replay.c it runs the corpus as an ordinary test. A broken
 * promise of a reader (log, counts, outputs untouched) aborts, as a sanitizer does. */
#ifndef FUZZ_H
#define FUZZ_H

#include "load/readers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Aborts with the line, so that the finding is told from a crash. */
void fuzz_check(bool holds, const char *what);

/* The log of one call: exactly one error line when it failed, none when it did not. */
struct fuzz_log {
    struct stp_env env;
    unsigned errors;
};
void fuzz_begin(struct fuzz_log *log);
void fuzz_end(const struct fuzz_log *log, enum stp_result result);

/* The input as a file of memory alone; `path` names it until it is closed. */
int fuzz_file_open(const uint8_t *data, size_t size, char path[32]);
void fuzz_file_close(int file);

/* A reader of points, on what its probe accepts. */
void fuzz_reader(bool (*probe)(const struct file_bytes *bytes), reader_fn read, const uint8_t *data,
                 size_t size);

#endif
