/* BSK 3, after Wu & Kobbelt's optimised subsampling: samples to few elliptical splats with linear
 * normal fields. One stage a file: sites (phong_sites.c), sharp features (phong_crease.c), patches
 * grown from seeds (phong_grow.c, phong_plane.c), few patches that cover all sites (phong_cover.c),
 * and their ellipses, fields and clip lines (phong_ellipse.c, phong_field.c, phong_clip.c,
 * phong_splats.c). docs/phong.md goes from equation to function. */
#ifndef STP_PREPARE_PHONG_FIT_H
#define STP_PREPARE_PHONG_FIT_H

#include <stipple/fit.h>

#include "base/vec.h"
#include "scene/splats.h"

/* Sites: the samples, duplicates joined (phong_sites.c). */

#define SITE_NEAR    8
#define SPACING_RANK 6
#define NO_SITE      UINT32_MAX

/* Samples of one position and one side: of one object, and with normals within 60 degrees. */
struct site {
    double p[3];   /* relative to the cloud's origin */
    float n[3];    /* unit; (0, 0, 0): unknown */
    float spacing; /* distance to the 6th nearest site (fewer in tiny clouds); 0: it is alone */
};

struct fit_cloud {
    const struct splats *samples; /* borrowed */
    double origin[3];
    size_t count;
    struct site *site;
    uint32_t (*near)[SITE_NEAR]; /* same side; NO_SITE where there are fewer */
    uint32_t *first;       /* count + 1: the samples of site i are first[i] up to first[i + 1] */
    bool signs;            /* the samples' normals agree in sign; else only their lines count */
    struct crease *crease; /* NULL: no sharp feature was found */
    uint32_t *crease_of;   /* NULL with it; site -> crease, NO_SITE: none */
};

/* join: false keeps every sample a site of its own, in tolerance 0. */
enum stp_result fit_cloud_build(const struct stp_env *env, const struct splats *samples, bool join,
                                struct fit_cloud *cloud);
void fit_cloud_release(struct fit_cloud *cloud);

/* Planes and patches (phong_plane.c, phong_grow.c). */

/* A plane and the directions of least and most curvature in it. */
struct patch_frame {
    struct vec3 c, n, u, v; /* v = n x u; c relative to the cloud's origin */
    double bend[2];         /* normal curvature along u and v, of the linear normal field */
};

/* Sites that one splat may cover: all within the tolerance of the frame's plane. */
struct patch {
    struct patch_frame frame;
    double shape; /* radius along u over that along v of the ellipse that it grew in */
    uint32_t seed, count;
    uint32_t *member; /* owned; the seed among them */
};

void patches_release(struct patch *patches, size_t count);

/* What a plane is made of: of sites, their places from the first one's, and their normals. */
struct plane_sums {
    double count;
    struct vec3 d, n;
    double dd[6]; /* xx, xy, xz, yy, yz, zz */
};
void plane_sums_add(struct plane_sums *sums, struct vec3 d, struct vec3 n);
/* As patch_plane does: at is the first one's place, and normals are on the side of the hint. */
void plane_of_sums(const struct plane_sums *sums, struct vec3 at, struct vec3 hint,
                   struct patch_frame *frame);

/* The least-squares plane of the members, and the axes of their normals' linear field; its normal
 * is on the side of the seed's. hint: a normal for where the members leave the plane open (fewer
 * than three, or on a line). */
void patch_plane(const struct fit_cloud *cloud, const uint32_t *member, size_t count,
                 struct vec3 hint, struct patch_frame *frame);
void patch_axes(const struct fit_cloud *cloud, const uint32_t *member, size_t count,
                struct patch_frame *frame);
/* A site's normal on the side of n; unknown ones are n. */
struct vec3 site_normal(const struct fit_cloud *cloud, uint32_t i, struct vec3 n);

/* What may not be exceeded within a patch. */
struct fit_limits {
    double tolerance;    /* of a sample from the plane */
    double color;        /* of a component from the seed's; INFINITY: any */
    double begun, ended; /* shares of the whole fit, for its progress: before a cover, and after */
};

/* Grows a patch around each seed: made[i] of seed[i]. On failure nothing is made. */
enum stp_result patches_grow(const struct stp_env *env, const struct fit_cloud *cloud,
                             const struct fit_limits *limits, const uint32_t *seed, size_t count,
                             struct patch *made);

#endif
