/* The readers that the probe table lists, and their probes. A probe looks at the first bytes only
 * and never fails. */
#ifndef STP_LOAD_READERS_H
#define STP_LOAD_READERS_H

#include "load/load.h"

bool ply_probe(const struct file_bytes *bytes);
bool off_probe(const struct file_bytes *bytes);
bool obj_probe(const struct file_bytes *bytes);
bool las_probe(const struct file_bytes *bytes);
bool pcd_probe(const struct file_bytes *bytes);
bool xyz_probe(const struct file_bytes *bytes);

enum stp_result ply_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud);
enum stp_result off_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud);
enum stp_result obj_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud);
enum stp_result las_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud);
enum stp_result pcd_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud);
enum stp_result xyz_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud);

/* Does a reader of points take these bytes? */
bool load_recognises(const struct file_bytes *bytes);
/* Reads the bytes of a file by the format that they show. path is for messages; options NULL: the
 * defaults. On failure *cloud is untouched. */
enum stp_result load_from_bytes(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, const struct load_options *options,
                                struct cloud *cloud);

/* What a file that is not read is, and what to do about it; false when its kind is not known. */
struct known_format {
    const char *name, *advice;
};
bool known_format_find(const struct file_bytes *bytes, struct known_format *known);

#endif
