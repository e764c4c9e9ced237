/* HM 5: every walk in the order of its list into its own pair of images by the rasteriser, or into
 * its own sums block by block in compute; then one pass that merges them by what each pixel's ray
 * says. */
#include "plan/plan.h"

#include <math.h>
#include <stdio.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"
#include "prepare/axis_region.h"
#include "scene/scene.h"
#include "scene/volume.h"

#define MOST_PASSES 64 /* over blocks: parts of walks */
_Static_assert(AXIS_BLOCK_WIDTH == STP_AXIS_WIDTH && AXIS_BLOCK_HEIGHT == STP_AXIS_HEIGHT &&
                   MOST_PASSES + 2 <= PLAN_MAX_PASSES,
               "blocks");

/* R of QR of the matrix whose columns are those of the shape; cross products lose no digits of
 * kernels that are long and thin. */
static void set_factor(const double shape[3][3], float factor[6])
{
    struct vec3 column[3];
    for (int i = 0; i < 3; i++)
        column[i] = v3(shape[0][i], shape[1][i], shape[2][i]);
    struct vec3 xy = v3_cross(column[0], column[1]), xz = v3_cross(column[0], column[2]);
    double first = v3_length(column[0]), area = v3_length(xy);
    factor[0] = (float)first;
    factor[1] = (float)(v3_dot(column[0], column[1]) / first);
    factor[2] = (float)(v3_dot(column[0], column[2]) / first);
    factor[3] = (float)(area / first);
    factor[4] = (float)(v3_dot(xy, xz) / (first * area));
    factor[5] = (float)(fabs(v3_dot(xy, column[2])) / area);
}

/* Of a grid's kernels, in the frame of the shaders: x right, y down, z forward. */
static void set_shape(struct stp_plan *plan, const struct volume *volume)
{
    struct stp_axis_gpu *axis = &plan->frame.axis;
    double half[3] = { 0 }, shape[3][3];
    for (int a = 0; a < 3; a++) {
        double s = KERNEL_SIGMA * volume->grid.spacing[a];
        const double *m = plan->camera.world_to_camera;
        const double d[3] = { m[a], -m[4 + a], -m[8 + a] };
        for (int i = 0; i < 3; i++) {
            half[i] += s * s * d[i] * d[i];
            shape[a][i] = d[i] / s;
            axis->shape[3 * a + i] = (float)shape[a][i];
        }
    }
    set_factor(shape, axis->factor);
    for (int i = 0; i < 3; i++)
        axis->extent[i] = (float)(KERNEL_REACH * sqrt(half[i]));
    axis->scale = (float)(kernel_amplitude() * sqrt(2 * M_PI));
}

/* Does near or far cut an ellipsoid or a disc that is drawn? An ellipsoid's tails beyond the reach
 * count too, as below. */
static bool is_any_cut(const struct stp_plan *plan, const struct stp_scene *scene)
{
    struct axis_view view = axis_view(scene, &plan->camera);
    bool discs = view.shape == AXIS_DISCS;
    for (size_t i = 0; i < plan->axis.count; i++) {
        struct axis_kernel kernel;
        if (!axis_kernel(&view, plan->axis.order[i], &kernel))
            continue;
        double depth = -m4_point(plan->camera.world_to_camera, v3_load(kernel.centre)).z;
        double half = discs ? scene->splats.radius[plan->axis.order[i]] : 1.5 * kernel.own.half[2];
        if (depth - half < plan->camera.near_depth || depth + half > plan->camera.far_depth)
            return true;
    }
    return false;
}

/* Does near or far cut any kernel? Else shaders have no code for it. */
static bool is_cut(const struct stp_plan *plan, const struct stp_scene *scene)
{
    const double *b = scene->core;
    if (axis_shape(scene) != AXIS_VOXELS)
        return is_any_cut(plan, scene);
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 8; i++) {
        struct vec3 corner = v3(b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]);
        double depth = -m4_point(plan->camera.world_to_camera, corner).z;
        low = fmin(low, depth);
        high = fmax(high, depth);
    }
    /* The tails beyond the reach: half as much again leaves a share of 1 - 3e-6. */
    double more = 0.5 * (double)plan->frame.axis.extent[2];
    return low - more < plan->camera.near_depth || high + more > plan->camera.far_depth;
}

