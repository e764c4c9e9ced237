/* Ids of the specialisation constants, for C and GLSL. A number that comes twice is an error of the
 * shader compiler; one that is left out has no name in src/plan/print.c. */
#ifndef STP_SHARED_CONSTANTS_H
#define STP_SHARED_CONSTANTS_H

#define PLAN_GROUPS        0
#define PLAN_VORONOI       1
#define PLAN_PACKED        2
#define PLAN_GAUSS         3
#define PLAN_TWO_SIDED     4
#define PLAN_CULL_BACK     5
#define PLAN_FLOOR         6
#define PLAN_ORTHOGRAPHIC  7
#define PLAN_HAS_COLOR     8
#define PLAN_HAS_OBJECTS   9
#define PLAN_HAS_UNKNOWN   10
#define PLAN_HEAD_LIGHT    11
#define PLAN_LOCAL_VIEWER  12
#define PLAN_BACKGROUND    13
#define PLAN_AOVS          14
#define PLAN_SQUARINGS     15
#define PLAN_REPAIR        16
#define PLAN_KEY_IDS       17
#define PLAN_ATOMIC64      18
#define PLAN_LAYERED       19
#define PLAN_FLOAT64       20
#define PLAN_SAMPLE_GRID   21
#define PLAN_LANES         22
#define PLAN_AXIS_WALKS    23
#define PLAN_AXIS_CUT      24
#define PLAN_UNLIT         25
#define PLAN_AXIS_WALK     26 /* of a pass */
#define PLAN_AXIS_PART     27
#define PLAN_OPACITY       28 /* 0: all is opaque; 1: one for all; 2: each splat's own */
#define PLAN_MIXED         29 /* some splats are opaque, in a scene that is transparent */
#define PLAN_OPTICS        30
#define PLAN_HOST_DEPTH    31 /* enum plan_host_depth */
#define PLAN_DEEP          32 /* layers are kept one by one */
#define PLAN_PHONG         33 /* 0: all are discs; 1: ellipses; 2: some have clip lines */
#define PLAN_SHADE         34 /* enum stp_shade */
#define PLAN_LIGHT_CUBE    35
#define PLAN_AXIS_SHAPE    36 /* enum axis_shape */
#define PLAN_CULL_CLUSTERS 37 /* pyramid: of points, STP_CLUSTER at once */
#define PLAN_RIM_FAR       38 /* pyramid: discs reach beyond the pixels beside their own */
#define PLAN_CUTS          39 /* near or far may cut a splat: of this view, or of one to come */
#define PLAN_BINS          40 /* two-pass: large splats are drawn block by block */
#define PLAN_COLOR_CODES   41 /* exact: colours are summed as integers of 12 bits */
#define PLAN_CONSTANTS     42

#endif
