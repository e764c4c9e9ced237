/* Regions: the whole picture when its transients fit, else tiles whose pixels are the same bits. */
#include "plan/plan.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"

/* A workgroup of STP_LARGE_GROUP threads may have to walk a whole tile, and lavapipe stops an
 * invocation after 65535 turns: 2^22 pixels are half of that. */
#define MOST_PIXELS ((uint64_t)1 << 22)

uint64_t plan_bytes(const struct stp_plan *plan, enum plan_lifetime lifetime)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < plan->resource_count; i++)
        if (plan->resource[i].lifetime == lifetime)
            bytes += plan->resource[i].bytes;
    return bytes;
}

/* Axis lists are cut into blocks of the picture, which tiles must not cut. */
static uint32_t margin(const struct stp_plan *plan)
{
    uint32_t reach = plan->camera.height / 512, block = STP_BLOCK;
    if (!plan->facts.eye_dome)
        return 0;
    reach = reach > 1 ? reach : 1;
    return plan->method == STP_METHOD_AXIS ? (reach + block - 1) / block * block : reach;
}

static void outputs(struct stp_plan *plan)
{
    uint64_t pixels = (uint64_t)plan->tile_width * plan->tile_height;
    plan_resource(plan, "color", PLAN_OUT_COLOR, PLAN_OUTPUT, pixels * 16);
    plan_resource(plan, "normal", PLAN_OUT_NORMAL, PLAN_OUTPUT, pixels * 12);
    plan_resource(plan, "depth", PLAN_OUT_DEPTH, PLAN_OUTPUT, pixels * 4);
    if (plan->constant[PLAN_AOVS] & PLAN_AOVS_ALBEDO)
        plan_resource(plan, "albedo", PLAN_OUT_ALBEDO, PLAN_OUTPUT, pixels * 16);
    if (plan->constant[PLAN_AOVS] & PLAN_AOVS_ID)
        plan_resource(plan, "id", PLAN_OUT_ID, PLAN_OUTPUT, pixels * 4 * plan_id_words(plan));
}

/* An only object's stands in the frame block (common.glsl). */
void plan_materials(struct stp_plan *plan)
{
    if (plan->constant[PLAN_HAS_OBJECTS])
        plan_resource(plan, "materials", PLAN_MATERIALS, PLAN_SCENE,
                      plan->facts.objects * sizeof(struct stp_material_gpu));
}

void plan_surface_resources(struct stp_plan *plan)
{
    uint64_t n = plan_splats(plan) + plan_ghosts(plan);
    plan_resource(plan, "splats", PLAN_SPLATS, PLAN_SCENE, n * 32);
    if (plan->facts.has_color)
        plan_resource(plan, "colors", PLAN_COLORS, PLAN_SCENE, n * 12);
    if (plan->constant[PLAN_OPACITY] == 2)
        plan_resource(plan, "opacities", PLAN_OPACITIES, PLAN_SCENE, n * 4);
    plan_phong_resources(plan);
    plan_materials(plan);
}

/* Blocks that nothing touches are never resolved: they keep what these fills leave. */
static void clear_outputs(struct stp_plan *plan)
{
    plan_fill(plan, PLAN_OUT_COLOR, 0, "clear color");
    plan_fill(plan, PLAN_OUT_NORMAL, 0, "clear normal");
    plan_fill(plan, PLAN_OUT_DEPTH, 0x7f800000u, "clear depth");
    plan_fill(plan, PLAN_OUT_ALBEDO, 0, "clear albedo");
    plan_fill(plan, PLAN_OUT_ID, STP_NO_ID, "clear id");
}

