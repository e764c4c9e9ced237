/* The frame's constants: one uniform block, read by C and by every shader. Offsets are asserted on
 * the C side (src/passes/constants.c). Scalar layout. */
#ifndef STP_SHARED_FRAME_H
#define STP_SHARED_FRAME_H

#ifdef __cplusplus
#error "C or GLSL only"
#endif

#ifdef GL_core_profile
#define STP_ADDRESS(type, name) type name
#define STP_STRUCT(type)        type
#ifdef WITH_FLOAT64
#define STP_DOUBLE double
#else
#define STP_DOUBLE uint64_t
#endif
#else
#include <stdint.h>
#define STP_ADDRESS(type, name) uint64_t name
#define STP_STRUCT(type)        struct type
#define STP_DOUBLE              double
#define uint                    uint32_t
#endif

/* Pixels live in blocks of BLOCK x BLOCK: a splat touches few pages, a workgroup takes a block. */
#define STP_BLOCK       8
#define STP_GROUP       64   /* threads of a workgroup */
#define STP_LARGE_AREA  1024 /* pixels of bounds above which a splat takes a workgroup */
#define STP_LARGE_GROUP 128
#define STP_BIN_AREA    512 /* with BINS: above which it is drawn block by block */
/* Large splats, at most, that are drawn block by block; and entries of their lists, a block in the
 * mean. A block's list has an entry a splat: fewer than the 65535 turns of a loop that lavapipe
 * allows; and all that splats may ask for (STP_WORK_ENTRIES), in the 2^16 blocks of a tile, stays
 * below 2^32. */
#define STP_BIN_SPLATS         32768u
#define STP_BIN_ENTRIES        64u
#define STP_BIN_GROUP          8 /* threads that bin a splat */
#define STP_BIN_DISC           5 /* vectors of a record: lib/record.glsl */
#define STP_BIN_ELLIPSE        9
#define STP_BIN_CLIPPED        10
#define STP_ROW                32768u /* workgroups along x; more go along y */
#define STP_SLOTS              64 /* fragments a pixel that `exact` keeps before its second way */
#define STP_LIST_SLOTS         4  /* a pixel in the mean, behind all slots: lists of deep pixels */
#define STP_LIST_SHARE         8  /* a block takes at most one of so many parts of them */
#define STP_LIST_NONE          0xffffffffu
#define STP_SUM_WORDS          10 /* 64-bit words of a pixel's fixed-point sums */
#define STP_SUM_WORDS_PLAIN    6  /* without colours and fragments */
#define STP_LIGHTS             8
#define STP_DEPTH_BITS         24         /* of quantised depths */
#define STP_RHO_MOST           4095       /* of quantised rho^2 */
#define STP_SLAB_MOST          262142     /* keys with ids hold 18 bits of slab */
#define STP_WEIGHT_UNIT        16777216.0 /* of exact's sums of weights and normals */
#define STP_PART_BITS          20         /* of the lower part of a term of sums */
#define STP_ENVIRONMENT_LEVELS 12
/* What PLAN_OPTICS holds, or-ed. */
#define STP_OPTICS_SURFACE  1u   /* surfaces meet the environment */
#define STP_OPTICS_BEHIND   2u   /* it is the background */
#define STP_OPTICS_ROUGH    4u   /* there is more than its sharp level */
#define STP_OPTICS_BETWEEN  8u   /* levels are mixed */
#define STP_OPTICS_DISPERSE 16u  /* channels refract apart */
#define STP_OPTICS_MIRRORS  32u  /* some surface has a reflectance */
#define STP_OPTICS_GLASS    64u  /* what is transparent refracts */
#define STP_OPTICS_MULTI    128u /* by all its layers */
#define STP_OPTICS_ABSORBS  256u /* some surface has an absorption */
#define STP_LIGHT_CUBE      128u /* texels along an edge of a face; neighbours share their edges */
#define STP_NO_ID           0xffffffffu
/* Of a splat's tag: group, flags, object. */
#define STP_TAG_GROUP     63u
#define STP_TAG_INVISIBLE 64u         /* opacity 0: it has no fragments */
#define STP_TAG_OPAQUE    128u        /* opacity 1, in a scene that is transparent elsewhere */
#define STP_TRAITS_IDS    134217728u  /* exact: ids that fit a packed key, and above them a bit */
#define STP_NORMAL_MASK   0xfffffffu  /* of a packed key, and of a splat's traits */
#define STP_COLOR_STEPS   4095        /* from 0 to 1, of a splat's traits */
#define STP_NO_NORMAL     0x80008000u /* of a point: no octahedral normal is packed to this */
#define STP_NO_POINT      0x7fffffffu /* key words of a pixel that no point fell into */
#define STP_RIM_DEPTH     0x7f800001u /* then, of an open one: farther than all */
#define STP_RIM_NONE      0x7ffffffeu /* and no point */
#define STP_RIM_REACH     255         /* pixels: as far as a disc is looked for there */
#define STP_POINT_RUN     512         /* points that a workgroup projects */
#define STP_CLUSTER       64          /* points that are culled together */
#define STP_LEVELS        16          /* of a pyramid, at most */
#define STP_BLOCK_LEVEL   3           /* whose texels are blocks */
/* Descriptor bindings of what is fetched as texels; the order is enum plan_slot's. */
#define STP_BINDING_PYRAMID    6
#define STP_BINDING_ATTRIBUTES 7
#define STP_BINDING_POINTS     8
#define STP_BINDING_RADII      9
#define STP_AXIS_PART          262144u /* entries of a block's list that one pass takes */
#define STP_AXIS_WIDTH         4       /* of a block of pixels, which eight threads share */
#define STP_AXIS_HEIGHT        4
#define STP_AXIS_ROWS          (STP_AXIS_WIDTH * STP_AXIS_HEIGHT / 8) /* pixels of a thread */
#define STP_AXIS_REACH         3.0  /* of kernels, in deviations */
#define STP_AXIS_LEAST_ALPHA   1e-4 /* of a fragment */
#define STP_AXIS_MERGE_BLEND   0
#define STP_AXIS_MERGE_CLIP    1
#define STP_ELLIPSOID          5 /* vectors of one: centre, tau; colour; then its axes */
#define STP_ELLIPSOID_DRAWN    4 /* in the camera frame: centre, tau; colour; then its factor */
#define STP_GAUSSIAN           4 /* of a surface's splat on the screen: lib/gaussian.glsl */
#define STP_GAUSSIAN_CLIPPED   6 /* with its clip lines */
#define STP_BINDING_AXIS_COLOR 10
#define STP_BINDING_AXIS_DEPTH 11
#define STP_BINDING_SLOTS      12
#define STP_BINDING_SLOT_IDS   13
#define STP_BINDING_PROJECTED  14
#define STP_BINDING_ORDER      15
#define STP_BINDING_CLUSTERS   16
#define STP_BINDING_TRAITS     17
#define STP_ID_WORDS           4 /* of out_id a pixel, with several samples; else 2; layers apart */
#define STP_DEEP_WINDOW        16 /* layers of a pixel that are kept at once: RECORD_TURNS */
#define STP_DEEP_FLOATS        5
#define STP_DEEP_MENDED        0x80000000u /* the ray is mended: its layers come a turn each */
/* Sums with no fragment: depth +Inf, id the largest int. Neither half is a NaN of a depth's, see
 * depth_order in glsl/lib/splat.glsl. */
