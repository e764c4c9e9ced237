/* Range images: frames of depth and colour, each with its camera and a model of how uncertain its
 * depths are (docs/range.md). */
#ifndef STP_LOAD_RANGE_H
#define STP_LOAD_RANGE_H

#include <stipple/scene.h>

#include "base/file.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RANGE_MOST_SIDE   16384
#define RANGE_MOST_PIXELS ((size_t)1 << 28)
#define RANGE_MOST_FRAMES 1024

/* A picture as its file has it, rows from the top down. */
struct range_image {
    uint32_t width, height;
    unsigned channels; /* 1 or 3 */
    uint32_t maximum;  /* of an integer file: the value of white; 0: floats */
    float *value;      /* width * height * channels */
};
void range_image_release(struct range_image *image);

/* What a picture is read for: of an EXR, its channels Z or Y, or R G B. */
enum range_plane { RANGE_DEPTH, RANGE_COLOR };

/* PNG of 8 or 16 bits, PGM and PPM (binary), EXR; told from the content, gzip of any. A depth has
 * one channel; a colour that has one is grey. Alpha is left out. On failure *image is untouched. */
enum stp_result range_image_read(const struct stp_env *env, const char *path,
                                 enum range_plane plane, struct range_image *image);
enum stp_result range_image_from_bytes(const struct stp_env *env, const char *path,
                                       const struct file_bytes *bytes, enum range_plane plane,
                                       struct range_image *image);
/* The formats. range_allocate refuses sizes that no frame may have. */
enum stp_result range_allocate(const struct stp_env *env, const char *path, uint64_t width,
                               uint64_t height, unsigned channels, struct range_image *image);
enum stp_result range_read_png(const struct stp_env *env, const char *path,
                               const struct file_bytes *bytes, struct range_image *image);
enum stp_result range_read_exr(const struct stp_env *env, const char *path,
                               const struct file_bytes *bytes, enum range_plane plane,
                               struct range_image *image);

/* Deviation of a depth z along its ray, in planar depth. */
enum range_sensor_kind {
    RANGE_STRUCTURED_LIGHT = 0, /* sigma z^2 */
    RANGE_STEREO,               /* sigma_disparity z^2 / (fx baseline) */
    RANGE_CONSTANT,             /* sigma */
};
#define RANGE_KINECT_SIGMA    1.43e-3 /* per metre: Khoshelham and Elberink 2012 */
#define RANGE_SIGMA_DISPARITY 0.5     /* pixels */

struct range_sensor {
    enum range_sensor_kind kind;
    double sigma;
    double sigma_disparity, baseline;
};

/* x right, y down, z forward; (u, v) is the ray ((u - cx) / fx, (v - cy) / fy, 1), pixel centres at
 * +0.5. */
struct range_camera {
    double fx, fy, cx, cy;
    double to_world[16]; /* row-major, rigid */
};

struct range_frame {
    struct range_camera camera;
    struct range_sensor sensor;
    uint32_t width, height;
    float *depth;      /* planar, scene units; 0: none */
    float (*color)[3]; /* linear */
    size_t not_finite; /* depths that were NaN, infinite or negative; now 0 */
};

/* Frames are in the order in which they are given. */
struct range {
    unsigned count;
    struct range_frame *frame;
    double uncertainty; /* times every deviation */
    bool by_views;      /* colours of all frames that see a point, by their angles */
};
void range_release(struct range *range);

/* How a file's numbers become depths. */
struct range_units {
    double depth_scale; /* depth = value / depth_scale */
    double baseline;    /* > 0: depth = fx baseline / (value / depth_scale + offset) */
    double disparity_offset;
    double margin; /* pixels at the edges of a frame that are left out */
};

/* Both pictures of a frame whose camera and sensor are set; sizes must agree. On failure the frame
 * holds no pictures. */
enum stp_result range_frame_read(const struct stp_env *env, const char *depth, const char *color,
                                 const struct range_units *units, enum stp_transfer transfer,
                                 struct range_frame *frame);

double range_deviation(const struct range_frame *frame, double depth);

/* A file of lines "key value"; # begins a comment. Keys: fx fy cx cy depth_scale. Centres of pixels
 * are at whole numbers in it. */
enum stp_result range_intrinsics_from_bytes(const struct stp_env *env, const char *path,
                                            const struct file_bytes *bytes,
                                            struct range_camera *camera, struct range_units *units);
/* Lines "tx ty tz qx qy qz qw", camera to world; # begins a comment. *poses gets one matrix a line,
 * owned by the caller. */
enum stp_result range_poses_from_bytes(const struct stp_env *env, const char *path,
                                       const struct file_bytes *bytes, double (**poses)[16],
                                       unsigned *count);
/* To a rigid matrix; false: not finite, or no rotation. The quaternion need not be unit. */
bool range_pose(const double translation_quaternion[7], double to_world[16]);

#ifdef __cplusplus
}
#endif
#endif
