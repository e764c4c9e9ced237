/* Marroquim, Kraus & Cavalcanti 2007: every point to one pixel, then a pyramid is pulled and
 * pushed. */
#include "plan/plan.h"

#include <stdio.h>

/* The largest grid of any tile; where it begins does not matter. */
static void largest_grid(const struct stp_plan *plan, uint32_t *width, uint32_t *height)
{
    uint32_t margin = 2u << plan->levels, slack = 2 * STP_BLOCK;
    bool whole = plan->tile_width == plan->camera.width && plan->tile_height == plan->camera.height;
    uint32_t wide = plan->tile_width + margin + slack, high = plan->tile_height + margin + slack;
    *width = whole || wide > plan->grid.width ? plan->grid.width : wide / STP_BLOCK * STP_BLOCK;
    *height = whole || high > plan->grid.height ? plan->grid.height : high / STP_BLOCK * STP_BLOCK;
}

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
    if (plan_has_clusters(plan))
        texels(plan, "clusters", PLAN_TEXEL_CLUSTERS, PLAN_TEXELS_RGBA32UI,
               (n + STP_CLUSTER - 1) / STP_CLUSTER * 32);
    plan_materials(plan);
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

static bool may_fetch(const struct stp_plan *plan, uint64_t texels)
{
    return (plan->limits.features & STP_FEATURE_TEXEL_BUFFERS) && texels <= plan->limits.max_texels;
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
    uint8_t keys = plan_resource(plan, "keys", PLAN_KEYS, PLAN_TRANSIENT, pixels * 8);
    if (may_fetch(plan, pixels))
        plan->resource[keys].format = PLAN_TEXELS_RG32UI;
    plan_resource(plan, "rim", PLAN_RIM, PLAN_TRANSIENT, pixels * (plan->rim_far ? 8 : 4));
    uint64_t points = plan_chunk_points(plan);
    if (plan->rim_far)
        plan_resource(plan, "reaching", PLAN_LARGE, PLAN_TRANSIENT,
                      (points + (points + STP_CLUSTER - 1) / STP_CLUSTER) * 4);
    plan_resource(plan, "work", PLAN_WORK, PLAN_TRANSIENT,
                  (STP_WORK_FLAGS + STP_WORK_BLOCK_WORDS * blocks) * 4);
}

void plan_pyramid_resources(struct stp_plan *plan)
{
    scene_resources(plan);
    transient_resources(plan);
}

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
    plan_reads(plan, pass, PLAN_TEXEL_CLUSTERS);
    plan_updates(plan, pass, PLAN_KEYS);
    if (plan->rim_far)
        plan_writes(plan, pass, PLAN_WORK);
}

/* Without 64-bit atomics the ids take a pass of their own, with the same outcome. */
static void project_all(struct stp_plan *plan)
{
    plan_fill(plan, PLAN_KEYS, STP_NO_POINT, "clear keys");
    plan_fill(plan, PLAN_IMAGE_PYRAMID, 0x7f800000u, "clear pyramid"); /* depths: infinite */
    if (plan->rim_far)
        plan_fill(plan, PLAN_RIM, 0x7f800000u, "clear limits");
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
    bool fetched = plan->resource[plan_find(plan, PLAN_KEYS)].format == PLAN_TEXELS_RG32UI;
    enum plan_shader shader =
        fetched ? PLAN_SHADER_PYRAMID_GATHER_FETCHED : PLAN_SHADER_PYRAMID_GATHER;
    struct plan_pass *pass = dispatch(plan, "gather", shader + attributes);
    plan_reads(plan, pass, PLAN_TEXEL_POINTS);
    plan_reads(plan, pass, PLAN_TEXEL_RADII);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OBJECTS);
    plan_reads(plan, pass, PLAN_KEYS);
    plan_writes(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_writes(plan, pass, PLAN_IMAGE_ATTRIBUTES);
    plan_updates(plan, pass, PLAN_WORK);
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

/* Level 1 passes over blocks that no point fell into. */
static void pull(struct stp_plan *plan, uint32_t level, unsigned attributes)
{
    struct plan_pass *pass = level_pass(plan, "pull", level, PLAN_SHADER_PYRAMID_PULL + attributes);
    if (level == 1)
        plan_reads(plan, pass, PLAN_WORK);
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

/* What shades pixels; the rest that it accesses is its caller's to say. */
static struct plan_pass *shade(struct stp_plan *plan, const char *name, enum plan_shader shader,
                               uint32_t argument)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, name);
    pass->shader = shader;
    pass->offset = argument * 4;
    plan_reads(plan, pass, PLAN_WORK);
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
    return pass;
}

/* Lists blocks and keeps a bit a pixel for the passes over the rim. */
static void push_and_shade(struct stp_plan *plan, unsigned attributes)
{
    struct plan_pass *pass =
        shade(plan, "push 0 and shade", PLAN_SHADER_PYRAMID_SHADE + attributes, STP_WORK_BLOCKS);
    plan_updates(plan, pass, PLAN_WORK);
    plan_writes(plan, pass, PLAN_RIM);
    if (plan->rim_far)
        plan_writes(plan, pass, PLAN_KEYS);
}

