/* The plan: images, buffers and passes of one picture, as plain data. Methods append their steps;
 * recording only translates them. Nothing here knows Vulkan. */
#ifndef STP_PLAN_PLAN_H
#define STP_PLAN_PLAN_H

#include <stipple/plan.h>

#include "prepare/axis_blocks.h"
#include "scene/stream.h"
#include "shared/frame.h"

#define PLAN_MAX_RESOURCES 32
#define PLAN_MAX_PASSES    72 /* STP_MAX_GROUPS layers, and what comes after them */
#define PLAN_MAX_ACCESSES  20
#define PLAN_NONE          255
#define PLAN_MAX_CHUNKS    256

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

/* What a buffer or image is for: a resource's address goes into the frame block by this. */
enum plan_slot {
    PLAN_SPLATS,
    PLAN_COLORS,
    PLAN_OPACITIES,
    PLAN_ELLIPSES,
    PLAN_CLIPS,
    PLAN_MATERIALS,
    PLAN_OBJECT_OPTICS,
    PLAN_ENVIRONMENT,
    PLAN_LIGHTS,
    PLAN_ORDER,
    PLAN_WORK,
    PLAN_OBJECTS,
    PLAN_CLUSTERS,
    PLAN_RIM,
    PLAN_LARGE,
    PLAN_KEYS,
    PLAN_SLOT_IDS,
    PLAN_COUNTS,
    PLAN_NEAREST,
    PLAN_SUMS,
    PLAN_PROJECTED,
    PLAN_AXIS_SUMS,
    PLAN_HOST_WORDS,
    PLAN_LIMITS,
    PLAN_OUT_COLOR,
    PLAN_OUT_NORMAL,
    PLAN_OUT_DEPTH,
    PLAN_OUT_ALBEDO,
    PLAN_OUT_ID,
    PLAN_DEEP_LAYERS,
    PLAN_DEEP_COUNTS,
    PLAN_BUFFER_SLOTS, /* the frame block's addresses, in order, end here */
    PLAN_IMAGE_ID = PLAN_BUFFER_SLOTS,
    PLAN_IMAGE_DEPTH,
    PLAN_IMAGE_SUM,
    PLAN_IMAGE_SUM_DEPTH,
    PLAN_IMAGE_SUM_COLOR,
    PLAN_IMAGE_PYRAMID,
    PLAN_IMAGE_ATTRIBUTES,
    PLAN_TEXEL_POINTS,
    PLAN_TEXEL_RADII,
    PLAN_IMAGE_AXIS_COLOR,
    PLAN_IMAGE_AXIS_DEPTH,
    PLAN_TEXEL_KEYS, /* the words of PLAN_KEYS again, where its format is of texels */
    PLAN_TEXEL_SLOT_IDS,
    PLAN_TEXEL_PROJECTED, /* and those of PLAN_PROJECTED and PLAN_ORDER */
    PLAN_TEXEL_ORDER,
    PLAN_SLOTS
};

/* The descriptor binding of what has no address; 0 is the frame block. */
#define PLAN_BINDING(slot) (1 + (slot)-PLAN_BUFFER_SLOTS)

enum plan_lifetime { PLAN_SCENE, PLAN_TRANSIENT, PLAN_OUTPUT };

enum plan_format {
    PLAN_BUFFER,
    PLAN_RG32UI,
    PLAN_RG32F,
    PLAN_RGBA32F,
    PLAN_D32F,
    PLAN_RGBA32UI,
    PLAN_TEXELS_RGBA32UI, /* a buffer that is fetched as texels */
    PLAN_TEXELS_R32F,
    PLAN_TEXELS_RG32UI,
    PLAN_TEXELS_R32UI,
};

/* Texels of a buffer that STP_FEATURE_TEXEL_BUFFERS promises. */
#define PLAN_MOST_TEXELS ((uint64_t)1 << 27)