/* All walks in one pass, unless some block has more splats than a pass may take. */
static bool in_parts(const struct stp_plan *plan)
{
    return plan->axis_blocks.fullest > STP_AXIS_PART;
}

static uint32_t parts_of(const struct stp_plan *plan)
{
    return (uint32_t)((plan->axis_blocks.longest + STP_AXIS_PART - 1) / STP_AXIS_PART);
}

static enum stp_result prepare_blocks(const struct stp_env *env, struct stp_plan *plan)
{
    enum stp_result result = axis_blocks_update(env, &plan->axis, &plan->axis_blocks);
    if (result != STP_OK)
        return result;
    axis_blocks_trim(&plan->axis_blocks); /* the lists are made */
    plan->frame.axis.blocks_x = plan->axis_blocks.across;
    plan->frame.axis.blocks_y = plan->axis_blocks.down;
    if (parts_of(plan) * plan->axis.walk_count <= MOST_PASSES)
        return STP_OK;
    return log_error(env, STP_ERROR_ARGUMENT,
                     "%zu splats of one list lie in %d x %d pixels; a picture so small takes "
                     "--path raster",
                     plan->axis_blocks.longest, AXIS_BLOCK_WIDTH, AXIS_BLOCK_HEIGHT);
}

enum stp_result plan_axis_prepare(const struct stp_env *env, struct stp_plan *plan,
                                  const struct stp_scene *scene)
{
    double h = plan->params.axis_h == 0 ? STP_DEFAULT_AXIS_H : fmax(plan->params.axis_h, 0);
    if (!(h < 1))
        return log_error(env, STP_ERROR_ARGUMENT, "axis h %g: it must be below 1", h);
    plan->axis = (struct axis_lists){ .merge = plan->params.axis_merge, .h = h };
    plan->axis.look =
        (struct axis_look){ plan->params.cull == STP_CULL_BACK, (double)plan->frame.floor_size };
    enum stp_result result = axis_lists_update(env, scene, &plan->camera, &plan->axis);
    if (result != STP_OK)
        return result;
    struct stp_axis_gpu *axis = &plan->frame.axis;
    enum axis_shape shape = axis_shape(scene);
    if (shape == AXIS_VOXELS)
        set_shape(plan, scene->volume);
    axis->h = (float)h;
    axis->merge = (uint32_t)(STP_AXIS_MERGE_BLEND + plan->params.axis_merge - STP_AXIS_BLEND);
    for (unsigned i = 0; i < plan->axis.walk_count; i++)
        axis->walk[i] = plan->axis.walk[i].axis | (plan->axis.walk[i].backwards ? 4u : 0u);
    plan->constant[PLAN_AXIS_WALKS] = plan->axis.walk_count;
    plan->constant[PLAN_AXIS_CUT] = is_cut(plan, scene);
    plan->constant[PLAN_UNLIT] = scene->volume && scene->volume->unshaded;
    plan->constant[PLAN_AXIS_SHAPE] = shape;
    return plan->path == STP_PATH_COMPUTE && plan->axis.count ? prepare_blocks(env, plan) : STP_OK;
}

static void name_walk(const struct stp_plan *plan, unsigned index, char *name, size_t size)
{
    static const char *const names[] = { "+x", "-x", "+y", "-y", "+z", "-z" };
    snprintf(name, size, "walk %s",
             plan->axis.merge == STP_AXIS_SORT ? "by distance"
                                               : names[axis_walk_bit(&plan->axis.walk[index])]);
}