/* Reads the depths that the push left. */
static void rim_near(struct stp_plan *plan, unsigned attributes)
{
    struct plan_pass *pass =
        shade(plan, "rim near", PLAN_SHADER_PYRAMID_RIM_NEAR + attributes, STP_WORK_LOOK);
    plan_reads(plan, pass, PLAN_RIM);
    plan_reads(plan, pass, PLAN_OUT_DEPTH);
    if (plan->rim_far) {
        plan_updates(plan, pass, PLAN_WORK);
        plan_updates(plan, pass, PLAN_RIM);
        plan_writes(plan, pass, PLAN_KEYS);
    }
}

static void rim_clusters(struct stp_plan *plan)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "rim clusters");
    pass->shader = PLAN_SHADER_PYRAMID_RIM_CLUSTERS;
    pass->of_points = true;
    plan_reads(plan, pass, PLAN_TEXEL_CLUSTERS);
    plan_updates(plan, pass, PLAN_WORK);
    plan_writes(plan, pass, PLAN_LARGE);
}

/* What looks at points again, with the argument of its indirect dispatch. */
static struct plan_pass *rim_points(struct stp_plan *plan, const char *name,
                                    enum plan_shader shader, uint32_t argument)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, name);
    pass->shader = shader;
    pass->offset = argument * 4;
    plan_reads(plan, pass, PLAN_WORK);
    plan_reads(plan, pass, PLAN_TEXEL_POINTS);
    plan_reads(plan, pass, PLAN_TEXEL_RADII);
    return pass;
}

static void rim_find(struct stp_plan *plan)
{
    struct plan_pass *pass =
        rim_points(plan, "rim find", PLAN_SHADER_PYRAMID_RIM_FIND, STP_WORK_FIND);
    plan_updates(plan, pass, PLAN_WORK);
    plan_updates(plan, pass, PLAN_LARGE);
}

static void rim_splat(struct stp_plan *plan, const char *name, enum plan_shader shader,
                      uint32_t argument)
{
    struct plan_pass *pass = rim_points(plan, name, shader, argument);
    plan_reads(plan, pass, PLAN_LARGE);
    plan_reads(plan, pass, PLAN_RIM);
    plan_updates(plan, pass, PLAN_KEYS);
}

/* Small discs and, where there may be some, large ones. */
static void rim_splats(struct stp_plan *plan, const char *name, enum plan_shader shader)
{
    char large[40];
    snprintf(large, sizeof large, "%s, large", name);
    rim_splat(plan, name, shader, STP_WORK_RIM);
    if (plan->rim_large)
        rim_splat(plan, large, shader + 1, STP_WORK_LARGE);
}

/* Points that reach open pixels into level 0. */
static void rim_take(struct stp_plan *plan, unsigned attributes)
{
    struct plan_pass *pass =
        rim_points(plan, "rim take", PLAN_SHADER_PYRAMID_RIM_TAKE + attributes, STP_WORK_OPEN);
    plan_updates(plan, pass, PLAN_WORK);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OBJECTS);
    plan_reads(plan, pass, PLAN_KEYS);
    plan_writes(plan, pass, PLAN_IMAGE_PYRAMID);
    plan_writes(plan, pass, PLAN_IMAGE_ATTRIBUTES);
}

/* Discs reach farther than the pixels beside their centres. */
static void rim_far(struct stp_plan *plan, unsigned attributes)
{
    plan->again_first = plan->pass_count;
    rim_clusters(plan);
    rim_find(plan);
    if (plan->constant[PLAN_ATOMIC64]) {
        rim_splats(plan, "rim splat", PLAN_SHADER_PYRAMID_RIM_SPLAT);
    } else {
        rim_splats(plan, "rim splat depth", PLAN_SHADER_PYRAMID_RIM_SPLAT32);
        rim_splats(plan, "rim splat id", PLAN_SHADER_PYRAMID_RIM_SPLAT_ID32);
    }
    rim_take(plan, attributes);
    plan->again_end = plan->pass_count;
    struct plan_pass *pass =
        shade(plan, "rim shade", PLAN_SHADER_PYRAMID_RIM_SHADE + attributes, STP_WORK_OPEN);
    plan_reads(plan, pass, PLAN_RIM);
    plan_reads(plan, pass, PLAN_KEYS);
    plan_reads(plan, pass, PLAN_OUT_DEPTH);
}

void plan_pyramid(struct stp_plan *plan)
{
    unsigned attributes = attributes_of(plan);
    project_all(plan);
    gather(plan, attributes);
    for (uint32_t level = 1; level < plan->levels; level++)
        pull(plan, level, attributes);
    for (uint32_t level = plan->levels - 1; level-- > STP_BLOCK_LEVEL;)
        level_pass(plan, "push", level, PLAN_SHADER_PYRAMID_PUSH + attributes);
    blocks(plan);
    push_listed(plan, 2, STP_WORK_LEVEL_2, attributes);
    push_listed(plan, 1, STP_WORK_LEVEL_1, attributes);
    push_and_shade(plan, attributes);
    rim_near(plan, attributes);
    if (plan->rim_far)
        rim_far(plan, attributes);
}