struct plan_resource {
    char name[24];
    enum plan_slot slot;
    enum plan_lifetime lifetime;
    enum plan_format format;
    uint32_t width, height, layers; /* images */
    uint64_t bytes;
};

/* Names a shader module: glsl/passes, and its variants. */
enum plan_shader {
    PLAN_SHADER_NONE,
    PLAN_SHADER_BLOCKS,
    PLAN_SHADER_DEFERRED_KEYS,
    PLAN_SHADER_DEFERRED_KEYS_LARGE,
    PLAN_SHADER_DEFERRED_NEAREST,
    PLAN_SHADER_DEFERRED_NEAREST_LARGE,
    PLAN_SHADER_DEFERRED_COMPOSITE,
    PLAN_SHADER_DEFERRED_COMPOSITE_IMAGE,
    PLAN_SHADER_EXACT_SLOTS,
    PLAN_SHADER_EXACT_SLOTS_LARGE,
    PLAN_SHADER_EXACT_RESOLVE, /* then with slots fetched as texels; so below */
    PLAN_SHADER_EXACT_RESOLVE_FETCHED,
    PLAN_SHADER_EXACT_LAYERS,
    PLAN_SHADER_EXACT_LAYERS_FETCHED,
    PLAN_SHADER_EXACT_ARM,
    PLAN_SHADER_EXACT_CLEAR,
    PLAN_SHADER_EXACT_COLLECT,
    PLAN_SHADER_MEND_CLEAR,
    PLAN_SHADER_MEND_FIND,
    PLAN_SHADER_MEND_FIND_LARGE,
    PLAN_SHADER_MEND_FIRST,
    PLAN_SHADER_MEND_TURN,
    PLAN_SHADER_MEND_SUM,
    PLAN_SHADER_MEND_SUM_LARGE,
    PLAN_SHADER_MEND_LAYER,
    PLAN_SHADER_TWOPASS_CLEAR,
    PLAN_SHADER_TWOPASS_DEPTH,
    PLAN_SHADER_TWOPASS_DEPTH_LARGE,
    PLAN_SHADER_TWOPASS_DEPTH_LISTED,
    PLAN_SHADER_TWOPASS_DEPTH32,
    PLAN_SHADER_TWOPASS_DEPTH32_LARGE,
    PLAN_SHADER_TWOPASS_DEPTH32_LISTED,
    PLAN_SHADER_TWOPASS_ID32,
    PLAN_SHADER_TWOPASS_ID32_LARGE,
    PLAN_SHADER_TWOPASS_ID32_LISTED,
    PLAN_SHADER_TWOPASS_SUM,
    PLAN_SHADER_TWOPASS_SUM_LARGE,
    PLAN_SHADER_TWOPASS_SUM_LISTED,
    PLAN_SHADER_TWOPASS_SUM32,
    PLAN_SHADER_TWOPASS_SUM32_LARGE,
    PLAN_SHADER_TWOPASS_SUM32_LISTED,
    PLAN_SHADER_TWOPASS_RESOLVE,
    PLAN_SHADER_TWOPASS_RESOLVE_IMAGE,
    PLAN_SHADER_TWOPASS_RESOLVE_IMAGE_COLOR,
    PLAN_SHADER_PYRAMID_PROJECT,
    PLAN_SHADER_PYRAMID_PROJECT32,
    PLAN_SHADER_PYRAMID_PROJECT_ID32,
    PLAN_SHADER_PYRAMID_BLOCKS,
    PLAN_SHADER_PYRAMID_RIM_FIND,
    PLAN_SHADER_PYRAMID_RIM_SPLAT,
    PLAN_SHADER_PYRAMID_RIM_SPLAT32,
    PLAN_SHADER_PYRAMID_RIM_SPLAT_ID32,
    PLAN_SHADER_PYRAMID_GATHER, /* then with colours; then with ids and objects; so below */
    PLAN_SHADER_PYRAMID_GATHER_COLOR,
    PLAN_SHADER_PYRAMID_GATHER_ALL,
    PLAN_SHADER_PYRAMID_PULL,
    PLAN_SHADER_PYRAMID_PULL_COLOR,
    PLAN_SHADER_PYRAMID_PULL_ALL,
    PLAN_SHADER_PYRAMID_PUSH,
    PLAN_SHADER_PYRAMID_PUSH_COLOR,
    PLAN_SHADER_PYRAMID_PUSH_ALL,
    PLAN_SHADER_PYRAMID_PUSH_LISTED,
    PLAN_SHADER_PYRAMID_PUSH_LISTED_COLOR,
    PLAN_SHADER_PYRAMID_PUSH_LISTED_ALL,
    PLAN_SHADER_PYRAMID_SHADE,
    PLAN_SHADER_PYRAMID_SHADE_COLOR,
    PLAN_SHADER_PYRAMID_SHADE_ALL,
    PLAN_SHADER_PYRAMID_RIM_NEAR,
    PLAN_SHADER_PYRAMID_RIM_NEAR_COLOR,
    PLAN_SHADER_PYRAMID_RIM_NEAR_ALL,
    PLAN_SHADER_PYRAMID_RIM_SHADE,
    PLAN_SHADER_PYRAMID_RIM_SHADE_COLOR,
    PLAN_SHADER_PYRAMID_RIM_SHADE_ALL,
    PLAN_SHADER_AXIS_PROJECT,
    PLAN_SHADER_AXIS_SURFACE, /* a surface's splats, in the place of the former */
    PLAN_SHADER_AXIS_VERTEX,
    PLAN_SHADER_AXIS_FRAGMENT,
    PLAN_SHADER_AXIS_SURFACE_VERTEX,
    PLAN_SHADER_AXIS_SURFACE_FRAGMENT,
    PLAN_SHADER_AXIS_BLOCK, /* then with splats fetched as texels; then of one walk and part */
    PLAN_SHADER_AXIS_BLOCK_FETCHED,
    PLAN_SHADER_AXIS_BLOCK_PART,
    PLAN_SHADER_AXIS_BLOCK_PART_FETCHED,
    PLAN_SHADER_AXIS_MERGE,
    PLAN_SHADER_AXIS_MERGE_SUMS,
    PLAN_SHADER_AXIS_EMPTY,
    PLAN_SHADER_EYE_DOME,
    PLAN_SHADER_BACKGROUND,
    PLAN_SHADER_RASTER_VERTEX,
    PLAN_SHADER_RASTER_VERTEX_ORDERED,
    PLAN_SHADER_RASTER_VERTEX_LAYERS,
    PLAN_SHADER_DEFERRED_FRAGMENT,
    PLAN_SHADER_DEFERRED_FRAGMENT_PACKED,
    PLAN_SHADER_TWOPASS_DEPTH_FRAGMENT,
    PLAN_SHADER_TWOPASS_SUM_FRAGMENT,
    PLAN_SHADER_RASTER_PHONG, /* the rasteriser's again, from its vertex shader on, for ellipses */
    PLAN_SHADER_RASTER_PHONG_LAST =
        PLAN_SHADER_RASTER_PHONG + PLAN_SHADER_TWOPASS_SUM_FRAGMENT - PLAN_SHADER_RASTER_VERTEX,
    PLAN_SHADER_TRANSPARENT_VERTEX,
    PLAN_SHADER_TRANSPARENT_BLEND_FRAGMENT,
    PLAN_SHADER_TRANSPARENT_OTHERS_FRAGMENT,
    PLAN_SHADER_TRANSPARENT_TOUCHED,
    PLAN_SHADER_TRANSPARENT_MASK,
    PLAN_SHADER_TRANSPARENT_COMPOSITE,
    PLAN_SHADER_TRANSPARENT_COMPOSITE_NEAREST,
    PLAN_SHADER_PEEL_OPAQUE,
    PLAN_SHADER_PEEL_OPAQUE_LARGE,
    PLAN_SHADER_PEEL_OPAQUE_VERTEX,
    PLAN_SHADER_PEEL_LIMITS,
    PLAN_SHADER_HOST_LIMITS,
    PLAN_SHADER_LIGHT_CUBE,
    PLAN_SHADER_HOST_VERTEX,
    PLAN_SHADER_HOST_FRAGMENT,
    PLAN_SHADER_HOST_FRAGMENT_DEPTH,
    PLAN_SHADERS
};

