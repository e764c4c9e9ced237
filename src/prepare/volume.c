#include "prepare/volume.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "base/vec.h"

#define LEAST_GRADIENT 1e-6 /* of the range of the values, over the finest spacing */
#define ALPHA_ONE      (1 - 1.0 / 16777216) /* opacity 1 has a finite depth */

/* Slices along z are counted and filled apart; a voxel's place is that of its index. */
struct classify {
    const struct grid *grid;
    const struct transfer_function *transfer;
    const double *clip_box; /* NULL: none */
    struct kernels *kernels;
    size_t *first, *clipped; /* of each slice */
    double finest;
    bool fill;
};

static double value_at(const struct grid *grid, const int64_t at[3])
{
    for (int axis = 0; axis < 3; axis++)
        if (at[axis] < 0 || at[axis] >= grid->dims[axis])
            return NAN;
    size_t row = (size_t)at[2] * grid->dims[1] + (size_t)at[1];
    return (double)grid->value[row * grid->dims[0] + (size_t)at[0]];
}

/* Central differences, one-sided where a neighbour is missing. */
static struct vec3 gradient(const struct grid *grid, const int64_t at[3], double value)
{
    double g[3];
    for (int axis = 0; axis < 3; axis++) {
        int64_t low[3] = { at[0], at[1], at[2] }, high[3] = { at[0], at[1], at[2] };
        low[axis]--;
        high[axis]++;
        double a = value_at(grid, low), b = value_at(grid, high);
        double span = (isfinite(a) ? 1 : 0) + (isfinite(b) ? 1 : 0);
        a = isfinite(a) ? a : value;
        b = isfinite(b) ? b : value;
        g[axis] = span > 0 ? (b - a) / (span * grid->spacing[axis]) : 0;
    }
    return v3_load(g);
}

static void set_normal(const struct classify *c, const int64_t at[3], double value, float normal[3])
{
    struct vec3 g = gradient(c->grid, at, value);
    double range = c->grid->high - c->grid->low, length = v3_length(g);
    bool flat = !(length * c->finest > LEAST_GRADIENT * range);
    normal[0] = flat ? 0 : (float)(-g.x / length);
    normal[1] = flat ? 0 : (float)(-g.y / length);
    normal[2] = flat ? 0 : (float)(-g.z / length);
}

static bool is_clipped(const struct classify *c, const int64_t at[3])
{
    for (int axis = 0; c->clip_box && axis < 3; axis++) {
        double p = c->grid->origin[axis] + (double)at[axis] * c->grid->spacing[axis];
        if (p < c->clip_box[axis] || p > c->clip_box[axis + 3])
            return true;
    }
    return false;
}

static void store(const struct classify *c, size_t to, const int64_t at[3], double value,
                  const struct transfer_point *looks)
{
    const struct grid *grid = c->grid;
    struct kernels *k = c->kernels;
    double alpha = fmin((double)looks->opacity, ALPHA_ONE);
    k->voxel[to] =
        (uint32_t)(((size_t)at[2] * grid->dims[1] + (size_t)at[1]) * grid->dims[0] + (size_t)at[0]);
    memcpy(k->color[to], looks->color, sizeof looks->color);
    k->tau[to] = (float)(-log1p(-alpha) / c->finest);
    if (k->normal)
        set_normal(c, at, value, k->normal[to]);
}

