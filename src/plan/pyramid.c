/* Marroquim, Kraus & Cavalcanti 2007: every point to one pixel, then a pyramid is pulled and
 * pushed. */
#include "plan/plan.h"

#include <math.h>
#include <stdio.h>

#include "base/vec.h"

#define LEAST_LEVELS 4 /* blocks of the picture are texels of the coarsest of these */
#define NEAR_REACH   1.5
#define MOST_CROWD   0.6 /* glsl/lib/rim.glsl has these two */
#define MOST_GUARD   64  /* pixels beyond the picture's edges, where discs that reach in may lie */

/* --- what a pyramid stands on ----------------------------------------------------------------- */

/* The scene's bounds on the screen, pixels, discs included. */
struct outline {
    double low[2],
        high[2];   /* of the picture that the scene can touch; infinite when the eye is in it */
    double radius; /* the largest on the screen */
};

static void add_corner(const struct stp_plan *plan, struct vec3 corner, struct outline *o)
{
    const struct stp_camera *c = &plan->camera;
    struct vec3 p = m4_point(c->world_to_camera, corner);
    double scale = c->orthographic ? 1 : 1 / -p.z;
    double at[2] = { c->cx + c->fx * p.x * scale, c->cy - c->fy * p.y * scale };
    bool before = !c->orthographic && !(-p.z > c->near_depth);
    for (int k = 0; k < 2; k++) {
        o->low[k] = fmin(o->low[k], before ? -INFINITY : at[k]);
        o->high[k] = fmax(o->high[k], before ? INFINITY : at[k]);
    }
}

static struct outline find_outline(const struct stp_plan *plan)
{
    const struct stp_camera *c = &plan->camera;
    const double *b = plan->facts.bounds;
    struct outline o = { { INFINITY, INFINITY }, { -INFINITY, -INFINITY }, 0 };
    double nearest = INFINITY;
    for (int i = 0; i < 8; i++) {
        struct vec3 corner = v3(b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]);
        nearest = fmin(nearest, -m4_point(c->world_to_camera, corner).z);
        add_corner(plan, corner, &o);
    }
    double focal = fmax(c->fx, c->fy);
    o.radius =
        plan->facts.radius_max * focal / (c->orthographic ? 1 : fmax(nearest, c->near_depth));
    o.radius = fmax(o.radius, plan->frame.pyramid_floor);
    return o;
}

static uint32_t levels_of(const struct stp_plan *plan, double radius)
{
    double longest = fmax(plan->camera.width, plan->camera.height);
    double most = ceil(log2(longest)) + 1, wanted = ceil(log2(fmax(2 * radius, 1))) + 1;
    double levels = fmax(fmin(wanted, most), LEAST_LEVELS);
    return levels < STP_LEVELS ? (uint32_t)levels : STP_LEVELS;
}

/* Whole blocks that hold [low, high) of one axis. */
static void snap(double low, double high, int32_t *first, uint32_t *length)
{
    int32_t from = (int32_t)floor(low / STP_BLOCK), to = (int32_t)ceil(high / STP_BLOCK);
    *first = from * STP_BLOCK;
    *length = (uint32_t)(to > from ? to - from : 1) * STP_BLOCK;
}

static void grid_axis(double size, const struct outline *o, int axis, int32_t *first,
                      uint32_t *length)
{
    double guard = fmin(ceil(o->radius) + 1, MOST_GUARD), slack = o->radius + 1;
    double low = fmax(-guard, o->low[axis] - slack),
           high = fmin(size + guard, o->high[axis] + slack);
    if (!(high > low)) /* nothing is in view */
        low = 0, high = 1;
    snap(low, high, first, length);
}

/* Some points may be outside of it. */
static bool leaves_picture(const struct stp_plan *plan, const struct outline *o)
{
    return o->low[0] < 0 || o->low[1] < 0 || o->high[0] > plan->camera.width ||
           o->high[1] > plan->camera.height;
}