static void work_resources(struct stp_plan *plan)
{
    bool compute = plan->path == STP_PATH_COMPUTE;
    uint64_t blocks = plan_pixels(plan) / STP_GROUP, words = plan->constant[PLAN_BINS] ? 4 : 2;
    words += compute && plan->transparency == STP_TRANSPARENCY_EXACT; /* and BINS are two-pass's */
    plan_resource(plan, "work", PLAN_WORK, PLAN_TRANSIENT, (STP_WORK_FLAGS + words * blocks) * 4);
    if (!compute)
        return;
    uint64_t lists = plan->method == STP_METHOD_EXACT ? 2 : 1; /* large, and to repair */
    plan_resource(plan, "large", PLAN_LARGE, PLAN_TRANSIENT, plan_splats(plan) * 4 * lists);
    plan_bin_resources(plan);
}

static void reset_arguments(struct stp_plan *plan)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_ARGUMENTS, "reset arguments");
    plan_writes(plan, pass, PLAN_WORK);
}

static void eye_dome(struct stp_plan *plan)
{
    if (!plan->facts.eye_dome)
        return;
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "eye dome");
    pass->shader = PLAN_SHADER_EYE_DOME;
    plan_reads(plan, pass, PLAN_OUT_DEPTH);
    plan_updates(plan, pass, PLAN_OUT_COLOR);
}

/* Behind all else, and also where no block was touched. */
static void background(struct stp_plan *plan)
{
    bool medium = plan->method == STP_METHOD_AXIS && plan_of_medium(&plan->facts);
    if (!plan->constant[PLAN_BACKGROUND] || medium) /* whose last pass has it already */
        return;
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "background");
    pass->shader = PLAN_SHADER_BACKGROUND;
    plan_reads(plan, pass, PLAN_ENVIRONMENT);
    plan_reads(plan, pass, PLAN_OUT_DEPTH);
    plan_updates(plan, pass, PLAN_OUT_COLOR);
}

static void steps(struct stp_plan *plan, uint32_t width, uint32_t height)
{
    plan->tile_width = width;
    plan->tile_height = height;
    plan->resource_count = plan->pass_count = plan->loop_first = plan->again_end = 0;
    bool pyramid = plan->method == STP_METHOD_PYRAMID, axis = plan->method == STP_METHOD_AXIS;
    if (pyramid)
        plan_pyramid_resources(plan);
    else if (axis)
        plan_axis_resources(plan);
    else
        plan_surface_resources(plan);
    plan_environment_resources(plan);
    if (plan_is_root(plan))
        outputs(plan);
    bool compute = plan->path == STP_PATH_COMPUTE && !axis;
    if (!axis && !pyramid)
        work_resources(plan);
    bool peel = plan->transparency == STP_TRANSPARENCY_PEEL;
    if (!axis || plan->transparency != STP_TRANSPARENCY_AUTO)
        clear_outputs(plan);
    plan_limits(plan);
    if (peel)
        plan_peel_begin(plan);
    plan_light_cube_steps(plan);
    plan->repeat_first = plan->pass_count;
    if (compute)
        reset_arguments(plan);
    if (plan_covers(plan))
        plan_transparent(plan);
    else if (plan->method == STP_METHOD_DEFERRED)
        plan_deferred(plan);
    else if (plan->method == STP_METHOD_AXIS)
        plan_axis(plan);
    else if (plan->method == STP_METHOD_EXACT)
        plan_exact(plan);
    else if (pyramid)
        plan_pyramid(plan);
    else
        plan_twopass(plan);
    plan->repeat_end = plan->pass_count;
    if (!plan_is_root(plan))
        return;
    eye_dome(plan);
    background(plan);
}

static uint64_t largest(const struct stp_plan *plan)
{
    uint64_t most = 0;
    for (uint32_t i = 0; i < plan->resource_count; i++)
        if (plan->resource[i].bytes > most)
            most = plan->resource[i].bytes;
    return most;
}

/* A pyramid is wider than the tile it serves. */
static bool images_fit(const struct stp_plan *plan)
{
    uint32_t most = plan->limits.max_image_size;
    bool fit = plan->tile_width <= most && plan->tile_height <= most;
    for (uint32_t i = 0; i < plan->resource_count; i++)
        fit = fit && plan->resource[i].width <= most && plan->resource[i].height <= most;
    return fit;
}