enum plan_kind {
    PLAN_FILL,      /* fill `target` with the word `value` */
    PLAN_ARGUMENTS, /* reset the work buffer's arguments and flags */
    PLAN_DISPATCH,
    PLAN_DISPATCH_INDIRECT, /* three words at `offset` of the work buffer */
    PLAN_DRAW,              /* three vertices a splat */
    PLAN_EXCHANGE,          /* between processes, by the host */
    PLAN_COPY_DEPTH,        /* of a host's image, the tile's part */
};

enum plan_access_kind {
    PLAN_READ = 1,
    PLAN_WRITE = 2,
    PLAN_ATTACHMENT = 4, /* with WRITE: rendered to; with READ and WRITE: blended or tested */
};

struct plan_access {
    uint8_t resource;
    uint8_t kind; /* enum plan_access_kind, or-ed */
};

enum plan_raster {
    PLAN_RASTER_WINNER, /* depth test and write, ids out */
    PLAN_RASTER_BLEND,  /* additive, no depth */
    /* Premultiplied, over what is there; ids are replaced. Depth test and write, where the pass has
     * a depth image. */
    PLAN_RASTER_OVER,
};

enum plan_exchange {
    PLAN_EXCHANGE_NEAREST, /* the least key of each pixel to all, its splat to the root */
    PLAN_EXCHANGE_SUMS,    /* the sum of the sums to the root */
};

