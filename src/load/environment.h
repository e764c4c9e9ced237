/* Environment maps: latitude-longitude pictures of all that is around a scene, from OpenEXR and
 * Radiance files (docs/glass.md). */
#ifndef STP_LOAD_ENVIRONMENT_H
#define STP_LOAD_ENVIRONMENT_H

#include "base/file.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ENVIRONMENT_MOST_SIDE   16384
#define ENVIRONMENT_MOST_TEXELS ((size_t)1 << 27)
#define ENVIRONMENT_MOST_VALUE  1e9f

/* Rows from the top of the sky down; linear Rec.709. Texel (i, j) spans longitudes
 * [i, i + 1] / width and latitudes [j, j + 1] / height. */
struct environment_map {
    uint32_t width, height;
    float (*texel)[3];
};

/* Told from the content: "#?" is Radiance, else OpenEXR's magic number (gzip of either too). Texels
 * come out by environment_bound. */
enum stp_result environment_read(const struct stp_env *env, const char *path,
                                 struct environment_map *map);
void environment_map_release(struct environment_map *map);

/* Texels as light: NaN and negative values become 0, what is above ENVIRONMENT_MOST_VALUE becomes
 * that. One warning counts them. */
void environment_bound(const struct stp_env *env, const char *path, struct environment_map *map);

/* False, with a line, when no map may have this size; else map->texel is allocated. */
enum stp_result environment_allocate(const struct stp_env *env, const char *path, uint64_t width,
                                     uint64_t height, struct environment_map *map);

/* environment_hdr.c */
bool environment_is_hdr(const struct file_bytes *bytes);
enum stp_result environment_read_hdr(const struct stp_env *env, const char *path,
                                     const struct file_bytes *bytes, struct environment_map *map);
/* environment_exr.cpp: scanline and tiled, every compression that OpenEXR knows, since its C core
 * cannot decode DWAA and DWAB. */
bool environment_is_exr(const struct file_bytes *bytes);
enum stp_result environment_read_exr(const struct stp_env *env, const char *path,
                                     const struct file_bytes *bytes, struct environment_map *map);

#ifdef __cplusplus
}
#endif
#endif