void plan_pyramid_view(struct stp_plan *plan)
{
    struct stp_frame_constants *f = &plan->frame;
    float median = plan->facts.radius_median;
    f->radius_unit = median > 0 ? median : 1;
    f->radius_scale = 1 / f->radius_unit;
    f->pyramid_floor = f->floor_size / 2;
    f->block_reach = 1;
    f->pyramid_color = plan->facts.color_max > 1 ? 1 / plan->facts.color_max : 1;
    struct outline o = find_outline(plan);
    plan->levels = levels_of(plan, o.radius);
    plan->rim_far = o.radius + MOST_CROWD > NEAR_REACH;
    if (plan->levels > 6) /* discs of more than a block and a half */
        f->block_reach = plan->levels > 8 ? 4 : 2;
    plan->constant[PLAN_CULL_CLUSTERS] = plan->constant[PLAN_CULL_BACK] || leaves_picture(plan, &o);
    plan->constant[PLAN_LANES] = plan->limits.processor == 1 ? STP_BLOCK : STP_GROUP;
    grid_axis(plan->camera.width, &o, 0, &plan->grid.x, &plan->grid.width);
    grid_axis(plan->camera.height, &o, 1, &plan->grid.y, &plan->grid.height);
}

/* A pixel is made from texels of the coarsest level that touch the texel it lies in: what lies
 * 2^levels pixels away cannot reach it. */
static void tile_axis(uint32_t levels, int32_t grid, uint32_t grid_length, uint32_t tile,
                      uint32_t tile_length, int32_t *first, uint32_t *length)
{
    double margin = ldexp(1, (int)levels);
    double low = fmax(tile - margin, grid), end = (double)grid + grid_length;
    double high = fmin((double)tile + tile_length + margin, end);
    if (!(high > low))
        low = tile, high = low + 1;
    snap(low, high, first, length);
}

struct plan_grid plan_tile_grid(const struct stp_plan *plan, const struct plan_tile *tile)
{
    struct plan_grid grid = plan->grid;
    bool whole = tile->width == plan->camera.width && tile->height == plan->camera.height;
    if (whole)
        return grid;
    tile_axis(plan->levels, plan->grid.x, plan->grid.width, tile->x, tile->width, &grid.x,
              &grid.width);
    tile_axis(plan->levels, plan->grid.y, plan->grid.height, tile->y, tile->height, &grid.y,
              &grid.height);
    return grid;
}

static uint32_t level_length(int32_t first, uint32_t length, uint32_t level)
{
    int32_t last = first + (int32_t)length - 1;
    return (uint32_t)((last >> level) - (first >> level)) + 1;
}

uint32_t plan_level_blocks(const struct plan_grid *grid, uint32_t level)
{
    uint32_t width = level_length(grid->x, grid->width, level);
    uint32_t height = level_length(grid->y, grid->height, level);
    return ((width + STP_BLOCK - 1) / STP_BLOCK) * ((height + STP_BLOCK - 1) / STP_BLOCK);
}

/* The largest grid of any tile; where it begins does not matter. */
static void largest_grid(const struct stp_plan *plan, uint32_t *width, uint32_t *height)
{
    uint32_t margin = 2u << plan->levels, slack = 2 * STP_BLOCK;
    bool whole = plan->tile_width == plan->camera.width && plan->tile_height == plan->camera.height;
    uint32_t wide = plan->tile_width + margin + slack, high = plan->tile_height + margin + slack;
    *width = whole || wide > plan->grid.width ? plan->grid.width : wide / STP_BLOCK * STP_BLOCK;
    *height = whole || high > plan->grid.height ? plan->grid.height : high / STP_BLOCK * STP_BLOCK;
}

/* --- resources -------------------------------------------------------------------------------- */

static uint8_t texels(struct stp_plan *plan, const char *name, enum plan_slot slot,
                      enum plan_format format, uint64_t bytes)
{
    uint8_t at = plan_resource(plan, name, slot, PLAN_SCENE, bytes);
    plan->resource[at].format = format;
    return at;
}

static void scene_resources(struct stp_plan *plan)
{
    uint64_t n = plan_chunk_points(plan);
    texels(plan, "points", PLAN_TEXEL_POINTS, PLAN_TEXELS_RGBA32UI, n * 16);
    texels(plan, "radii", PLAN_TEXEL_RADII, PLAN_TEXELS_R32F, n * 4);
    if (plan->facts.has_color)
        plan_resource(plan, "colors", PLAN_COLORS, PLAN_SCENE, n * 12);
    if (plan->facts.objects > 1)
        plan_resource(plan, "objects", PLAN_OBJECTS, PLAN_SCENE, n * 4);
    if (plan->constant[PLAN_CULL_CLUSTERS])
        plan_resource(plan, "clusters", PLAN_CLUSTERS, PLAN_SCENE,
                      (n + STP_CLUSTER - 1) / STP_CLUSTER * 32);
    plan_resource(plan, "materials", PLAN_MATERIALS, PLAN_SCENE,
                  plan->facts.objects * sizeof(struct stp_material_gpu));
}