struct plan_pass {
    char name[40];
    enum plan_kind kind;
    enum plan_shader shader, vertex;
    enum plan_raster raster;
    uint8_t target;                    /* FILL: resource */
    uint32_t value;                    /* FILL */
    uint32_t offset;                   /* DISPATCH_INDIRECT: bytes into the work buffer */
    enum plan_exchange exchange;       /* EXCHANGE */
    uint32_t groups;                   /* DISPATCH: workgroups; 0: one a block of the tile */
    uint32_t level;                    /* pyramid: the level that is written */
    bool of_grid;                      /* DISPATCH: one a block of that level of the tile's grid */
    bool of_points;                    /* DISPATCH: one a run of the points on the device */
    bool repair;                       /* specialised with PLAN_REPAIR on */
    uint32_t layer, layer_count;       /* DRAW: of the attachments; axis: the walk */
    uint32_t part;                     /* axis: of a walk's lists */
    uint32_t first_splat, splat_count; /* DRAW */
    float scale;                       /* DRAW: of radii; 0: 1 */
    float shift;                       /* DRAW: of slabs, in slabs */
    uint8_t access_count;
    struct plan_access access[PLAN_MAX_ACCESSES];
};

/* A region of the picture: rendered whole, and kept inside `keep` (left, top, right, bottom). */
struct plan_tile {
    uint32_t x, y, width, height;
    uint32_t keep[4];
};

/* One of several processes that make the picture together; count 0: alone. */
struct plan_share {
    uint32_t rank, count;
    uint64_t splats; /* that this process holds */
};

/* Pixels of the whole picture that a pyramid stands on; beyond the picture's edges too, whole
 * blocks. */
struct plan_grid {
    int32_t x, y;
    uint32_t width, height;
};

