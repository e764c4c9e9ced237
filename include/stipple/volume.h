/* Volumes: regular grids of scalars, drawn as media through a transfer function. */
#ifndef STIPPLE_VOLUME_H
#define STIPPLE_VOLUME_H

#include <stipple/result.h>

#ifdef __cplusplus
extern "C" {
#endif

enum stp_voxel_type {
    STP_VOXEL_AUTO = 0, /* what the header or the .json beside the file says */
    STP_VOXEL_U8,
    STP_VOXEL_U16,
    STP_VOXEL_I16,
    STP_VOXEL_F32,
};

/* How volumes are read and shown. */
struct stp_volume_params {
    uint32_t dims[3];         /* of a raw file; 0 0 0: from the .json beside it */
    enum stp_voxel_type type; /* of a raw file, little-endian */
    double spacing[3];        /* distance of voxels, scene units; 0 0 0: the file's, else 1 1 1 */
    const char *transfer_function; /* a preset ("grey", "bone", "flesh", "hot"), or the path of a
                                      JSON file (docs/volumes.md); NULL or "auto": found from
                                      the histogram */
    bool unshaded;                 /* colours as they are, without light on gradients */
};

/* A volume handed over in memory; value is borrowed for the call only. */
struct stp_volume {
    uint32_t dims[3];
    double spacing[3], origin[3]; /* origin: the centre of the first voxel */
    const float *value;           /* x fastest; NaN: nothing is there */
};

/* What is known of a scene's volume; facts.points counts its voxels, facts.splats those with any
 * opacity. */
struct stp_volume_facts {
    uint32_t dims[3]; /* 0 0 0: the scene has no volume */
    double spacing[3];
    double low, high;           /* of the values */
    double opacity_max;         /* of any voxel, per unit of the finest spacing */
    char transfer_function[32]; /* its name */
};

#ifdef __cplusplus
}
#endif
#endif
