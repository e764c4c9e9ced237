/* Files to volumes: a regular grid of scalars. The format is found from the content; a raw file has
 * none, and is described by the caller or by a .json beside it (docs/volumes.md). */
#ifndef STP_LOAD_VOLUME_H
#define STP_LOAD_VOLUME_H

#include <stipple/scene.h>

#include "base/file.h"
#include "load/record_type.h"

/* Values at the centres of voxels, x fastest: value[i + nx (j + ny k)] is at
 * origin + (i, j, k) * spacing. Axes are those of the world. */
struct grid {
    uint32_t dims[3];
    double spacing[3], origin[3];
    float *value;     /* NaN and infinite values are kept */
    double low, high; /* of the finite values; 0, 0 where there are none */
    size_t not_finite;
    enum stp_up up;
    char format[32];
};
void grid_release(struct grid *grid);
size_t grid_count(const struct grid *grid);

/* What a header says of its voxels. Axes are the file's, fastest first. */
struct voxels {
    uint64_t dims[3];
    double spacing[3];      /* > 0 */
    double direction[3][3]; /* of file axis i in the world; all 0: the i-th axis */
    double origin[3];       /* of the first voxel's centre */
    bool has_origin;        /* else half a spacing: the volume begins at 0 */
    enum record_type type;
    bool big_endian;
    double slope, intercept; /* value * slope + intercept; slope 0: 1, 0 */
    enum stp_up up;
    char format[32];
};

/* Bytes [offset, offset + size of the voxels) of `bytes` to a grid along the world's axes: a file
 * axis becomes the world axis nearest to it, turned where it runs backwards. Fewer bytes than the
 * header claims are an error. On failure *grid is untouched. */
enum stp_result grid_from_voxels(const struct stp_env *env, const char *path,
                                 const struct file_bytes *bytes, size_t offset,
                                 const struct voxels *voxels, struct grid *grid);
/* What lies behind a header, in its own file or another: may be packed by zlib; then skip bytes are
 * left out, or, where skip is -1, all but the last that the voxels take. */
struct voxel_bytes {
    const struct file_bytes *bytes;
    size_t begin;
    bool packed;
    double skip;
};
enum stp_result grid_from_bytes(const struct stp_env *env, const char *path,
                                const struct voxel_bytes *from, const struct voxels *voxels,
                                struct grid *grid);
/* How many bytes of a file hold its header of `begin` bytes, what is skipped and the voxels, which
 * pass voxels_check; FILE_ALL where skip is -1. */
size_t voxels_end(const struct voxels *voxels, size_t begin, double skip);
/* Counts and ranges that any reader's header must pass. */
enum stp_result voxels_check(const struct stp_env *env, const char *path,
                             const struct voxels *voxels);
/* low, high and not_finite from the values. */
void grid_measure(struct grid *grid);

/* One format. */
struct volume_reader {
    bool (*probe)(const struct file_bytes *bytes);
    /* From the beginning of a file, which has passed the probe: how much of it there is to read;
     * FILE_ALL: not known. NULL: no such header. */
    size_t (*stated)(const struct file_bytes *head);
    enum stp_result (*read)(const struct stp_env *env, const char *path,
                            const struct file_bytes *bytes, struct grid *grid);
};
bool nifti_probe(const struct file_bytes *bytes);
bool nrrd_probe(const struct file_bytes *bytes);
bool metaimage_probe(const struct file_bytes *bytes);
bool inrimage_probe(const struct file_bytes *bytes);
size_t nifti_stated(const struct file_bytes *head);
size_t nrrd_stated(const struct file_bytes *head);
enum stp_result nifti_read(const struct stp_env *env, const char *path,
                           const struct file_bytes *bytes, struct grid *grid);
enum stp_result nrrd_read(const struct stp_env *env, const char *path,
                          const struct file_bytes *bytes, struct grid *grid);
enum stp_result metaimage_read(const struct stp_env *env, const char *path,
                               const struct file_bytes *bytes, struct grid *grid);
enum stp_result inrimage_read(const struct stp_env *env, const char *path,
                              const struct file_bytes *bytes, struct grid *grid);
/* NULL: not a volume with a header that is read. */
const struct volume_reader *volume_reader_find(const struct file_bytes *bytes);
/* For file_use.stated, of a file of any kind. */
size_t volume_stated(const struct file_bytes *head);

/* What a raw file is: from the caller's params where they say, else from the .json beside it. */
struct raw_volume {
    bool known; /* dims are */
    struct voxels voxels;
};
/* Looks for PATH.json, then for the stem's .json, then for volumes.json in the file's folder; an
 * object of `dims`, `dtype`, `spacing` and `up`, or one that holds such objects by the files'
 * names. Neither params nor a file: *raw is not known, which is no failure. */
enum stp_result raw_volume_find(const struct stp_env *env, const char *path,
                                const struct stp_volume_params *params, struct raw_volume *raw);
/* A header's own words for a type ("uint8", "int16 little-endian", "MET_USHORT"); false: none. */
bool voxel_type_read(const char *text, enum record_type *type, bool *big_endian);

/* Any of these. raw may be NULL. A file with a header is read by it whatever raw says, with
 * spacings of params in place of its own where they are given. */
enum stp_result volume_from_bytes(const struct stp_env *env, const char *path,
                                  const struct file_bytes *bytes, const struct raw_volume *raw,
                                  const struct stp_volume_params *params, struct grid *grid);

/* A header of lines "key: value" or "key = value", up to a blank line or to a key that ends it. */
struct header {
    const char *begin, *at, *end;
    char separator;
};
struct header_line {
    char key[40], value[256]; /* trimmed, cut to fit */
};
/* False at the end. Lines without the separator are stepped over. */
bool header_next(struct header *header, struct header_line *line);
/* Exactly `count` numbers, with spaces, commas or brackets between. */
bool header_numbers(const char *text, unsigned count, double *values);
/* The file that a detached header names, read; its name may be relative to the header's folder. Of
 * gzip no more than `most` bytes are of use. */
enum stp_result header_data_file(const struct stp_env *env, const char *path, const char *name,
                                 size_t most, struct file_bytes *bytes);

#endif