static void draw_walk(struct stp_plan *plan, unsigned index)
{
    const struct axis_walk *walk = &plan->axis.walk[index];
    char name[40];
    name_walk(plan, index, name, sizeof name);
    struct plan_pass *pass = plan_pass(plan, PLAN_DRAW, name);
    bool discs = plan->constant[PLAN_AXIS_SHAPE] == AXIS_DISCS;
    pass->vertex = discs ? PLAN_SHADER_AXIS_SURFACE_VERTEX : PLAN_SHADER_AXIS_VERTEX;
    pass->shader = discs ? PLAN_SHADER_AXIS_SURFACE_FRAGMENT : PLAN_SHADER_AXIS_FRAGMENT;
    pass->raster = PLAN_RASTER_OVER;
    pass->layer = index;
    pass->layer_count = 1;
    pass->first_splat = walk->first;
    pass->splat_count = walk->count;
    plan_reads(plan, pass, PLAN_PROJECTED);
    plan_reads(plan, pass, PLAN_ORDER);
    plan_attaches(plan, pass, PLAN_IMAGE_AXIS_COLOR);
    plan_attaches(plan, pass, PLAN_IMAGE_AXIS_DEPTH);
}

/* Of 16 bytes, of a splat that is projected. */
static unsigned projected_vectors(const struct stp_plan *plan)
{
    switch ((enum axis_shape)plan->constant[PLAN_AXIS_SHAPE]) {
    case AXIS_VOXELS:
        break;
    case AXIS_ELLIPSOIDS:
        return STP_ELLIPSOID_DRAWN;
    case AXIS_DISCS:
        return plan->constant[PLAN_PHONG] == 2 ? STP_GAUSSIAN_CLIPPED : STP_GAUSSIAN;
    }
    return 2;
}

/* Lists and projected splats are fetched as texels, where there may be as many. */
static bool is_fetched(const struct stp_plan *plan)
{
    return plan->path == STP_PATH_COMPUTE &&
           (plan->limits.features & STP_FEATURE_TEXEL_BUFFERS) != 0 &&
           plan->axis_blocks.count <= plan->limits.max_texels &&
           plan->facts.splats * projected_vectors(plan) <= plan->limits.max_texels;
}

/* A pass over the blocks' lists. */
static struct plan_pass *block_pass(struct stp_plan *plan, enum plan_shader shader,
                                    const char *name)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, name);
    pass->shader = shader;
    pass->groups = (uint32_t)(plan_pixels(plan) / (STP_GROUP * STP_AXIS_ROWS)) + 1;
    plan_reads(plan, pass, PLAN_PROJECTED);
    plan_reads(plan, pass, PLAN_ORDER);
    plan_reads(plan, pass, PLAN_COUNTS);
    return pass;
}

static void block_walk(struct stp_plan *plan, unsigned index)
{
    char name[40];
    name_walk(plan, index, name, sizeof name);
    for (uint32_t part = 0; part < parts_of(plan); part++) {
        struct plan_pass *pass =
            block_pass(plan, PLAN_SHADER_AXIS_BLOCK_PART + is_fetched(plan), name);
        pass->layer = index;
        pass->part = part;
        plan_updates(plan, pass, PLAN_AXIS_SUMS);
    }
}

static void project(struct stp_plan *plan)
{
    uint64_t kernels = plan->facts.splats;
    uint8_t projected = plan_resource(plan, "projected", PLAN_PROJECTED, PLAN_TRANSIENT,
                                      kernels * projected_vectors(plan) * 16);
    plan->resource[projected].format = is_fetched(plan) ? PLAN_TEXELS_RGBA32UI : PLAN_BUFFER;
    if (plan->constant[PLAN_AXIS_SHAPE] == AXIS_DISCS) {
        plan_axis_surface_project(plan);
        return;
    }
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "project");
    pass->shader = PLAN_SHADER_AXIS_PROJECT;
    pass->groups = (uint32_t)((kernels + STP_GROUP - 1) / STP_GROUP);
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_MATERIALS);
    plan_writes(plan, pass, PLAN_PROJECTED);
}

static void write_picture(const struct stp_plan *plan, struct plan_pass *pass)
{
    plan_reads(plan, pass, PLAN_ENVIRONMENT);
    for (enum plan_slot slot = PLAN_OUT_COLOR; slot <= PLAN_OUT_DEPTH; slot++)
        plan_writes(plan, pass, slot);
}

