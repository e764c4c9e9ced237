/* What a pyramid stands on in a view: levels, the grid of the picture and of its tiles, how far
 * discs reach. */
#include "plan/plan.h"

#include <math.h>

#include "base/vec.h"

#define LEAST_LEVELS 4 /* blocks of the picture are texels of the coarsest of these */
#define NEAR_REACH   1.5
#define MOST_CROWD   0.6 /* glsl/lib/rim.glsl has these two */
#define MOST_GUARD   64  /* pixels beyond the picture's edges, where discs that reach in may lie */

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

/* As far as glsl/lib/rim.glsl looks from a point for its disc: that one reaches twice as far at
 * most where its rim is half as far from the eye as its centre; the shader knows its radius to
 * 2^-11. */
static double rim_reach(double radius)
{
    return 2 * (1 + 0x1p-10) * radius + MOST_CROWD + 0.5;
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

bool plan_has_clusters(const struct stp_plan *plan)
{
    return plan->constant[PLAN_CULL_CLUSTERS] || plan->rim_far;
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
    /* A mean's disc reaches beyond its points' by less than their diameter. */
    f->rim_level = (uint32_t)fmax(ceil(log2(fmax(2 * o.radius, 1))), 1);
    plan->rim_far = o.radius + MOST_CROWD > NEAR_REACH;
    plan->constant[PLAN_RIM_FAR] = plan->rim_far;
    plan->rim_large = pow(2 * rim_reach(o.radius) + 1, 2) > STP_LARGE_AREA;
    if (plan->levels > 6) /* discs of more than a block and a half */
        f->block_reach = plan->levels > 8 ? 4 : 2;
    plan->constant[PLAN_CULL_CLUSTERS] = plan->constant[PLAN_CULL_BACK] || leaves_picture(plan, &o);
    plan->constant[PLAN_LANES] =
        plan->limits.processor == STP_PROCESSOR_CPU ? STP_BLOCK : STP_GROUP;
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