/* 0: none; 1: colours; 2: colours, ids and objects. */
static unsigned attributes_of(const struct stp_plan *plan)
{
    bool color_format = (plan->limits.features & STP_FEATURE_STORAGE_FORMATS) != 0;
    if (plan->facts.objects > 1 || (plan->constant[PLAN_AOVS] & 2))
        return 2;
    if (plan->facts.has_color && !color_format) /* R32G32 images are an extended format */
        return 2;
    return plan->facts.has_color ? 1 : 0;
}

static void level_image(struct stp_plan *plan, const char *name, enum plan_slot slot,
                        enum plan_format format, uint32_t width, uint32_t height)
{
    uint8_t at = plan_image(plan, name, slot, format, 1);
    struct plan_resource *r = &plan->resource[at];
    r->width = width;
    r->height = height;
    r->bytes = (uint64_t)width * height * (format == PLAN_RGBA32UI ? 16 : 8);
}

static void transient_resources(struct stp_plan *plan)
{
    uint32_t width, height, row = 0;
    largest_grid(plan, &width, &height);
    plan->frame.level_column = width;
    for (uint32_t level = 1; level < plan->levels; level++) {
        plan->frame.level_row[level] = row;
        row += (height >> level) + 2;
    }
    uint32_t all_width = width + (width >> 1) + 2, all_height = height > row ? height : row;
    level_image(plan, "pyramid", PLAN_IMAGE_PYRAMID, PLAN_RGBA32UI, all_width, all_height);
    unsigned attributes = attributes_of(plan);
    if (attributes)
        level_image(plan, "attributes", PLAN_IMAGE_ATTRIBUTES,
                    attributes == 2 ? PLAN_RGBA32UI : PLAN_RG32UI, all_width, all_height);
    uint64_t pixels = (uint64_t)width * height, blocks = pixels / STP_GROUP;
    plan_resource(plan, "keys", PLAN_KEYS, PLAN_TRANSIENT, pixels * 8);
    plan_resource(plan, "rim", PLAN_RIM, PLAN_TRANSIENT, pixels * 4);
    plan_resource(plan, "work", PLAN_WORK, PLAN_TRANSIENT, (STP_WORK_FLAGS + 2 * blocks) * 4);
}

void plan_pyramid_resources(struct stp_plan *plan)
{
    scene_resources(plan);
    transient_resources(plan);
}

/* --- passes ----------------------------------------------------------------------------------- */

static struct plan_pass *dispatch(struct stp_plan *plan, const char *name, enum plan_shader shader)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, name);
    pass->shader = shader;
    pass->of_grid = true;
    return pass;
}

static void project(struct stp_plan *plan, const char *name, enum plan_shader shader)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, name);
    pass->shader = shader;
    pass->of_points = true;
    plan_reads(plan, pass, PLAN_TEXEL_POINTS);
    plan_reads(plan, pass, PLAN_CLUSTERS);
    plan_updates(plan, pass, PLAN_KEYS);
}

/* Without 64-bit atomics the ids take a pass of their own, with the same outcome. */
static void project_all(struct stp_plan *plan)
{
    plan_fill(plan, PLAN_KEYS, STP_NO_POINT, "clear keys");
    plan->chunk_first = plan->pass_count;
    if (plan->constant[PLAN_ATOMIC64]) {
        project(plan, "project", PLAN_SHADER_PYRAMID_PROJECT);
        return;
    }
    project(plan, "project depth", PLAN_SHADER_PYRAMID_PROJECT32);
    project(plan, "project id", PLAN_SHADER_PYRAMID_PROJECT_ID32);
}

static void gather(struct stp_plan *plan, unsigned attributes)
{
    struct plan_pass *pass = dispatch(plan, "gather", PLAN_SHADER_PYRAMID_GATHER + attributes);
    plan_reads(plan, pass, PLAN_TEXEL_POINTS);
    plan_reads(plan, pass, PLAN_TEXEL_RADII);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OBJECTS);
    plan_reads(plan, pass, PLAN_KEYS);
    plan_writes(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_writes(plan, pass, PLAN_IMAGE_ATTRIBUTES);
    plan->chunk_end = plan->pass_count;
}