#define STP_SUMS_NONE 0x7f8000007ffffffful

/* Words of the work buffer: indirect arguments, then counters, then the block flags and list. */
#define STP_WORK_LARGE         0 /* x y z count of large splats, or of STP_WORK_RIM's large discs */
#define STP_WORK_BLOCKS        4 /* x y z count of touched blocks */
#define STP_WORK_LEVEL_1       8 /* x y z: pyramid, texels of level 1 in touched blocks; then level 2 */
#define STP_WORK_FAR           11 /* pyramid, not 0: a disc reaches beyond the pixels beside its own */
#define STP_WORK_LEVEL_2       12
#define STP_WORK_LOOK          16 /* x y z count of blocks with pixels to be looked at again */
#define STP_WORK_RIM           20 /* x y z count of points that may reach an open pixel */
#define STP_WORK_FIND          24 /* x y z count of clusters whose points may; z starts as 0 */
#define STP_WORK_OPEN          28 /* x y z count of blocks with such pixels */
#define STP_WORK_REPAIR        8  /* x y z count of small splats that touch an overflowed block */
#define STP_WORK_REPAIR_L      12
#define STP_WORK_REPAIR_BLOCKS 16 /* x y z: those blocks, then alone on the list; else 0 */
#define STP_WORK_COLLECT       20 /* x y z: all splats, to find those; else 0 */
#define STP_WORK_OVERFLOW      24 /* not 0: a pixel's slots overflowed */
#define STP_WORK_REMAINING     25 /* not 0: rays that are being mended have layers left */
#define STP_WORK_SEEK          28 /* x y z: all blocks, to find the overflowed; else 0 */
/* Two-pass, which repairs nothing, with BINS: */
#define STP_WORK_REST    20 /* x y z count of large splats that are not binned */
#define STP_WORK_BINNED  8  /* x y z: workgroups, and count, of blocks that have lists */
#define STP_WORK_ENTRIES 24 /* of those lists, handed out */
/* A word a block. Then the list of touched blocks; of layers, how many fragments the deep pixels of
 * a block have, then the place of their next list; with BINS the heads of the blocks' lists (the
 * first entry + 1), and the list of the blocks that have one. Pyramid: then two words a block, a
 * bit for each open pixel; then three lists. */
