/* Files: read whole (mapped, or inflated when gzip), written beside their place and renamed. */
#ifndef STP_BASE_FILE_H
#define STP_BASE_FILE_H

#include <stipple/result.h>
#include <stdint.h>
#include <stdio.h>

struct file_bytes {
    const unsigned char *data;
    size_t size;
    bool mapped, inflated;
};

/* Reads a regular file, inflating gzip (found from its magic bytes). Bounds the inflated size by
 * the machine's memory. Logs path and errno. */
enum stp_result file_read(const struct stp_env *env, const char *path, struct file_bytes *bytes);
/* How many of the inflated bytes the caller has a use for. What comes after them may be left out,
 * and is not looked at: a small file that inflates to very much costs no more than what it says it
 * holds. FILE_SLACK more are allowed for, so that an honest file is checked to its end. */
#define FILE_ALL   SIZE_MAX
#define FILE_SLACK ((size_t)1 << 16)
#define FILE_HEAD  ((size_t)1 << 12)
struct file_use {
    size_t most; /* FILE_ALL: all */
    /* If any: says it from the first FILE_HEAD bytes or more, once there are so many. */
    size_t (*stated)(const struct file_bytes *head);
};
/* file_read of a file of which gzip need not be inflated to its end. */
enum stp_result file_read_for(const struct stp_env *env, const char *path,
                              const struct file_use *use, struct file_bytes *bytes);
/* Inflates `size` bytes of gzip or zlib that stand inside a file; path is for messages. */
enum stp_result file_inflate(const struct stp_env *env, const char *path, const unsigned char *data,
                             size_t size, const struct file_use *use, struct file_bytes *bytes);
void file_release(struct file_bytes *bytes);

/* A file that appears under `path` only when it is whole. Of a symbolic link, the file that it
 * names is replaced, not the link; what is replaced leaves its permissions. */
struct file_output {
    FILE *stream;
    char *path, *target, *temporary; /* as given; after links; beside the target */
};
/* Refuses what is there and is no regular file. */
enum stp_result file_begin(const struct stp_env *env, const char *path, struct file_output *out);
/* Flushes, waits for the disk, closes and renames; on failure removes the temporary and logs. */
enum stp_result file_commit(const struct stp_env *env, struct file_output *out);
/* Removes the temporary; safe after a commit or a failed begin. */
void file_abandon(struct file_output *out);

#endif