static void classify_slice(const struct classify *c, size_t slice)
{
    const struct grid *grid = c->grid;
    const struct transfer_function *f = c->transfer;
    double low = f->of_range ? grid->low : 0;
    double scale = f->of_range && grid->high > grid->low ? 1 / (grid->high - grid->low) : 1;
    const float *value = grid->value + slice * grid->dims[0] * grid->dims[1];
    size_t kept = c->fill ? c->first[slice] : 0, clipped = 0;
    for (size_t i = 0; i < (size_t)grid->dims[0] * grid->dims[1]; i++) {
        double v = (double)value[i];
        struct transfer_point looks = { 0 };
        if (isfinite(v))
            looks = transfer_at(f, (v - low) * scale);
        if (!(looks.opacity > 0))
            continue;
        int64_t at[3] = { (int64_t)(i % grid->dims[0]), (int64_t)(i / grid->dims[0]),
                          (int64_t)slice };
        if (is_clipped(c, at)) {
            clipped++;
            continue;
        }
        if (c->fill)
            store(c, kept, at, v, &looks);
        kept++;
    }
    if (!c->fill) {
        c->first[slice] = kept;
        c->clipped[slice] = clipped;
    }
}

static void classify_slices(void *context, size_t begin, size_t end, unsigned)
{
    for (size_t slice = begin; slice < end; slice++)
        classify_slice(context, slice);
}

static bool allocate(struct kernels *k, size_t count, bool shaded)
{
    k->count = count;
    k->voxel = mem_alloc(count, sizeof *k->voxel);
    k->color = mem_alloc(count, sizeof *k->color);
    k->tau = mem_alloc(count, sizeof *k->tau);
    k->normal = shaded ? mem_alloc(count, sizeof *k->normal) : NULL;
    return k->voxel && k->color && k->tau && (k->normal || !shaded);
}

/* Counts, then places, then fills. */
static enum stp_result classify(const struct stp_env *env, const struct volume *volume,
                                struct classify *c, size_t *clipped)
{
    size_t slices = c->grid->dims[2], total = 0;
    c->first = mem_alloc(2 * slices, sizeof *c->first);
    if (!c->first)
        return log_no_memory(env, 2 * slices * sizeof *c->first, "slices");
    c->clipped = c->first + slices;
    parallel_for(env, slices, 1, classify_slices, c);
    *clipped = 0;
    for (size_t i = 0; i < slices; i++) {
        size_t count = c->first[i];
        c->first[i] = total;
        total += count;
        *clipped += c->clipped[i];
    }
    enum stp_result result = STP_OK;
    if (total == 0)
        result = log_error(env, STP_ERROR_NO_POINTS,
                           "no voxels to draw: the transfer function \"%s\" gives %zu voxels from "
                           "%g to %g no opacity%s",
                           c->transfer->name, grid_count(c->grid), c->grid->low, c->grid->high,
                           *clipped ? ", or the clip box leaves them out" : "");
    else if (!allocate(c->kernels, total, !volume->unshaded))
        result = log_no_memory(env, total * 32, "kernels");
    c->fill = true;
    if (result == STP_OK)
        parallel_for(env, slices, 1, classify_slices, c);
    mem_free(c->first);
    return result;
}

/* The voxels' bounds, and the most of the opacities and colours. */
static void measure(struct stp_scene *scene, struct volume *volume)
{
    const struct kernels *k = &volume->kernels;
    const struct grid *grid = &volume->grid;
    struct stp_facts *f = &scene->facts;
    double tau = 0, color = 0;
    uint32_t at[3];
    for (int axis = 0; axis < 3; axis++) {
        volume->low[axis] = UINT32_MAX;
        volume->high[axis] = 0;
    }
    for (size_t i = 0; i < k->count; i++) {
        voxel_place(grid, k->voxel[i], at);
        for (int axis = 0; axis < 3; axis++) {
            volume->low[axis] = at[axis] < volume->low[axis] ? at[axis] : volume->low[axis];
            volume->high[axis] = at[axis] > volume->high[axis] ? at[axis] : volume->high[axis];
            color = fmax(color, (double)k->color[i][axis]);
        }
        tau = fmax(tau, (double)k->tau[i]);
    }
    f->color_max = (float)color;
    f->volume.opacity_max = volume->opacity_max = -expm1(-tau * volume_finest(grid));
}

