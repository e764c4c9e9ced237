/* The plan: images, buffers and passes of one picture, as plain data. Methods append their steps;
 * recording only translates them. Nothing here knows Vulkan. */
#ifndef STP_PLAN_PLAN_H
#define STP_PLAN_PLAN_H

#include <stipple/plan.h>

#include "plan/constants.h"
#include "plan/steps.h"
#include "prepare/axis_blocks.h"
#include "scene/stream.h"
#include "scene/version.h"
#include "shared/frame.h"

#define PLAN_MAX_CHUNKS 256

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
    struct scene_version version; /* that the plan was made of */
    float background[4];          /* params.background points here, or is NULL */
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
    /* Passes [again_first, again_end) too, when all chunks have been through the others; their
     * order does not matter. again_end 0: there are none. */
    uint32_t again_first, again_end;
    uint32_t chunk[PLAN_MAX_CHUNKS + 1];
    uint32_t stream_count; /* chunks that the scene comes in itself; 0: it is in memory */
    uint32_t stream[STREAM_MOST_CHUNKS + 1];
    uint32_t tile_width, tile_height; /* the largest */
    uint32_t levels;                  /* of the pyramid; 0: no pyramid */
    struct plan_grid grid;            /* of the whole picture */
    bool rim_far;                     /* discs reach beyond the pixels beside their own */
    bool rim_large;                   /* some may be large there */
    struct plan_tile *tile;
    struct axis_lists axis;                   /* of the axis method; owned */
    struct axis_blocks axis_blocks;           /* by compute */
    double environment_axes[3][3];            /* world: right of the map's centre, up, its centre */
    uint32_t group_first[STP_MAX_GROUPS + 1]; /* raster: splats of a group in the order buffer */
    uint32_t cover_first[STP_MAX_GROUPS + 1]; /* fast, nearest: members of a group there */
};

/* plan/plan.c: params, or the defaults where NULL. */
const struct stp_render_params *plan_params(const struct stp_render_params *params);
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

/* One file a paper appends its resources and passes, for tiles of the given size. */
void plan_deferred(struct stp_plan *plan);
void plan_exact(struct stp_plan *plan);
void plan_twopass(struct stp_plan *plan);
uint32_t plan_sum_words(const struct stp_plan *plan); /* of a pixel, by compute */
void plan_axis(struct stp_plan *plan);
/* axis_surface.c: of points and splats, drawn as flat Gaussians. */
bool plan_axis_asked(const struct stp_plan *plan);
enum stp_result plan_check_axis_surface(const struct stp_env *env, const struct stp_plan *plan);
void plan_axis_surface_project(struct stp_plan *plan);
void plan_surface_resources(struct stp_plan *plan); /* tile.c: splats and what goes with them */
void plan_materials(struct stp_plan *plan);         /* of several objects */

/* Their kernels, and by compute the blocks that they touch. */
void plan_axis_resources(struct stp_plan *plan);
/* Of a copy: the lists' arrays are the original's. */
void plan_axis_forget(struct stp_plan *plan);

/* plan/axis.c: the lists of the view, and what shaders need to know of the kernels. */
enum stp_result plan_axis_prepare(const struct stp_env *env, struct stp_plan *plan,
                                  const struct stp_scene *scene);

/* plan/pyramid.c */
void plan_pyramid(struct stp_plan *plan);
void plan_pyramid_resources(struct stp_plan *plan);
/* plan/pyramid_view.c: what a pyramid of the plan's scene and view stands on, and what one tile's
 * does. A pixel that the tile keeps has the same bits in both. */
void plan_pyramid_view(struct stp_plan *plan); /* levels, grid and constants; once a plan */
bool plan_has_clusters(const struct stp_plan *plan);
struct plan_grid plan_tile_grid(const struct stp_plan *plan, const struct plan_tile *tile);
/* Workgroups of a pass over one level of a grid. */
uint32_t plan_level_blocks(const struct plan_grid *grid, uint32_t level);
/* plan/pyramid_chunks.c: the points on the device at once, at most. */
uint64_t plan_chunk_points(const struct stp_plan *plan);
/* Cuts the points into chunks where the device cannot hold them all; false: not even so. */
bool plan_pyramid_chunks(struct stp_plan *plan);
void plan_transparent(struct stp_plan *plan);
/* Do its images hold what a nearest fragment adds to the mean, in the place of its id? If no id is
 * wanted besides. */
bool plan_packs_winners(const struct stp_plan *plan);
/* Before the two-pass method is repeated for every layer: nothing is peeled; where what is opaque
 * ends the rays. */
void plan_peel_begin(struct stp_plan *plan);

/* plan/frame.c: the view, in double, to the constants that shaders read. */
void plan_frame_constants(struct stp_plan *plan, const struct stp_scene *scene);

/* What shaders read of an object's material. */
struct scene_object;
struct stp_material_gpu plan_material(const struct stp_plan *plan,
                                      const struct scene_object *object);

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
/* The most that looking light up moves a colour; 0 without. */
double plan_light_cube_error(const struct stp_plan *plan, const struct stp_scene *scene);
/* The largest size of `count` values. */
double plan_largest(const float *value, unsigned count);
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

/* plan/version.c: which part of `version` is not what the plan was made of: "scene", "content",
 * "grouping" or "cover"; NULL: the plan is for it. The grouping matters only to a plan of the
 * deferred method, the cover only where the plan takes its groups. Lights, and how the scene is to
 * be framed, are copied by the plan: they may change. */
struct stp_scene;
const char *plan_differs(const struct stp_plan *plan, const struct scene_version *version);
/* The same of a scene as it is now, as an error. */
enum stp_result plan_check_scene(const struct stp_env *env, const struct stp_plan *plan,
                                 const struct stp_scene *scene);

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
