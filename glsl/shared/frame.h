/* The frame's constants: one uniform block, read by C and by every shader. Offsets are asserted on
 * the C side (src/passes/constants.c). Scalar layout. */
#ifndef STP_SHARED_FRAME_H
#define STP_SHARED_FRAME_H

#ifdef __cplusplus
#error "C or GLSL only"
#endif

#ifdef GL_core_profile
#define STP_ADDRESS(type, name) type name
#define STP_STRUCT(type) type
#ifdef WITH_FLOAT64
#define STP_DOUBLE double
#else
#define STP_DOUBLE uint64_t
#endif
#else
#include <stdint.h>
#define STP_ADDRESS(type, name) uint64_t name
#define STP_STRUCT(type) struct type
#define STP_DOUBLE double
#define uint uint32_t
#endif

/* Pixels live in blocks of BLOCK x BLOCK: a splat touches few pages, a workgroup takes a block. */
#define STP_BLOCK        8
#define STP_GROUP        64    /* threads of a workgroup */
#define STP_LARGE_AREA   1024  /* pixels of bounds above which a splat takes a workgroup */
#define STP_LARGE_GROUP  128
#define STP_ROW          32768u /* workgroups along x; more go along y */
#define STP_SLOTS        64    /* fragments a pixel that `exact` keeps before its second way */
#define STP_SUM_WORDS    10    /* 64-bit words of a pixel's fixed-point sums */
#define STP_LIGHTS       8
#define STP_NO_ID        0xffffffffu
#define STP_ID_WORDS     4     /* of out_id a pixel, with several samples; else 2; layers apart */
/* Of a splat's tag: group, flags, object. */
#define STP_TAG_GROUP     63u
#define STP_TAG_INVISIBLE 64u  /* opacity 0: it has no fragments */
#define STP_TAG_OPAQUE    128u /* opacity 1, in a scene that is transparent elsewhere */
/* Sums with no fragment: depth +Inf, id the largest int. Both halves are positive as ints, since
 * Mesa 22.3's lavapipe takes a 32-bit unsigned atomicMin for a signed one. */
#define STP_SUMS_NONE    0x7f8000007ffffffful

/* Words of the work buffer: indirect arguments, then counters, then the block flags and list. */
#define STP_WORK_LARGE    0 /* x y z count of large splats */
#define STP_WORK_BLOCKS   4 /* x y z count of touched blocks */
#define STP_WORK_REPAIR   8 /* x y z count of small splats that touch an overflowed block */
#define STP_WORK_REPAIR_L 12
#define STP_WORK_REPAIR_BLOCKS 16 /* x y z: the touched blocks again; else 0 */
#define STP_WORK_COLLECT  20 /* x y z: all splats, to find those; else 0 */
#define STP_WORK_OVERFLOW 24 /* not 0: a pixel's slots overflowed */
#define STP_WORK_REMAINING 25 /* not 0: rays that are being mended have layers left */
#define STP_WORK_FLAGS    32 /* a word a block */
#define STP_BLOCK_TOUCHED    1u
#define STP_BLOCK_OVERFLOWED 2u

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

struct stp_frame_constants {
    STP_ADDRESS(Vec4Ref, splats);        /* 2 per splat: x y z radius; nx ny nz tag (STP_TAG_*, object << 8) */
    STP_ADDRESS(Vec3Ref, colors);        /* linear; with HAS_COLOR */
    STP_ADDRESS(FloatRef, opacities);    /* where they are not one for all */
    STP_ADDRESS(MaterialRef, materials); /* one an object */
    STP_ADDRESS(UintRef, order);         /* raster, a pass a layer: splats by group */
    STP_ADDRESS(UintRef, work);          /* STP_WORK_* */
    STP_ADDRESS(UintRef, large);         /* ids of large splats; exact: then those to repair */
    STP_ADDRESS(Uint64Ref, keys);        /* deferred: K a pixel; exact: STP_SLOTS a pixel */
    STP_ADDRESS(UintRef, key_ids);       /* exact, packed, when ids are needed beside */
    STP_ADDRESS(UintRef, counts);        /* exact: fragments a pixel */
    STP_ADDRESS(UintRef, nearest);       /* two-pass: depth bits a pixel; Voronoi exact: K a pixel */
    STP_ADDRESS(Uint64Ref, sums);        /* two-pass: STP_SUM_WORDS a pixel */
    STP_ADDRESS(Vec4Ref, out_color);
    STP_ADDRESS(Vec3Ref, out_normal);
    STP_ADDRESS(FloatRef, out_depth);
    STP_ADDRESS(Vec4Ref, out_albedo); /* rgb, sum of weights */
    STP_ADDRESS(UintRef, out_id);     /* canonical id, fragments; nearest sample, hits; layers */
    STP_DOUBLE rotation64[9]; /* WITH_FLOAT64: centres are projected in double */
    STP_DOUBLE translation64[3];
    STP_DOUBLE focal64[2];
    STP_DOUBLE center64[2];
    float rotation[9];    /* world to camera: x right, y down, z forward */
    float translation[3]; /* of positions relative to the origin */
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
    uint width, height;           /* of the whole picture */
    uint tile_x, tile_y;          /* the region being rendered */
    uint tile_width, tile_height; /* <= width, height */
    uint blocks_x, blocks_y;
    uint light_count;
    float background[4]; /* premultiplied */
    float eye_dome_scale; /* orthographic: 16 / diagonal; else 0 */
    float sum_scale;      /* fixed point: units of 1 in normals and weights */
    float color_scale;    /* of colours */
    float raster_near;    /* hardware depth = raster_near / depth, or affine when orthographic */
    float raster_scale;
    float raster_slab; /* hardware depth of one slab (ZP Eq. 10) */
    STP_STRUCT(stp_light_gpu) lights[STP_LIGHTS];
};

#ifndef GL_core_profile
#undef uint
#endif
#undef STP_ADDRESS
#undef STP_STRUCT
#undef STP_DOUBLE
#endif
