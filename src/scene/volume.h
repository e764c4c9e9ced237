/* A scene's volume: the grid, the transfer function, and, once prepared, the kernels of its voxels
 * (docs/axis.md). A voxel's kernel is the Gaussian
 *   a exp(-m^2 / 2),  m^2 = sum over the axes of (x - centre)^2 / (KERNEL_SIGMA spacing)^2,
 * cut where a ray's least m is beyond KERNEL_REACH; a makes what is left integrate to the volume of
 * a voxel, so that kernels of a homogeneous grid add up to 1. */
#ifndef STP_SCENE_VOLUME_H
#define STP_SCENE_VOLUME_H

#include <math.h>

#include "load/range.h"
#include "load/volume.h"

#define KERNEL_SIGMA 0.55 /* spacings */
#define KERNEL_REACH 3.0  /* sigmas: 1.65 spacings */
#define LEAST_ALPHA  1e-4 /* HM 5: smaller contributions are dropped */

#define TRANSFER_POINTS 256
struct transfer_point {
    double value;
    float color[3]; /* linear */
    float opacity;  /* per unit of the finest spacing */
};
struct transfer_function {
    char name[32];
    bool of_range; /* values are 0 to 1 from the grid's lowest to its highest */
    unsigned count;
    struct transfer_point point[TRANSFER_POINTS]; /* ascending by value */
};

/* Linear between the points, constant beyond them. NaN: opacity 0. */
struct transfer_point transfer_at(const struct transfer_function *function, double value);
/* "grey", "bone", "flesh", "hot"; false: no such preset. */
bool transfer_preset(const char *name, struct transfer_function *function);
/* A JSON file or an object of one. */
enum stp_result transfer_load(const struct stp_env *env, const char *path,
                              struct transfer_function *function);

/* A frame that sees an ellipsoid's centre: 1 / sigma^2 of its depth there, and how well that
 * agrees, relative to the ellipsoid's own frame. */
struct kernel_source {
    uint32_t frame;
    float weight;
};

/* What prepare makes of the voxels that have any opacity, in order of their index in the grid; or
 * of the pixels of range images, frame after frame: `voxel` is then the pixel's index over all
 * frames.
 */
struct kernels {
    size_t count;
    uint32_t *voxel;
    float (*color)[3];  /* linear, before light */
    float *tau;         /* optical depth per scene unit: -ln(1 - alpha) / finest spacing */
    float (*normal)[3]; /* against the gradient, unit, (0, 0, 0) where there is none; NULL: unshaded
                         */
    /* Of range images only: centres, the axes of the ellipsoids (world: across, down, along the
     * ray; each one deviation), and the sources of kernel i from source_first[i] on, its own frame
     * first; their colours where colours are by views. */
    double (*place)[3];
    float (*axes)[3][3];
    uint32_t *source_first;
    struct kernel_source *source;
    float (*source_color)[3];
};
void kernels_release(struct kernels *kernels);

/* Of a grid; or of range images, and then there are neither grid nor transfer function. */
struct volume {
    struct grid grid;
    struct range range;                /* count 0: of a grid */
    struct transfer_function transfer; /* count 0: found by prepare from the histogram */
    bool automatic, unshaded, clipped;
    double clip_box[6]; /* where clipped */
    struct kernels kernels;
    uint32_t low[3], high[3]; /* of the kernels' voxels, both included */
    double opacity_max;
};
void volume_release(struct volume **volume);

static inline double volume_finest(const struct grid *grid)
{
    const double *s = grid->spacing;
    double least = s[0] < s[1] ? s[0] : s[1];
    return least < s[2] ? least : s[2];
}

static inline bool volume_is_range(const struct volume *volume)
{
    return volume->range.count > 0;
}

/* The indices of a voxel along the axes. */
static inline void voxel_place(const struct grid *grid, uint32_t voxel, uint32_t at[3])
{
    at[0] = voxel % grid->dims[0];
    at[1] = voxel / grid->dims[0] % grid->dims[1];
    at[2] = voxel / grid->dims[0] / grid->dims[1];
}

/* a: exp(-REACH^2 / 2) of the integral is cut away. */
static inline double kernel_amplitude(void)
{
    double kept = -expm1(-0.5 * KERNEL_REACH * KERNEL_REACH);
    return 1 / (pow(2 * M_PI, 1.5) * KERNEL_SIGMA * KERNEL_SIGMA * KERNEL_SIGMA * kept);
}

struct stp_scene;

/* Takes ownership of *grid (it is zeroed); on failure it stays the caller's. A scene holds one
 * volume, or points. object may be NULL. */
enum stp_result scene_add_volume(const struct stp_env *env, struct stp_scene *scene,
                                 struct grid *grid, const struct stp_volume_params *params,
                                 const struct stp_material *material);
/* The same for range images, which it takes ownership of. */
enum stp_result scene_add_range(const struct stp_env *env, struct stp_scene *scene,
                                struct range *range);
/* Params' transfer function: a preset, a file, or automatic. */
enum stp_result volume_set_transfer(const struct stp_env *env, struct volume *volume,
                                    const struct stp_volume_params *params);

#endif