#define STP_WORK_FLAGS       32
#define STP_WORK_BLOCK_WORDS 6 /* pyramid: all of these, a block */
#define STP_WORK_BLOCK_RESET 3 /* those that start as 0 */
#define STP_BLOCK_TOUCHED    1u
#define STP_BLOCK_OVERFLOWED 2u
#define STP_BLOCK_LOOK       1u /* pyramid: it is on the list of STP_WORK_LOOK; so below */
#define STP_BLOCK_OPEN       2u
#define STP_BLOCK_POINTS     4u /* pyramid: some point fell into it */
#define STP_BLOCK_BARE       8u /* of the tile, and the push passes it over; with RIM_FAR */

struct stp_light_gpu {
    float position[3]; /* camera frame: a point, or the unit direction towards the light */
    uint positional;
    float color[3];
    uint pad;
};

struct stp_material_gpu {
    float ambient, diffuse, specular, shininess;
    float albedo[3];
    float epsilon;
};

struct stp_phong_gpu {
    float u[3], radius[2], field[4];
};

struct stp_clip_gpu {
    float line[2][3]; /* what is missing keeps all */
    uint reflex;
};

struct stp_optics_gpu {
    float ior[3];
    float level; /* of the environment, the fraction mixes in the next one; below 0: unmet */
    float reflectance[3];
    float absorption[3]; /* of one layer: optical depth */
};

/* A level of the environment: width * (height + 2) texels from `first`. */
struct stp_level_gpu {
    uint first, width, height;
};

/* HM: kernels of one shape, and the walks that draw them; zero without them. */
struct stp_axis_gpu {
    float shape[9];  /* of each of the grid's axes, camera frame: over its deviation */
    float factor[6]; /* R of R'R = shape' shape, upper triangular, by rows (lib/ellipsoid.glsl) */
    float extent[3]; /* of the box around a kernel's reach */
    float scale;     /* amplitude * sqrt(2 pi) */
    float h;
    uint merge;              /* STP_AXIS_MERGE_* */
    uint splats;             /* all kernels */
    uint blocks_x, blocks_y; /* compute: of the whole picture */
    uint walk[6];            /* axis; + 4: rays run against it */
};