static void merge(struct stp_plan *plan, enum plan_shader shader)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "merge");
    pass->shader = shader;
    plan_reads(plan, pass, PLAN_IMAGE_AXIS_COLOR);
    plan_reads(plan, pass, PLAN_IMAGE_AXIS_DEPTH);
    plan_reads(plan, pass, PLAN_AXIS_SUMS);
    write_picture(plan, pass);
}

static void raster(struct stp_plan *plan)
{
    plan_image(plan, "walk color", PLAN_IMAGE_AXIS_COLOR, PLAN_RGBA32F, plan->axis.walk_count);
    plan_image(plan, "walk depth", PLAN_IMAGE_AXIS_DEPTH, PLAN_RG32F, plan->axis.walk_count);
    project(plan);
    for (unsigned i = 0; i < plan->axis.walk_count; i++)
        draw_walk(plan, i);
    merge(plan, PLAN_SHADER_AXIS_MERGE);
}

static void compute_in_parts(struct stp_plan *plan)
{
    plan_resource(plan, "walk sums", PLAN_AXIS_SUMS, PLAN_TRANSIENT,
                  plan_pixels(plan) * plan->axis.walk_count * 32);
    project(plan);
    for (unsigned i = 0; i < plan->axis.walk_count; i++)
        block_walk(plan, i);
    merge(plan, PLAN_SHADER_AXIS_MERGE_SUMS);
}

/* A splat is fetched once for the eight threads of a block where they can pass it on. */
static void compute(struct stp_plan *plan)
{
    bool shuffled = (plan->limits.features & STP_FEATURE_SUBGROUP_SHUFFLE) != 0;
    project(plan);
    write_picture(plan, block_pass(plan,
                                   !is_fetched(plan) ? PLAN_SHADER_AXIS_BLOCK
                                   : shuffled        ? PLAN_SHADER_AXIS_BLOCK_SHUFFLED
                                                     : PLAN_SHADER_AXIS_BLOCK_FETCHED,
                                   "walks"));
}

void plan_axis_resources(struct stp_plan *plan)
{
    const struct axis_blocks *blocks = &plan->axis_blocks;
    size_t lists = plan->axis.walk_count * (size_t)blocks->across * blocks->down;
    bool discs = plan->constant[PLAN_AXIS_SHAPE] == AXIS_DISCS;
    bool ellipsoids = plan->constant[PLAN_AXIS_SHAPE] == AXIS_ELLIPSOIDS;
    if (!plan->axis.count)
        return;
    if (discs)
        plan_surface_resources(plan);
    else
        plan_resource(plan, "kernels", PLAN_SPLATS, PLAN_SCENE,
                      plan->facts.splats * (ellipsoids ? STP_ELLIPSOID : 2) * 16);
    if (plan->path == STP_PATH_COMPUTE)
        plan_resource(plan, "block starts", PLAN_COUNTS, PLAN_SCENE, (lists + 1) * 4);
    bool by_compute = plan->path == STP_PATH_COMPUTE;
    uint8_t order = plan_resource(plan, by_compute ? "block splats" : "lists", PLAN_ORDER,
                                  PLAN_SCENE, 4 * (by_compute ? blocks->count : plan->axis.count));
    plan->resource[order].format = is_fetched(plan) ? PLAN_TEXELS_R32UI : PLAN_BUFFER;
}

void plan_axis(struct stp_plan *plan)
{
    if (!plan->axis.walk_count)
        merge(plan, PLAN_SHADER_AXIS_EMPTY);
    else if (plan->path == STP_PATH_RASTER)
        raster(plan);
    else if (in_parts(plan))
        compute_in_parts(plan);
    else
        compute(plan);
}

void plan_axis_forget(struct stp_plan *plan)
{
    struct axis_lists *lists = &plan->axis;
    lists->order = NULL;
    lists->mask = lists->open = NULL;
    lists->span = NULL;
    for (int a = 0; a < 3; a++)
        lists->sheets[a] = (struct axis_sheets){ 0 };
    plan->axis_blocks.first = plan->axis_blocks.entry = plan->axis_blocks.cursor = NULL;
    plan->axis_blocks.span = NULL;
}
