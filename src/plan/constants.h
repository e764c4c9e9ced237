/* Specialisation constants of the shaders, and what some of them hold. */
#ifndef STP_PLAN_CONSTANTS_H
#define STP_PLAN_CONSTANTS_H

/* Specialisation constants; the order of glsl/lib/common.glsl. */
enum plan_constant {
    PLAN_GROUPS,
    PLAN_VORONOI,
    PLAN_PACKED,
    PLAN_GAUSS,
    PLAN_TWO_SIDED,
    PLAN_CULL_BACK,
    PLAN_FLOOR,
    PLAN_ORTHOGRAPHIC,
    PLAN_HAS_COLOR,
    PLAN_HAS_OBJECTS,
    PLAN_HAS_UNKNOWN,
    PLAN_HEAD_LIGHT,
    PLAN_LOCAL_VIEWER,
    PLAN_BACKGROUND,
    PLAN_AOVS,
    PLAN_SQUARINGS,
    PLAN_REPAIR,
    PLAN_KEY_IDS,
    PLAN_ATOMIC64,
    PLAN_LAYERED,
    PLAN_FLOAT64,
    PLAN_SAMPLE_GRID,
    PLAN_LANES,
    PLAN_AXIS_WALKS,
    PLAN_AXIS_CUT,
    PLAN_UNLIT,
    PLAN_AXIS_WALK, /* of a pass */
    PLAN_AXIS_PART,
    PLAN_OPACITY, /* 0: all is opaque; 1: one for all; 2: each splat's own */
    PLAN_MIXED,   /* some splats are opaque, in a scene that is transparent */
    PLAN_OPTICS,
    PLAN_HOST_DEPTH, /* enum plan_host_depth */
    PLAN_DEEP,       /* layers are kept one by one */
    PLAN_PHONG,      /* 0: all are discs; 1: ellipses; 2: some have clip lines */
    PLAN_SHADE,      /* enum stp_shade */
    PLAN_LIGHT_CUBE,
    PLAN_AXIS_SHAPE,    /* enum axis_shape */
    PLAN_CULL_CLUSTERS, /* pyramid: points are culled by STP_CLUSTER before they are projected */
    PLAN_RIM_FAR,       /* pyramid: discs reach beyond the pixels beside their own */
    PLAN_CUTS,          /* near or far may cut a splat: of this view, or of one to come */
    PLAN_BINS,          /* two-pass: large splats are drawn block by block */
    PLAN_CONSTANTS
};

/* Bits of PLAN_AOVS: albedo and weight; id, fragments and what goes with them; layers too. */
#define PLAN_AOVS_ALBEDO 1u
#define PLAN_AOVS_ID     2u
#define PLAN_AOVS_LAYERS 4u

/* What the depth of a host's image is copied as, where it cuts layers. */
enum plan_host_depth {
    PLAN_HOST_DEPTH_NONE,
    PLAN_HOST_DEPTH_FLOAT,
    PLAN_HOST_DEPTH_24, /* in the low bits of a word */
    PLAN_HOST_DEPTH_16,
};

#endif
