/* The pyramid on the CPU, for the probe: the picture that the device's passes make
 * (docs/pyramid.md), in single precision where it keeps texels, with one sample a pixel. Level 0 is
 * the points that won their pixels; texels are made of them when they are asked for. */
#ifndef STP_PLAN_PYRAMID_PROBE_H
#define STP_PLAN_PYRAMID_PROBE_H

#include "plan/offer.h"

/* Pixels of the largest picture that is drawn here: with half a gigabyte. */
#define PYRAMID_MOST_PIXELS ((uint64_t)1 << 24)
#define PYRAMID_NOTHING     UINT64_MAX /* the key of a pixel that no point fell into */

/* As glsl/lib/pyramid.glsl has them, in the device's camera frame: y down, z forward. */
struct pyramid_texel {
    float depth; /* INFINITY: nothing is here */
    float extent, radius;
    float normal[3], color[3];
    float center[2]; /* from the texel's middle, pixels */
    uint32_t id;     /* of the frontmost */
    bool full, rim;  /* rim: pushed, and beside it nothing is */
    bool exact;      /* the disc is one point's */
    bool inside;     /* pushed, and one point's disc holds all of the texel */
};

struct pyramid {
    const struct stp_plan *plan;
    const struct view *view;
    uint64_t *key; /* depth, then id; of the grid's pixels, row by row */
    unsigned levels;
    uint32_t width[STP_LEVELS], height[STP_LEVELS];
    struct pyramid_texel *texel[STP_LEVELS]; /* [0] is NULL */
};

/* False: a pyramid too large to be drawn here, or of points that pass through the device's memory
 * in chunks, whose transfer has no price. True of any other method. */
bool pyramid_can_judge(const struct stp_plan *plan);

/* pyramid_levels.c: points to pixels, and all levels pulled and pushed, but for the push of level
 * 0.
 */
enum stp_result pyramid_make(const struct stp_env *env, const struct stp_plan *plan,
                             const struct view *view, struct pyramid *pyramid);
void pyramid_release(struct pyramid *pyramid);

/* Of texel (x, y), counted from the level's first; nothing beyond its edges. */
struct pyramid_texel pyramid_load(const struct pyramid *p, unsigned level, int64_t x, int64_t y);
/* A point's texel as its pixel would have it, its centre apart, pixels of the picture. False:
 * culled, or outside near and far. */
bool pyramid_point(const struct pyramid *p, size_t id, struct pyramid_texel *t, double at[2]);
/* Of a level's first texel, in texels. */
int64_t pyramid_origin(const struct pyramid *p, unsigned level, int axis);
/* The middle of a texel, pixels of the picture. */
void pyramid_middle(const struct pyramid *p, unsigned level, int64_t x, int64_t y, double at[2]);

/* Where the ray through picture position q meets the texel's disc; center: of the disc, pixels. */
struct pyramid_meeting {
    bool hit;
    double depth; /* of the disc's plane there */
    double away2; /* squared distance of the plane from the centre; INFINITY: not met */
    double reach; /* the disc's radius, with the floor */
};
struct pyramid_meeting pyramid_meet(const struct pyramid *p, const struct pyramid_texel *t,
                                    const double center[2], const double q[2]);

/* pyramid_push.c: what the level `coarse` says of place q, in texel (x, y) of the level below.
 */
struct pyramid_push {
    double weight; /* 0: nothing covers the place */
    double depth, front, reach, before;
    double normal[3], color[3]; /* weighted sums */
    double center[2];           /* of the mean disc, pixels */
    struct pyramid_texel disc;
};
struct pyramid_push pyramid_push(const struct pyramid *p, unsigned coarse, int64_t x, int64_t y,
                                 const double q[2], bool hiding);

#endif
