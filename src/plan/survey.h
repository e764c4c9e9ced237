/* What a view of a scene amounts to, in the figures that a frame's cost is made of: counted from
 * the splats' bounds on the screen, without drawing a fragment. Of large scenes one splat in so
 * many stands for the rest, unless a bound is asked for: then every block that is touched is known,
 * and a probe of all their cells is the whole picture. The same for any number of threads. */
#ifndef STP_PLAN_SURVEY_H
#define STP_PLAN_SURVEY_H

#include <stipple/plan.h>

#include "scene/scene.h"

#define SURVEY_BLOCK 8 /* pixels a side; as STP_BLOCK */
#define SURVEY_LANES 8 /* threads that a processor runs in step, at least */

/* Where a splat falls: pixels [x0, x1] x [y0, y1] of the picture, a little too many rather than too
 * few, and how many fragments it has there, about. */
struct spot {
    uint32_t x0, y0, x1, y1;
    double fragments;
    bool large; /* takes a workgroup of its own */
};

/* The camera, as a spot needs it. */
struct spot_view {
    const struct stp_scene *scene;
    double rotation[9], translation[3]; /* to x right, y down, z forward, from the origin */
    double fx, fy, cx, cy, near_depth, far_depth, least;
    uint32_t width, height;
    bool orthographic, cull_back;
};
struct spot_view spot_view_of(const struct stp_scene *scene, const struct stp_camera *camera,
                              const struct stp_render_params *params);
/* False: splat i is not in the picture. */
bool spot_find(const struct spot_view *view, size_t i, struct spot *spot);
/* Of how many splats it is true. 0: the scene's are not in memory. */
uint64_t spot_count(const struct stp_env *env, const struct spot_view *view);

struct survey {
    double splats;    /* of the scene */
    double drawn;     /* of them in the picture */
    double small_box; /* pixels in the bounds of those that take a thread each; neighbours in a
                         group of SURVEY_LANES all take as many turns as the largest of them */
    double large, large_box; /* the others, and theirs */
    double fragments;
    double pixels;         /* of the picture */
    double touched;        /* of the blocks that a splat touches */
    double deep;           /* fragments beyond the eighth of a pixel, if a block's are even */
    double overflow;       /* pixels of the blocks that have more than STP_SLOTS a pixel */
    double layers;         /* a touched pixel, in the mean; of transparent scenes, by a probe */
    uint32_t across, down; /* blocks */
    float *mass;           /* fragments of each block; 0: untouched */
};

enum stp_result survey_make(const struct stp_env *env, const struct stp_scene *scene,
                            const struct stp_camera *camera, const struct stp_render_params *params,
                            struct survey *survey);
void survey_release(struct survey *survey);

#endif
