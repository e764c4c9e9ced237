/* Range images of a scene: files to frames, and a frame's pixels to places in the world. */
#ifndef STP_SCENE_RANGE_H
#define STP_SCENE_RANGE_H

#include "base/json.h"
#include "base/vec.h"
#include "load/range.h"
#include "scene/scene.h"

/* The footprint of a pixel: sigma = RANGE_SIGMA pixels, so that a lattice of them is even (the same
 * as of voxels: docs/axis.md). */
#define RANGE_SIGMA       0.55
#define RANGE_MOST_SLOPE  4    /* depth over width of a footprint: 76 degrees; steeper is an edge */
#define RANGE_LEAST_DEPTH 0.05 /* footprints: the least deviation along the ray */

/* Optical depth of a surface, seen from where it was measured; shared among the frames that see it.
 */
#define RANGE_DEPTH_OF_SURFACE 2.0
/* Frames see one surface where their depths differ by less than this many deviations of both. Poses
 * that are a little off must not make two surfaces of one, or each would hide the other. */
#define RANGE_AGREEMENT 8.0
/* Angles between the eye's ray and a source's, as chords, at which a weight falls to a half (of an
 * ellipsoid), to a quarter (of a colour). */
#define RANGE_ANGLE       0.05
#define RANGE_COLOR_ANGLE 0.06
#define RANGE_SOURCES     16 /* of an ellipsoid, at most: the heaviest */

/* A reading in the world: its place, what a step to the next pixel across and down does to it on
 * the surface around it, and one deviation along its ray. */
struct range_pixel {
    struct vec3 place, across, down, along;
    double depth, deviation;
};
/* False: no reading. */
bool range_pixel(const struct range *range, unsigned frame, uint32_t u, uint32_t v,
                 struct range_pixel *pixel);

/* Where a frame sees a place of the world: picture position and depth; false: behind it, or outside
 * of its picture. */
bool range_project(const struct range_frame *frame, struct vec3 world, double at[2], double *depth);
struct vec3 range_eye(const struct range_frame *frame);

/* The object of "range" of a scene .json, a path or an object; what params say wins. *splats is
 * never AUTO. */
enum stp_result range_from_json(const struct json_at *root, const cJSON *json,
                                const struct stp_load_params *params, struct range *range,
                                enum stp_range_splats *splats);
/* A folder of intrinsics.txt, pose.txt, depth/N and color/N (docs/range.md). */
bool range_is_folder(const char *path);
enum stp_result range_from_folder(const struct stp_env *env, const char *path,
                                  const struct stp_load_params *params, struct range *range);
/* The files of "poses_file" and "intrinsics_file", and of a folder. */
enum stp_result range_load_intrinsics(const struct stp_env *env, const char *path,
                                      struct range_camera *camera, struct range_units *units);
enum stp_result range_load_poses(const struct stp_env *env, const char *path, double (**poses)[16],
                                 unsigned *count);

/* Into the scene: ellipsoids, or an object of plain discs. Takes ownership of *range. Gives the
 * scene the camera of the first frame when it has none. */
enum stp_result range_show(const struct stp_env *env, struct stp_scene *scene, struct range *range,
                           enum stp_range_splats splats, const struct stp_load_params *params);

#endif