struct stp_plan {
    enum stp_method method;
    enum stp_transparency transparency; /* AUTO: nothing is transparent */
    enum stp_path path;
    enum stp_payload payload;
    enum stp_voronoi voronoi;
    struct stp_render_params params;
    struct stp_camera camera;
    struct stp_facts facts;
    struct stp_limits limits;
    struct plan_share share;
    float background[4]; /* params.background points here, or is NULL */
    char why[512];
    uint32_t constant[PLAN_CONSTANTS];
    struct stp_light lights[STP_MAX_LIGHTS]; /* of the scene */
    uint32_t light_count;
    struct stp_frame_constants frame; /* of the whole picture; addresses and tile are zero */
    uint32_t resource_count, pass_count, tile_count;
    struct plan_resource resource[PLAN_MAX_RESOURCES];
    struct plan_pass pass[PLAN_MAX_PASSES];
    /* Passes [repeat_first, repeat_end) are run once a sample, in order. */
    uint32_t repeat_first, repeat_end;
    /* Passes [loop_first, repeat_end) are run again and again, for as long as they leave
     * STP_WORK_REMAINING set; not at all when it was not. 0: none are. */
    uint32_t loop_first;
    /* Points that the device cannot hold at once pass through its buffers in chunks: passes
     * [chunk_first, chunk_end) are run once a chunk, of points [chunk[i], chunk[i + 1]). */
    uint32_t chunk_count; /* 0: all points are there at once */
    uint32_t chunk_first, chunk_end;
    uint32_t chunk[PLAN_MAX_CHUNKS + 1];
    uint32_t stream_count; /* chunks that the scene comes in itself; 0: it is in memory */
    uint32_t stream[STREAM_MOST_CHUNKS + 1];
    uint32_t tile_width, tile_height; /* the largest */
    uint32_t levels;                  /* of the pyramid; 0: no pyramid */
    struct plan_grid grid;            /* of the whole picture */
    bool rim_far;                     /* discs reach beyond the pixels beside their own */
    struct plan_tile *tile;
    struct axis_lists axis;                   /* of the axis method; owned */
    struct axis_blocks axis_blocks;           /* by compute */
    double environment_axes[3][3];            /* world: right of the map's centre, up, its centre */
    uint32_t group_first[STP_MAX_GROUPS + 1]; /* raster: splats of a group in the order buffer */
    uint32_t cover_first[STP_MAX_GROUPS + 1]; /* fast, nearest: members of a group there */
};

/* plan/plan.c: can these be planned with at all? Logs why not. */
enum stp_result plan_check(const struct stp_env *env, const struct stp_scene *scene,
                           const struct stp_camera *camera, const struct stp_render_params *params);

/* plan/choose.c: method, path, payload, voronoi and why. */
enum stp_result plan_choose(const struct stp_env *env, struct stp_plan *plan);
/* A volume, or ellipsoids of range images: kernels that need an order, and have no surface. */
bool plan_of_medium(const struct stp_facts *facts);

/* plan/transparency.c: AUTO where nothing is transparent; the method whose passes composite such
 * layers; checks what was asked for; why. */
enum stp_transparency plan_resolve_transparency(const struct stp_facts *facts,
                                                const struct stp_render_params *params,
                                                const struct stp_limits *limits);
enum stp_method plan_transparency_method(enum stp_transparency transparency);
enum stp_result plan_choose_transparency(const struct stp_env *env, struct stp_plan *plan);
void plan_explain_layers(struct stp_plan *plan, const char *asked);
/* Takes the groups that each cover the surface, back to front (ZP Algorithms 2 and 3). */
bool plan_covers(const struct stp_plan *plan);

/* The reference in place of what was chosen: the device cannot hold the scene. */
void plan_leave_device(struct stp_plan *plan);

/* plan/steps.c: what the methods' files share. */
uint8_t plan_resource(struct stp_plan *plan, const char *name, enum plan_slot slot,
                      enum plan_lifetime lifetime, uint64_t bytes);
uint8_t plan_image(struct stp_plan *plan, const char *name, enum plan_slot slot,
                   enum plan_format format, uint32_t layers);
