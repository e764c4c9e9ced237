/* Files: read whole (mapped, or inflated when gzip), written beside their place and renamed. */
#ifndef STP_BASE_FILE_H
#define STP_BASE_FILE_H

#include <stipple/result.h>
#include <stdio.h>

struct file_bytes {
    const unsigned char *data;
    size_t size;
    bool mapped, inflated;
};

/* Reads a regular file, inflating gzip (found from its magic bytes). Bounds the inflated size by
 * the machine's memory. Logs path and errno. */
enum stp_result file_read(const struct stp_env *env, const char *path, struct file_bytes *bytes);
/* Inflates `size` bytes of gzip or zlib that stand inside a file; path is for messages. */
enum stp_result file_inflate(const struct stp_env *env, const char *path, const unsigned char *data,
                             size_t size, struct file_bytes *bytes);
void file_release(struct file_bytes *bytes);

/* A file that appears under `path` only when it is whole. Of a symbolic link, the file that it names
 * is replaced, not the link; what is replaced leaves its permissions. */
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
