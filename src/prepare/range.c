/* Pixels of range images to Gaussian ellipsoids. */
#include "prepare/range.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/radix.h"
#include "scene/range.h"

/* Rows of all frames, one after the other, are counted and filled apart. */
struct filling {
    const struct range *range;
    const double *clip_box; /* NULL: none */
    size_t *first;          /* of each row: counts, then where its kernels begin */
    size_t *first_pixel;    /* of each frame */
    unsigned *frame_row;    /* of each frame: its first row; one more at the end */
    size_t clipped;
    struct kernels *kernels; /* NULL: only counted */
    float *deviation;
};

static bool is_clipped(const double *box, struct vec3 p)
{
    const double at[3] = { p.x, p.y, p.z };
    for (int a = 0; box && a < 3; a++)
        if (at[a] < box[a] || at[a] > box[a + 3])
            return true;
    return false;
}

static void set_axis(struct vec3 v, double scale, float axis[3])
{
    axis[0] = (float)(v.x * scale);
    axis[1] = (float)(v.y * scale);
    axis[2] = (float)(v.z * scale);
}

/* Seen from its frame, a lattice of them has the surface's optical depth: there the line integral
 * at the centre is tau |ray| sqrt(2 pi) deviation. */
static float own_tau(const struct range_pixel *p)
{
    double kept = -expm1(-0.5 * KERNEL_REACH * KERNEL_REACH);
    double lattice = 2 * M_PI * RANGE_SIGMA * RANGE_SIGMA * kept;
    return (float)(RANGE_DEPTH_OF_SURFACE / lattice / (v3_length(p->along) * sqrt(2 * M_PI)));
}

static void store(const struct filling *f, size_t to, unsigned frame, size_t index,
                  const struct range_pixel *p)
{
    struct kernels *k = f->kernels;
    v3_store(p->place, k->place[to]);
    set_axis(p->across, RANGE_SIGMA, k->axes[to][0]);
    set_axis(p->down, RANGE_SIGMA, k->axes[to][1]);
    set_axis(p->along, 1, k->axes[to][2]);
    k->voxel[to] = (uint32_t)(f->first_pixel[frame] + index);
    k->tau[to] = own_tau(p);
    memcpy(k->color[to], f->range->frame[frame].color[index], sizeof k->color[to]);
    f->deviation[to] = (float)p->deviation;
}

static void visit_row(const struct filling *f, size_t row)
{
    unsigned frame = 0;
    while (f->frame_row[frame + 1] <= row)
        frame++;
    const struct range_frame *image = &f->range->frame[frame];
    uint32_t v = (uint32_t)(row - f->frame_row[frame]);
    size_t kept = f->kernels ? f->first[row] : 0;
    for (uint32_t u = 0; u < image->width; u++) {
        struct range_pixel pixel;
        if (!range_pixel(f->range, frame, u, v, &pixel) || is_clipped(f->clip_box, pixel.place))
            continue;
        if (f->kernels)
            store(f, kept, frame, (size_t)v * image->width + u, &pixel);
        kept++;
    }
    if (!f->kernels)
        f->first[row] = kept;
}

static void visit_rows(void *context, size_t begin, size_t end, unsigned)
{
    for (size_t row = begin; row < end; row++)
        visit_row(context, row);
}

static bool allocate(struct kernels *k, size_t count)
{
    k->count = count;
    k->voxel = mem_alloc(count, sizeof *k->voxel);
    k->color = mem_alloc(count, sizeof *k->color);
    k->tau = mem_alloc(count, sizeof *k->tau);
    k->place = mem_alloc(count, sizeof *k->place);
    k->axes = mem_alloc(count, sizeof *k->axes);
    return k->voxel && k->color && k->tau && k->place && k->axes;
}

static size_t readings(const struct range *range, size_t *pixels, size_t *not_finite)
{
    size_t count = 0;
    *pixels = *not_finite = 0;
    for (unsigned i = 0; i < range->count; i++) {
        const struct range_frame *f = &range->frame[i];
        size_t size = (size_t)f->width * f->height;
        for (size_t k = 0; k < size; k++)
            count += f->depth[k] > 0;
        *pixels += size;
        *not_finite += f->not_finite;
    }
    return count;
}

static enum stp_result no_readings(const struct stp_env *env, const struct range *range)
{
    size_t pixels, bad, count = readings(range, &pixels, &bad);
    return log_error(env, STP_ERROR_NO_POINTS,
                     "no points to draw: %zu pixels of range images, %zu without a reading, %zu of "
                     "them not finite, %zu outside the clip box",
                     pixels, pixels - count, bad, count);
}

static enum stp_result fill(const struct stp_env *env, struct filling *f, struct kernels *made)
{
    size_t rows = f->frame_row[f->range->count], total = 0;
    parallel_for(env, rows, 16, visit_rows, f);
    for (size_t i = 0; i < rows; i++) {
        size_t count = f->first[i];
        f->first[i] = total;
        total += count;
    }
    if (total == 0)
        return no_readings(env, f->range);
    f->deviation = mem_alloc(total, sizeof *f->deviation);
    if (!f->deviation || !allocate(made, total))
        return log_no_memory(env, total * 100, "ellipsoids");
    f->kernels = made;
    parallel_for(env, rows, 16, visit_rows, f);
    return range_find_sources(env, f->range, f->deviation, made);
}

