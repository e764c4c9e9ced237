/* What our flat and deep EXR files share: part 0, its camera and texts, and the file around it. */
#ifndef STP_WRITE_EXR_HEADER_H
#define STP_WRITE_EXR_HEADER_H

#include <stipple/image.h>

#include "write/exr_io.h"

/* zlib's level: 6 takes a third longer for 0.7 % less (docs/exr.md has the table). */
#define EXR_ZIP_LEVEL 2

/* Adds part 0 with the picture's windows. */
exr_result_t exr_begin_part(exr_context_t context, const struct stp_image *image,
                            exr_storage_t storage, exr_compression_t compression);
/* The camera where the picture has one, the colour space, and who wrote it. */
exr_result_t exr_set_attributes(exr_context_t context, const struct stp_image *image,
                                const struct stp_exr_params *params);

/* Everything of a file, from its first part to the last chunk. */
typedef exr_result_t (*exr_part_fn)(const struct stp_env *env, exr_context_t context,
                                    const struct stp_image *image,
                                    const struct stp_exr_params *params, const void *user);
/* Writes beside `path` and renames; params may be NULL. */
enum stp_result exr_write_file(const struct stp_env *env, const struct stp_image *image,
                               const char *path, const struct stp_exr_params *params,
                               exr_part_fn write, const void *user);

/* Sizes that EXR can hold. Logs. */
enum stp_result exr_check_size(const struct stp_env *env, const struct stp_image *image,
                               const char *path);

#endif