static bool texels_fit(const struct stp_plan *plan)
{
    bool fit = true;
    for (uint32_t i = 0; i < plan->resource_count; i++)
        fit = fit && (plan->resource[i].format != PLAN_TEXELS_RG32UI ||
                      plan->resource[i].bytes / 8 <= plan->limits.max_texels);
    return fit;
}

static bool fits(const struct stp_plan *plan, uint64_t limit)
{
    uint64_t used = plan_bytes(plan, PLAN_TRANSIENT) + plan_bytes(plan, PLAN_OUTPUT);
    return used <= limit && largest(plan) <= plan->limits.max_allocation &&
           (uint64_t)plan->tile_width * plan->tile_height <= MOST_PIXELS && images_fit(plan) &&
           texels_fit(plan);
}

static uint32_t cut(uint32_t length, uint32_t parts, uint32_t border)
{
    uint32_t part = (length + parts - 1) / parts;
    part = (part + STP_BLOCK - 1) / STP_BLOCK * STP_BLOCK + 2 * border;
    return part < length ? part : length;
}

/* How far one tile is from the next: tiles overlap by what their passes look around. */
static uint32_t step_of(uint32_t length, uint32_t tile, uint32_t border)
{
    return tile >= length ? length : tile - 2 * border;
}

static void place(const struct stp_plan *plan, uint32_t left, uint32_t top, uint32_t right,
                  uint32_t bottom, struct plan_tile *t)
{
    uint32_t b = margin(plan), w = plan->camera.width, h = plan->camera.height;
    t->x = left > b ? left - b : 0;
    t->y = top > b ? top - b : 0;
    t->width = (right + b < w ? right + b : w) - t->x;
    t->height = (bottom + b < h ? bottom + b : h) - t->y;
    t->keep[0] = left;
    t->keep[1] = top;
    t->keep[2] = right;
    t->keep[3] = bottom;
}

void plan_place_tiles(struct stp_plan *plan)
{
    uint32_t b = margin(plan), w = plan->camera.width, h = plan->camera.height;
    uint32_t step_x = step_of(w, plan->tile_width, b), step_y = step_of(h, plan->tile_height, b);
    uint32_t columns = (w + step_x - 1) / step_x, rows = (h + step_y - 1) / step_y;
    plan->tile_count = columns * rows;
    for (uint32_t i = 0; i < plan->tile_count; i++) {
        uint32_t left = i % columns * step_x, top = i / columns * step_y;
        place(plan, left, top, left + step_x < w ? left + step_x : w,
              top + step_y < h ? top + step_y : h, &plan->tile[i]);
    }
}

static enum stp_result lay_out(const struct stp_env *env, struct stp_plan *plan)
{
    uint32_t b = margin(plan), w = plan->camera.width, h = plan->camera.height;
    uint32_t step_x = step_of(w, plan->tile_width, b), step_y = step_of(h, plan->tile_height, b);
    size_t count = (size_t)((w + step_x - 1) / step_x) * ((h + step_y - 1) / step_y);
    plan->tile = mem_zalloc(count, sizeof *plan->tile);
    if (!plan->tile)
        return log_no_memory(env, count * sizeof *plan->tile, "tiles");
    plan_place_tiles(plan);
    return STP_OK;
}

/* What grows with the splats and not with the tile: no tile is small enough for too much of it. */
static bool scene_too_large(const struct stp_plan *plan)
{
    uint64_t bytes = 0, most = 0;
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        if (r->lifetime != PLAN_SCENE && r->slot != PLAN_LARGE)
            continue;
        bytes += r->bytes;
        most = r->bytes > most ? r->bytes : most;
    }
    return bytes > plan->limits.heap_bytes / 8 * 7 || most > plan->limits.max_allocation;
}