struct plan_pass *plan_pass(struct stp_plan *plan, enum plan_kind kind, const char *name);
/* PLAN_SPLATS: all that a splat is, where it is more than a disc; PLAN_MATERIALS: and the light. */
void plan_reads(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
void plan_writes(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
void plan_updates(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
void plan_attaches(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
uint8_t plan_find(const struct stp_plan *plan, enum plan_slot slot); /* PLAN_NONE: absent */
uint64_t plan_pixels(const struct stp_plan *plan);                   /* of a tile, whole blocks */
void plan_fill(struct stp_plan *plan, enum plan_slot slot, uint32_t value, const char *name);
/* One pass over the splats: small, then large ones; updates `updated` (ends with PLAN_SLOTS). */
void plan_splat(struct stp_plan *plan, const char *name, enum plan_shader small_shader,
                enum plan_shader large_shader, bool repair, const enum plan_slot *updated);
void plan_blocks(struct stp_plan *plan);
/* An output that is written, or, where frames add to each other, added to. */
void plan_outputs(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
/* A resolving pass over the touched blocks; reads `read` (ends with PLAN_SLOTS), writes the
 * outputs. */
void plan_resolve(struct stp_plan *plan, const char *name, enum plan_shader shader, bool repair,
                  const enum plan_slot *read);

/* Splats on this device: all, or this process's share. */
uint64_t plan_splats(const struct stp_plan *plan);
/* Behind them, for several processes: stand-ins for the nearest splats that others hold. The root
 * has one a pixel, with all that resolving asks of a splat; the others one an object, since summing
 * asks only whose epsilon counts. */
uint64_t plan_ghosts(const struct stp_plan *plan);
/* Whether this process resolves and gets the picture. */
bool plan_is_root(const struct stp_plan *plan);
void plan_exchange(struct stp_plan *plan, enum plan_exchange exchange, const char *name);

/* One file a paper appends its resources and passes, for tiles of the given size. */
void plan_deferred(struct stp_plan *plan);
void plan_exact(struct stp_plan *plan);
void plan_twopass(struct stp_plan *plan);
void plan_axis(struct stp_plan *plan);
/* axis_surface.c: of points and splats, drawn as flat Gaussians. */
bool plan_axis_asked(const struct stp_plan *plan);
enum stp_result plan_check_axis_surface(const struct stp_env *env, const struct stp_plan *plan);
void plan_axis_surface_project(struct stp_plan *plan);
void plan_surface_resources(struct stp_plan *plan); /* tile.c: splats and what goes with them */

/* Their kernels, and by compute the blocks that they touch. */
void plan_axis_resources(struct stp_plan *plan);
/* Of a copy: the lists' arrays are the original's. */
void plan_axis_forget(struct stp_plan *plan);

/* plan/axis.c: the lists of the view, and what shaders need to know of the kernels. */
enum stp_result plan_axis_prepare(const struct stp_env *env, struct stp_plan *plan,
                                  const struct stp_scene *scene);

/* plan/pyramid.c: what a pyramid of the plan's scene and view stands on, and what one tile's does.
 * A pixel that the tile keeps has the same bits in both. */
void plan_pyramid(struct stp_plan *plan);
void plan_pyramid_resources(struct stp_plan *plan);
void plan_pyramid_view(struct stp_plan *plan); /* levels, grid and constants; once a plan */
/* plan/pyramid_chunks.c: the points on the device at once, at most. */
uint64_t plan_chunk_points(const struct stp_plan *plan);
/* Cuts the points into chunks where the device cannot hold them all; false: not even so. */
bool plan_pyramid_chunks(struct stp_plan *plan);
struct plan_grid plan_tile_grid(const struct stp_plan *plan, const struct plan_tile *tile);
/* Workgroups of a pass over one level of a grid. */
uint32_t plan_level_blocks(const struct plan_grid *grid, uint32_t level);
void plan_transparent(struct stp_plan *plan);
/* Before the two-pass method is repeated for every layer: nothing is peeled; where what is opaque
 * ends the rays. */
void plan_peel_begin(struct stp_plan *plan);

/* plan/frame.c: the view, in double, to the constants that shaders read. */
void plan_frame_constants(struct stp_plan *plan, const struct stp_scene *scene);

/* The same for another camera, with nothing allocated: its size is at most that which the plan was
 * made for, its projection of the same kind. */
void plan_move(struct stp_plan *plan, const struct stp_camera *camera);
/* frame.depth_bits when the whole scene is in view, which is the worst that a camera can do. */
uint32_t plan_least_depth_bits(const struct stp_plan *plan);

/* plan/deep.c: refuses what no deep picture can be made of. */
enum stp_result plan_deep_check(const struct stp_env *env, struct stp_plan *plan);
/* What exact's layers are kept in, and, of the last pass, that it puts them there; nothing where
 * they are not kept. */
void plan_deep_begin(struct stp_plan *plan);
void plan_deep_write(struct stp_plan *plan);

/* plan/environment.c: whether this picture needs the scene's environment, and what of it. */
void plan_environment(struct stp_plan *plan, const struct stp_scene *scene);
void plan_environment_resources(struct stp_plan *plan);
/* As the camera of plan->frame sees it. */
void plan_turn_environment(struct stp_plan *plan);

/* plan/tile.c: cuts the picture until a tile's transients fit; appends steps for the tile size. */
enum stp_result plan_tiles(const struct stp_env *env, struct stp_plan *plan);
/* Tiles of that size over the camera's picture. */
void plan_place_tiles(struct stp_plan *plan);

/* plan/shade.c: can light be computed as asked? Logs why not. */
enum stp_result plan_check_shade(const struct stp_env *env, const struct stp_plan *plan);
/* plan/light_cube.c: whether light is looked up; logs why it cannot be. */
enum stp_result plan_light_cube(const struct stp_env *env, struct stp_plan *plan);
/* Its buffer, and the pass that fills it; before the passes that shade. */
void plan_light_cube_steps(struct stp_plan *plan);
/* How far a component of a pixel's colour may be from what its lights give, for one albedo. */
double plan_light_cube_error(const struct stp_plan *plan, const struct stp_material *material,
                             double albedo);
/* The most that one splat's fragment can shine, by any of the scene's lights. */
double plan_most_light(const struct stp_plan *plan, const struct stp_scene *scene);

/* plan/phong.c: may this method draw ellipses? Logs why not. */
enum stp_result plan_check_phong(const struct stp_env *env, const struct stp_plan *plan);
void plan_phong_resources(struct stp_plan *plan);
/* A shader of the rasteriser, as the plan's splats need it. */
enum plan_shader plan_raster_shader(const struct stp_plan *plan, enum plan_shader shader);

/* plan/host.c: makes of a plan's copy that of a frame whose layers a host's depth cuts: what lies
 * behind it is not drawn. A plan without layers stays as it is. */
enum stp_result plan_behind_host(const struct stp_env *env, struct stp_plan *plan,
                                 enum plan_host_depth depth);
/* The eye depth that ends each pixel's ray; nothing where no host's depth does. */
void plan_limits(struct stp_plan *plan);

/* plan/plan.c */
enum stp_result plan_copy(const struct stp_env *env, const struct stp_plan *plan,
                          struct stp_plan **copy);

/* Words of out_id a pixel: see STP_ID_WORDS; one more, the last, where layers are counted. */
uint32_t plan_id_words(const struct stp_plan *plan);

/* How often the repeated passes run: once a sample, or once a layer that is peeled. */
uint32_t plan_repeats(const struct stp_plan *plan);
/* How many samples a pixel has: the square of PLAN_SAMPLE_GRID. */
uint32_t plan_samples(const struct stp_plan *plan);

uint64_t plan_bytes(const struct stp_plan *plan, enum plan_lifetime lifetime);

#endif
