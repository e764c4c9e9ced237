/* Pictures in memory: named planes, and EXR and PNG files of them. */
#ifndef STIPPLE_IMAGE_H
#define STIPPLE_IMAGE_H

#include <stipple/result.h>
#include <stipple/view.h>

#ifdef __cplusplus
extern "C" {
#endif

enum stp_channel_type { STP_CHANNEL_FLOAT = 0, STP_CHANNEL_UINT = 1 };

/* One plane: width x height values, rows from the top, no padding. */
struct stp_channel {
    char name[32]; /* EXR name: R G B A Z N.X N.Y N.Z albedo.R P.X weight fragments coverage id */
    enum stp_channel_type type;
    bool half; /* written as half, clamped to +-65504 */
    union {
        float *f;
        uint32_t *u;
    } data;
};

/* A layer of a pixel; its colour is premultiplied by its own alpha, and not by what is before it. A
 * layer is a surface, and has no thickness. */
struct stp_deep_layer {
    float z, color[3], alpha;
};

/* The layers of every pixel, front to back: those of pixel i (rows from the top) are
 * layer[first[i]] to before layer[first[i + 1]]. */
struct stp_deep {
    size_t *first; /* width * height + 1 */
    struct stp_deep_layer *layer;
};

struct stp_image {
    uint32_t width, height;
    unsigned channel_count;
    struct stp_channel *channels;
    bool has_camera; /* the camera and origin below are written as attributes */
    struct stp_camera camera;
    double origin[3]; /* P and worldToCamera are relative to it */
    bool two_sided;
    struct stp_deep *deep; /* owned; NULL: none, or one layer a pixel, which is the planes' */
};

STP_API enum stp_result stp_image_create(const struct stp_env *env, uint32_t width, uint32_t height,
                                         struct stp_image **image);
/* Adds a zeroed plane, of a name that is not there yet; the pointer is valid until the next add. */
STP_API enum stp_result stp_image_add(const struct stp_env *env, struct stp_image *image,
                                      const char *name, enum stp_channel_type type,
                                      struct stp_channel **channel);
STP_API struct stp_channel *stp_image_find(const struct stp_image *image, const char *name);
STP_API void stp_image_destroy(struct stp_image **image);

enum stp_compression {
    STP_COMPRESSION_ZIP = 0,
    STP_COMPRESSION_NONE,
    STP_COMPRESSION_ZIPS,
    STP_COMPRESSION_PIZ
};

struct stp_exr_params {
    enum stp_compression compression;
    const char *software; /* NULL: "stipple <version>" */
    const char *comment;  /* NULL: none; the plan's one sentence, say */
};

/* Writes beside `path` and renames: a failure leaves an old file whole. */
STP_API enum stp_result stp_image_write_exr(const struct stp_env *env,
                                            const struct stp_image *image, const char *path,
                                            const struct stp_exr_params *params);
/* A deep scanline EXR of R G B A, Z and ZBack: the picture's layers, or one a pixel that something
 * is in, from its planes. Without what a background adds behind layers. ZIP stands for ZIPS, the
 * one of the two that deep files have, and so does PIZ. */
STP_API enum stp_result stp_image_write_deep_exr(const struct stp_env *env,
                                                 const struct stp_image *image, const char *path,
                                                 const struct stp_exr_params *params);
/* Any flat EXR of float, half or uint channels; the first part of a multi-part file. */
STP_API enum stp_result stp_image_read_exr(const struct stp_env *env, const char *path,
                                           struct stp_image **image);
/* 8-bit sRGB RGBA (straight alpha) of R G B A after 2^stops. */
STP_API enum stp_result stp_image_write_png(const struct stp_env *env,
                                            const struct stp_image *image, const char *path,
                                            double stops);

#ifdef __cplusplus
}
#endif
#endif