/* A scene that the device cannot hold is still rendered where no method was asked for. */
static enum stp_result leave_device(const struct stp_env *env, struct stp_plan *plan)
{
    unsigned long long scene = plan_bytes(plan, PLAN_SCENE), heap = plan->limits.heap_bytes;
    unsigned long long once = plan->limits.max_allocation;
    if (plan->params.method != STP_METHOD_AUTO)
        return log_error(
            env, STP_ERROR_DEVICE_MEMORY,
            "the device has %llu bytes, at most %llu in one buffer, and the scene takes "
            "%llu; --method reference renders it on the CPU",
            heap, once, scene);
    plan->resource_count = plan->pass_count = 0;
    plan_leave_device(plan);
    return STP_OK;
}

/* Bytes that transients and outputs may take beside the scene. */
static uint64_t room(const struct stp_plan *plan)
{
    uint64_t scene = plan_bytes(plan, PLAN_SCENE), heap = plan->limits.heap_bytes / 8 * 7;
    uint64_t left = heap > scene ? heap - scene : 0;
    return plan->params.memory_limit && plan->params.memory_limit < left ? plan->params.memory_limit
                                                                         : left;
}

static enum stp_result no_tile_fits(const struct stp_env *env, const struct stp_plan *plan,
                                    uint32_t least)
{
    unsigned long long most = largest(plan),
                       tile = plan_bytes(plan, PLAN_TRANSIENT) + plan_bytes(plan, PLAN_OUTPUT);
    if (most > plan->limits.max_allocation)
        return log_error(env, STP_ERROR_DEVICE_MEMORY,
                         "one buffer takes %llu bytes; the device allows %llu", most,
                         (unsigned long long)plan->limits.max_allocation);
    if (!images_fit(plan))
        return log_error(env, STP_ERROR_DEVICE_MEMORY,
                         "an image of this view is larger than the device's %u pixels a side",
                         plan->limits.max_image_size);
    return log_error(env, STP_ERROR_DEVICE_MEMORY,
                     "the device has %llu bytes; the scene takes %llu, and not even a tile of %u "
                     "pixels fits beside it, which takes %llu",
                     (unsigned long long)plan->limits.heap_bytes,
                     (unsigned long long)plan_bytes(plan, PLAN_SCENE), least, tile);
}

static enum stp_result cut_picture(const struct stp_env *env, struct stp_plan *plan)
{
    uint32_t w = plan->camera.width, h = plan->camera.height, columns = 1, rows = 1;
    bool chunked = plan->method != STP_METHOD_PYRAMID || plan_pyramid_chunks(plan);
    steps(plan, w, h);
    if (!chunked || scene_too_large(plan))
        return leave_device(env, plan);
    while (!fits(plan, room(plan))) {
        uint32_t least = STP_BLOCK + 2 * margin(plan);
        if (plan->tile_width <= least && plan->tile_height <= least)
            return no_tile_fits(env, plan, least);
        if (plan->tile_width >= plan->tile_height)
            columns *= 2;
        else
            rows *= 2;
        steps(plan, cut(w, columns, columns > 1 ? margin(plan) : 0),
              cut(h, rows, rows > 1 ? margin(plan) : 0));
    }
    return STP_OK;
}

enum stp_result plan_tiles(const struct stp_env *env, struct stp_plan *plan)
{
    struct plan_share own = plan->share;
    /* All processes must cut alike: as the root would that had the largest share. */
    if (own.count) {
        plan->share.rank = 0;
        plan->share.splats = (plan->facts.splats + own.count - 1) / own.count;
    }
    enum stp_result result = cut_picture(env, plan);
    plan->share = own;
    if (result != STP_OK || plan->method == STP_METHOD_REFERENCE)
        return result;
    if (own.count)
        steps(plan, plan->tile_width, plan->tile_height);
    return lay_out(env, plan);
}