static enum stp_result make_kernels(const struct stp_env *env, const struct range *range,
                                    const double *clip_box, struct kernels *made, float **deviation)
{
    struct filling f = { .range = range, .clip_box = clip_box };
    size_t rows = 0, pixels = 0;
    f.first_pixel = mem_alloc(range->count, sizeof *f.first_pixel);
    f.frame_row = mem_alloc((size_t)range->count + 1, sizeof *f.frame_row);
    for (unsigned i = 0; f.first_pixel && f.frame_row && i < range->count; i++) {
        f.first_pixel[i] = pixels;
        f.frame_row[i] = (unsigned)rows;
        rows += range->frame[i].height;
        pixels += (size_t)range->frame[i].width * range->frame[i].height;
        f.frame_row[i + 1] = (unsigned)rows;
    }
    f.first = mem_alloc(rows, sizeof *f.first);
    enum stp_result result = STP_OK;
    if (!f.first || !f.first_pixel || !f.frame_row)
        result = log_no_memory(env, rows * sizeof *f.first, "rows of range images");
    else if (pixels > UINT32_MAX / 3)
        result = log_error(env, STP_ERROR_ARGUMENT, "%zu pixels of range images: at most %u",
                           pixels, UINT32_MAX / 3);
    else
        result = fill(env, &f, made);
    mem_free(f.first);
    mem_free(f.first_pixel);
    mem_free(f.frame_row);
    *deviation = f.deviation;
    return result;
}

static enum stp_result median(const struct stp_env *env, const float *value, size_t count,
                              double *out)
{
    uint64_t *key = mem_alloc(count, sizeof *key);
    uint32_t *at = mem_alloc(count, sizeof *at);
    enum stp_result result = STP_OK;
    for (size_t i = 0; key && at && i < count; i++) {
        uint32_t bits; /* positive floats are in the order of their bits */
        memcpy(&bits, &value[i], sizeof bits);
        key[i] = bits;
        at[i] = (uint32_t)i;
    }
    result =
        key && at ? radix_sort(env, count, key, at) : log_no_memory(env, count * 12, "deviations");
    if (result == STP_OK)
        *out = (double)value[at[count / 2]];
    mem_free(key);
    mem_free(at);
    return result;
}

/* Bounds of the centres; positions on the device are relative to the middle of what is far off. */
static void set_places(struct stp_scene *scene, const struct kernels *k)
{
    struct stp_facts *f = &scene->facts;
    double largest = 0, extent = 0;
    for (int a = 0; a < 3; a++) {
        f->bounds[a] = INFINITY;
        f->bounds[a + 3] = -INFINITY;
        for (size_t i = 0; i < k->count; i++) {
            f->bounds[a] = fmin(f->bounds[a], k->place[i][a]);
            f->bounds[a + 3] = fmax(f->bounds[a + 3], k->place[i][a]);
        }
        largest = fmax(largest, fmax(fabs(f->bounds[a]), fabs(f->bounds[a + 3])));
        extent = fmax(extent, f->bounds[a + 3] - f->bounds[a]);
    }
    memcpy(scene->core, f->bounds, sizeof f->bounds);
    for (int a = 0; a < 3; a++)
        f->origin[a] = scene->splats.origin[a] = largest <= 4 * extent ? 0 : f->bounds[a];
}

static void set_facts(struct stp_scene *scene, const struct kernels *k, double deviation)
{
    struct stp_facts *f = &scene->facts;
    size_t pixels, count = readings(&scene->volume->range, &pixels, &f->not_finite);
    set_places(scene, k);
    f->color_max = 0;
    for (size_t i = 0; i < k->count; i++)
        for (int a = 0; a < 3; a++)
            f->color_max = fmaxf(f->color_max, k->color[i][a]);
    f->splats = k->count;
    f->clipped = count - k->count;
    f->normals = STP_NORMALS_NONE;
    f->has_color = f->two_sided = true;
    f->objects = 1;
    f->range.holes = pixels - count;
    f->range.deviation_median = deviation;
    f->range.sources = (double)k->source_first[k->count] / (double)k->count;
    f->radius_min = f->radius_median = f->radius_max = (float)(KERNEL_REACH * deviation);
    if (scene->objects[0].epsilon == 0)
        scene->objects[0].epsilon = deviation;
}

enum stp_result prepare_range(const struct stp_env *env, struct stp_scene *scene,
                              const struct stp_prepare_params *params)
{
    struct kernels made = { 0 };
    float *deviation = NULL;
    double middle = 0;
    enum stp_result result = make_kernels(env, &scene->volume->range,
                                          params ? params->clip_box : NULL, &made, &deviation);
    if (result == STP_OK)
        result = median(env, deviation, made.count, &middle);
    mem_free(deviation);
    if (result != STP_OK) {
        kernels_release(&made);
        return result;
    }
    scene->volume->kernels = made;
    set_facts(scene, &made, middle);
    scene->prepared = true;
    log_progress(env, "prepare", 1);
    return STP_OK;
}