static struct plan_pass *level_pass(struct stp_plan *plan, const char *verb, uint32_t level,
                                    enum plan_shader shader)
{
    char name[40];
    snprintf(name, sizeof name, "%s %u", verb, level);
    struct plan_pass *pass = dispatch(plan, name, shader);
    pass->level = level;
    plan_updates(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_updates(plan, pass, PLAN_IMAGE_ATTRIBUTES);
    return pass;
}

static void blocks(struct stp_plan *plan)
{
    struct plan_pass *pass = dispatch(plan, "blocks", PLAN_SHADER_PYRAMID_BLOCKS);
    pass->level = STP_BLOCK_LEVEL; /* a thread a block, 64 of them a group */
    plan_reads(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_updates(plan, pass, PLAN_WORK);
}

static void push_listed(struct stp_plan *plan, uint32_t level, uint32_t argument,
                        unsigned attributes)
{
    struct plan_pass *pass =
        level_pass(plan, "push", level, PLAN_SHADER_PYRAMID_PUSH_LISTED + attributes);
    pass->kind = PLAN_DISPATCH_INDIRECT;
    pass->offset = argument * 4;
    plan_reads(plan, pass, PLAN_WORK);
}

static void shade(struct stp_plan *plan, const char *name, enum plan_shader shader,
                  uint32_t argument)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, name);
    pass->shader = shader;
    pass->offset = argument * 4;
    plan_updates(plan, pass, PLAN_WORK);
    plan_updates(plan, pass, PLAN_RIM);
    plan_updates(plan, pass, PLAN_KEYS);
    plan_reads(plan, pass, PLAN_MATERIALS);
    plan_reads(plan, pass, PLAN_OBJECT_OPTICS);
    plan_reads(plan, pass, PLAN_ENVIRONMENT);
    plan_reads(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_reads(plan, pass, PLAN_IMAGE_ATTRIBUTES);
    for (enum plan_slot slot = PLAN_OUT_COLOR; slot <= PLAN_OUT_ID; slot++)
        if (plan_samples(plan) > 1)
            plan_updates(plan, pass, slot);
        else
            plan_writes(plan, pass, slot);
}

static void rim_splat(struct stp_plan *plan, const char *name, enum plan_shader shader)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, name);
    pass->shader = shader;
    pass->offset = STP_WORK_RIM * 4;
    plan_reads(plan, pass, PLAN_WORK);
    plan_reads(plan, pass, PLAN_RIM);
    plan_reads(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_updates(plan, pass, PLAN_KEYS);
}

/* Discs reach farther than the pixels beside their centres. */
static void rim_far(struct stp_plan *plan, unsigned attributes)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, "rim find");
    pass->shader = PLAN_SHADER_PYRAMID_RIM_FIND;
    pass->offset = STP_WORK_BLOCKS * 4;
    plan_updates(plan, pass, PLAN_WORK);
    plan_reads(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_updates(plan, pass, PLAN_RIM);
    if (plan->constant[PLAN_ATOMIC64]) {
        rim_splat(plan, "rim splat", PLAN_SHADER_PYRAMID_RIM_SPLAT);
    } else {
        rim_splat(plan, "rim splat depth", PLAN_SHADER_PYRAMID_RIM_SPLAT32);
        rim_splat(plan, "rim splat id", PLAN_SHADER_PYRAMID_RIM_SPLAT_ID32);
    }
    shade(plan, "rim shade", PLAN_SHADER_PYRAMID_RIM_SHADE + attributes, STP_WORK_BLOCKS);
}

void plan_pyramid(struct stp_plan *plan)
{
    unsigned attributes = attributes_of(plan);
    project_all(plan);
    gather(plan, attributes);
    for (uint32_t level = 1; level < plan->levels; level++)
        level_pass(plan, "pull", level, PLAN_SHADER_PYRAMID_PULL + attributes);
    for (uint32_t level = plan->levels - 1; level-- > STP_BLOCK_LEVEL;)
        level_pass(plan, "push", level, PLAN_SHADER_PYRAMID_PUSH + attributes);
    blocks(plan);
    push_listed(plan, 2, STP_WORK_LEVEL_2, attributes);
    push_listed(plan, 1, STP_WORK_LEVEL_1, attributes);
    shade(plan, "push 0 and shade", PLAN_SHADER_PYRAMID_SHADE + attributes, STP_WORK_BLOCKS);
    shade(plan, "rim near", PLAN_SHADER_PYRAMID_RIM_NEAR + attributes, STP_WORK_EMPTY);
    if (plan->rim_far)
        rim_far(plan, attributes);
}