static void set_places(struct stp_scene *scene, const struct volume *volume)
{
    const struct grid *grid = &volume->grid;
    struct stp_facts *f = &scene->facts;
    double largest = 0, extent = 0;
    f->radius_min = INFINITY;
    f->radius_max = 0;
    for (int axis = 0; axis < 3; axis++) {
        double s = grid->spacing[axis], reach = KERNEL_REACH * KERNEL_SIGMA * s;
        f->bounds[axis] = grid->origin[axis] + volume->low[axis] * s;
        f->bounds[axis + 3] = grid->origin[axis] + volume->high[axis] * s;
        scene->core[axis] = f->bounds[axis] - reach;
        scene->core[axis + 3] = f->bounds[axis + 3] + reach;
        f->radius_min = fminf(f->radius_min, (float)reach);
        f->radius_max = fmaxf(f->radius_max, (float)reach);
        largest = fmax(largest, fmax(fabs(scene->core[axis]), fabs(scene->core[axis + 3])));
        extent = fmax(extent, scene->core[axis + 3] - scene->core[axis]);
    }
    f->radius_median = f->radius_min;
    for (int axis = 0; axis < 3; axis++)
        f->origin[axis] = scene->splats.origin[axis] =
            largest <= 4 * extent ? 0 : grid->origin[axis];
}

static void set_facts(struct stp_scene *scene, struct volume *volume, size_t clipped)
{
    struct stp_facts *f = &scene->facts;
    measure(scene, volume);
    set_places(scene, volume);
    f->splats = volume->kernels.count;
    f->not_finite = volume->grid.not_finite;
    f->clipped = clipped;
    f->normals = volume->unshaded ? STP_NORMALS_NONE : STP_NORMALS_ESTIMATED;
    f->has_color = f->two_sided = true;
    f->objects = 1;
    memcpy(f->volume.transfer_function, volume->transfer.name, sizeof volume->transfer.name);
    if (scene->objects[0].epsilon == 0)
        scene->objects[0].epsilon = volume_finest(&volume->grid);
}

enum stp_result prepare_volume(const struct stp_env *env, struct stp_scene *scene,
                               const struct stp_prepare_params *params)
{
    struct volume *volume = scene->volume;
    struct transfer_function transfer = volume->transfer;
    struct kernels made = { 0 };
    size_t clipped = 0;
    if (params && params->clip_box) {
        volume->clipped = true;
        memcpy(volume->clip_box, params->clip_box, sizeof volume->clip_box);
    }
    if (volume->automatic) {
        enum stp_result result = transfer_automatic(env, &volume->grid, &transfer);
        if (result != STP_OK)
            return result;
    }
    struct classify c = { .grid = &volume->grid,
                          .transfer = &transfer,
                          .clip_box = volume->clipped ? volume->clip_box : NULL,
                          .kernels = &made,
                          .finest = volume_finest(&volume->grid) };
    enum stp_result result = classify(env, volume, &c, &clipped);
    if (result != STP_OK) {
        kernels_release(&made);
        return result;
    }
    kernels_release(&volume->kernels);
    volume->kernels = made;
    volume->transfer = transfer;
    set_facts(scene, volume, clipped);
    scene->prepared = true;
    scene->version.content = scene_change(scene);
    log_progress(env, "prepare", 1);
    return STP_OK;
}

enum stp_result stp_scene_set_transfer_function(const struct stp_env *env, struct stp_scene *scene,
                                                const struct stp_volume_params *params)
{
    if (!scene->volume || volume_is_range(scene->volume))
        return log_error(env, STP_ERROR_ARGUMENT, "the scene has no volume to classify");
    struct volume before = *scene->volume;
    enum stp_result result = volume_set_transfer(env, scene->volume, params);
    if (result == STP_OK && scene->prepared)
        result = prepare_volume(env, scene, NULL);
    if (result != STP_OK) {
        scene->volume->transfer = before.transfer;
        scene->volume->automatic = before.automatic;
        scene->volume->unshaded = before.unshaded;
    }
    return result;
}