struct stp_frame_constants {
    STP_ADDRESS(Vec4Ref,
                splats); /* 2 per splat: x y z radius; nx ny nz tag (STP_TAG_*, object << 8) */
    STP_ADDRESS(Vec3Ref, colors);        /* linear; with HAS_COLOR */
    STP_ADDRESS(FloatRef, opacities);    /* where they are not one for all */
    STP_ADDRESS(PhongRef, ellipses);     /* with PHONG */
    STP_ADDRESS(ClipRef, clips);         /* with PHONG 2 */
    STP_ADDRESS(MaterialRef, materials); /* one an object */
    STP_ADDRESS(OpticsRef, optics);      /* one an object; where surfaces meet the environment */
    STP_ADDRESS(Vec3Ref, environment);   /* its levels, each with two polar rows */
    STP_ADDRESS(Vec3Ref, light_cube);    /* 2 a texel: diffuse, specular; with LIGHT_CUBE */
    STP_ADDRESS(UintRef, order);         /* raster, a pass a layer: splats by group; axis: lists */
    STP_ADDRESS(UintRef, work);          /* STP_WORK_* */
    STP_ADDRESS(UintRef, objects);       /* pyramid: of points; with HAS_OBJECTS */
    STP_ADDRESS(UintRef, rim);       /* pyramid: STP_GROUP words a block, of a thread each: a bit a
                                        pixel that a disc may cover, from STP_BLOCK on one that a disc
                                        may hide; then, with RIM_FAR, of each open pixel the depth
                                        that a disc has to be before by its radius */
    STP_ADDRESS(UintRef, large);     /* ids of large splats; exact: then those to repair; pyramid:
                                        points of STP_WORK_RIM, large ones from the end, then the
                                        clusters of STP_WORK_FIND, each its first
                                        point, and 1 more where it may touch a bare block */
    STP_ADDRESS(UintRef, bins);      /* large splats that are not binned; then the entries of the
                                        blocks' lists: record, and the next entry + 1 */
    STP_ADDRESS(Uint64Ref, keys);    /* deferred: K a pixel; exact: STP_SLOTS; pyramid: 1 */
    STP_ADDRESS(UintRef, key_ids);   /* exact, packed, with normal fields: ids beside */
    STP_ADDRESS(Uint64Ref, traits);  /* exact, packed, of a splat: lib/terms.glsl:traits_make */
    STP_ADDRESS(UintRef, counts);    /* exact: fragments a pixel; axis: where blocks begin */
    STP_ADDRESS(UintRef, nearest);   /* two-pass: depth bits a pixel; Voronoi exact: K a pixel */
    STP_ADDRESS(Uint64Ref, sums);    /* two-pass: lib/sums.glsl says how many a pixel */
    STP_ADDRESS(Vec4Ref, projected); /* axis: 2 per kernel: centre, log2 tau; colour; or
                                        STP_ELLIPSOID_DRAWN, STP_GAUSSIAN; else STP_BIN_DISC, ...:
                                        of large splats, by their place in `large` */
    STP_ADDRESS(Vec4Ref, axis_sums); /* axis, in parts: 2 a pixel and walk */
    STP_ADDRESS(UintRef,
                host_words);      /* the host's depth as it was copied, rows of what was copied */
    STP_ADDRESS(UintRef, limits); /* what ends each pixel's ray: bits of the eye depth of the host's
                                     image; peel: depth_order of what is opaque */
    STP_ADDRESS(Vec4Ref, out_color);
    STP_ADDRESS(Vec3Ref, out_normal);
    STP_ADDRESS(FloatRef, out_depth);
    STP_ADDRESS(Vec4Ref, out_albedo);   /* rgb, sum of weights */
    STP_ADDRESS(UintRef, out_id);       /* canonical id, fragments; nearest sample, hits; layers */
    STP_ADDRESS(FloatRef, deep_layers); /* STP_DEEP_WINDOW a pixel: depth, r g b, alpha */
    STP_ADDRESS(UintRef, deep_counts);  /* layers of a pixel's ray; STP_DEEP_MENDED */
    STP_DOUBLE rotation64[9];           /* WITH_FLOAT64: centres are projected in double */
    STP_DOUBLE translation64[3];
    STP_DOUBLE eye64[3]; /* relative to the origin; orthographic: the direction of sight */
    STP_DOUBLE focal64[2];
    STP_DOUBLE center64[2];
    float rotation[9];    /* world to camera: x right, y down, z forward */
    float translation[3]; /* of positions relative to the origin */
    float eye[3];         /* as eye64 */
    float focal[2];       /* pixels */
    float inv_focal[2];
    float center[2];
    float near_depth, far_depth;
    float epsilon;     /* the least of the objects' */
    float opacity;     /* of every splat, where it is one for all */
    float floor_size;  /* least diameter, pixels */
    float depth_low;   /* depth of quantised 0 */
    float depth_scale; /* quantised steps a scene unit */
    float depth_step;  /* 1 / depth_scale */
    float slab_scale;  /* 1 / epsilon: slabs a scene unit, for keys that carry ids */
    uint depth_bits;   /* m: epsilon is 2^m quantised steps */
    uint splat_count;
    uint known_count;             /* and those behind them that stand for other processes' splats */
    uint width, height;           /* of the whole picture */
    uint tile_x, tile_y;          /* the region being rendered */
    uint tile_width, tile_height; /* <= width, height */
    float guard;                  /* raster: what the tile takes of clip space */
    uint blocks_x, blocks_y;
    uint light_count;
    float background[4];  /* premultiplied */
    float eye_dome_scale; /* orthographic: 16 / diagonal; else 0 */
    float sum_scale;      /* fixed point: units of 1 in normals and weights */
    float color_scale;    /* of colours */
    float raster_near;    /* hardware depth = raster_near / depth, or affine when orthographic */
    float raster_scale;
    float raster_slab;            /* hardware depth of one slab (ZP Eq. 10) */
    int grid_x, grid_y;           /* pyramid: whole-picture pixel of its first texel; blocks */
    uint grid_width, grid_height; /* whole blocks */
    uint level_column;            /* of the image, where levels above 0 begin */
    uint level_row[STP_LEVELS];
    float radius_unit, radius_scale; /* what radii are packed in, and its inverse */
    int block_reach;                 /* blocks beyond a touched one that a disc may reach */
    uint rim_level;                  /* whose empty texels a mean's disc may reach into, at most */
    float pyramid_floor;             /* least radius on the screen, pixels */
    float pyramid_color;             /* colours are packed times this */
    STP_STRUCT(stp_light_gpu) lights[STP_LIGHTS];
    STP_STRUCT(stp_material_gpu)
    material; /* of the first object; the only one without HAS_OBJECTS */
    STP_STRUCT(stp_axis_gpu) axis;
    float environment_frame[9]; /* camera to the map: right of its centre, up, its centre */
    STP_STRUCT(stp_level_gpu) environment_levels[STP_ENVIRONMENT_LEVELS];
    uint deep_first; /* layers of a ray from here on are kept, STP_DEEP_WINDOW of them */
};

#ifndef GL_core_profile
#undef uint
#endif
#undef STP_ADDRESS
#undef STP_STRUCT
#undef STP_DOUBLE
#endif
