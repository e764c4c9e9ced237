#include "reference/volume.h"

#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "reference/bins.h"
#include "scene/samples.h"

#define PIXELS (VOLUME_TILE * VOLUME_TILE)

/* Sums over a pixel's samples. */
struct ray_sum {
    struct vec3 color, albedo;
    double alpha, depth, best;
    uint32_t hits, fragments, voxel;
};

struct scratch {
    struct medium_fragment *fragment; /* of a tile's pixels, one after the other */
    size_t capacity;
    size_t first[PIXELS + 1], next[PIXELS];
    struct ray ray[PIXELS];
    struct ray_sum sum[PIXELS];
    bool failed;
};

struct job {
    const struct stp_env *env;
    const struct medium *medium;
    const struct medium_bins *bins;
    const struct planes *planes;
    struct scratch *scratch; /* one a thread */
};

struct tile {
    const struct job *job;
    struct scratch *scratch;
    const uint32_t *kernel;
    size_t count;
    uint32_t x0, x1, y0, y1;
    bool fill; /* else fragments are only counted */
};

static int by_depth(const void *a, const void *b)
{
    const struct medium_fragment *x = a, *y = b;
    if (x->depth != y->depth)
        return x->depth < y->depth ? -1 : 1;
    return (x->kernel > y->kernel) - (x->kernel < y->kernel);
}

static void visit_pixel(const struct tile *tile, size_t at, uint32_t kernel, struct vec3 centre)
{
    const struct medium *medium = tile->job->medium;
    struct scratch *s = tile->scratch;
    struct medium_fragment fragment = { .kernel = kernel };
    if (!medium_hit_kernel(medium, kernel, centre, &s->ray[at], &fragment))
        return;
    if (tile->fill)
        s->fragment[s->next[at]] = fragment;
    s->next[at]++;
}

static void visit_kernels(const struct tile *tile)
{
    const struct medium *medium = tile->job->medium;
    for (size_t i = 0; i < tile->count; i++) {
        struct vec3 centre = medium_centre(medium, tile->kernel[i]);
        double bounds[4];
        uint32_t x0, x1, y0, y1;
        if (!medium_bounds(medium, tile->kernel[i], centre, bounds) ||
            !cells_touched(bounds[0], bounds[1], 1, tile->x0, tile->x1, &x0, &x1) ||
            !cells_touched(bounds[2], bounds[3], 1, tile->y0, tile->y1, &y0, &y1))
            continue;
        for (uint32_t y = y0; y <= y1; y++)
            for (uint32_t x = x0; x <= x1; x++)
                visit_pixel(tile, (size_t)(y - tile->y0) * VOLUME_TILE + (x - tile->x0),
                            tile->kernel[i], centre);
    }
}

/* Room for what was counted; the counts become places. */
static bool make_room(struct scratch *s)
{
    size_t total = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        s->first[i] = total;
        total += s->next[i];
        s->next[i] = s->first[i];
    }
    s->first[PIXELS] = total;
    if (total <= s->capacity)
        return true;
    struct medium_fragment *grown = mem_realloc(s->fragment, total, sizeof *grown);
    if (!grown)
        return false;
    s->fragment = grown;
    s->capacity = total;
    return true;
}

/* Of a surface: what covers half of a ray or more is all there is of it (docs/range.md). */
static void normalise(struct ray_sum *sum)
{
    double scale = sum->alpha > 0 ? fmin(1, 2 * sum->alpha) / sum->alpha : 0;
    sum->color = v3_scale(sum->color, scale);
    sum->albedo = v3_scale(sum->albedo, scale);
    sum->depth *= scale;
    sum->alpha *= scale;
}

/* Front to back. */
static void composite(const struct medium *medium, const struct medium_fragment *f, size_t count,
                      struct ray_sum *all)
{
    double left = 1;
    struct ray_sum one = { .best = all->best, .voxel = all->voxel }, *sum = &one;
    for (size_t i = 0; i < count; i++) {
        double w = left * f[i].alpha;
        const struct kernels *k = &medium->volume->kernels;
        sum->color = v3_add(sum->color, v3_scale(v3_load(medium->shaded[f[i].kernel]), w));
        sum->albedo = v3_add(sum->albedo, v3_scale(v3_loadf(k->color[f[i].kernel]), w));
        sum->depth += w * f[i].depth;
        sum->alpha += w;
        if (w > sum->best) {
            sum->best = w;
            sum->voxel = k->voxel[f[i].kernel];
        }
        left *= 1 - f[i].alpha;
    }
    if (volume_is_range(medium->volume))
        normalise(&one);
    all->color = v3_add(all->color, one.color);
    all->albedo = v3_add(all->albedo, one.albedo);
    all->depth += one.depth;
    all->alpha += one.alpha;
    all->best = one.best;
    all->voxel = one.voxel;
    all->hits += count > 0;
    all->fragments += (uint32_t)count;
}

static void aim(const struct tile *tile, uint32_t sample)
{
    const struct view *view = tile->job->medium->view;
    struct scratch *s = tile->scratch;
    for (size_t i = 0; i < PIXELS; i++)
        s->next[i] = 0;
    for (uint32_t y = tile->y0; y < tile->y1; y++)
        for (uint32_t x = tile->x0; x < tile->x1; x++) {
            double px, py;
            sample_position(view->grid, x, y, sample, &px, &py);
            s->ray[(size_t)(y - tile->y0) * VOLUME_TILE + (x - tile->x0)] =
                eye_ray(&view->eye, px, py);
        }
}

static void trace_sample(struct tile *tile, uint32_t sample)
{
    struct scratch *s = tile->scratch;
    aim(tile, sample);
    tile->fill = false;
    visit_kernels(tile);
    if (!make_room(s)) {
        s->failed = true;
        return;
    }
    tile->fill = true;
    visit_kernels(tile);
    for (size_t i = 0; i < PIXELS; i++) {
        size_t count = s->first[i + 1] - s->first[i];
        if (count > 1)
            qsort(s->fragment + s->first[i], count, sizeof *s->fragment, by_depth);
        composite(tile->job->medium, s->fragment + s->first[i], count, &s->sum[i]);
    }
}

static void write1(float *plane, size_t at, double value)
{
    if (plane)
        plane[at] = (float)value;
}

static void write3(float *const plane[3], size_t at, struct vec3 v)
{
    write1(plane[0], at, v.x);
    write1(plane[1], at, v.y);
    write1(plane[2], at, v.z);
}

/* A medium has no normal: N stays 0. */
static void write_pixel(const struct job *job, uint32_t x, uint32_t y, const struct ray_sum *sum)
{
    const struct view *view = job->medium->view;
    const struct planes *p = job->planes;
    size_t at = (size_t)y * view->width + x;
    double samples = (double)view->grid * view->grid;
    if (sum->hits == 0) {
        p->z[at] = INFINITY;
        if (p->id)
            p->id[at] = UINT32_MAX;
        return;
    }
    double depth = sum->depth / sum->alpha;
    struct ray ray = eye_ray(&view->eye, x + 0.5, y + 0.5);
    write3(p->color, at, v3_scale(sum->color, 1 / samples));
    write1(p->color[3], at, sum->alpha / samples);
    write1(p->z, at, depth);
    write3(p->albedo, at, v3_scale(sum->albedo, 1 / sum->alpha));
    write3(p->position, at, eye_point_to_world(&view->eye, ray_at(&ray, depth)));
    write1(p->weight, at, sum->alpha / samples);
    write1(p->fragments, at, sum->fragments);
    write1(p->coverage, at, sum->hits / samples);
    write1(p->layers, at, 1);
    if (p->id)
        p->id[at] = sum->voxel;
}

static void render_tile(const struct job *job, size_t index, struct scratch *scratch)
{
    const struct view *view = job->medium->view;
    const struct medium_bins *bins = job->bins;
    uint32_t x = (uint32_t)(index % bins->across) * VOLUME_TILE;
    uint32_t y = (uint32_t)(index / bins->across) * VOLUME_TILE;
    struct tile tile = { .job = job,
                         .scratch = scratch,
                         .kernel = bins->kernel + bins->first[index],
                         .count = bins->first[index + 1] - bins->first[index],
                         .x0 = x,
                         .x1 = x + VOLUME_TILE < view->width ? x + VOLUME_TILE : view->width,
                         .y0 = y,
                         .y1 = y + VOLUME_TILE < view->height ? y + VOLUME_TILE : view->height };
    for (size_t i = 0; i < PIXELS; i++)
        scratch->sum[i] = (struct ray_sum){ 0 };
    for (uint32_t sample = 0; sample < view->grid * view->grid && !scratch->failed; sample++)
        trace_sample(&tile, sample);
    for (y = tile.y0; y < tile.y1; y++)
        for (x = tile.x0; x < tile.x1; x++)
            write_pixel(job, x, y,
                        &scratch->sum[(size_t)(y - tile.y0) * VOLUME_TILE + (x - tile.x0)]);
}

static void render_tiles(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct job *job = context;
    size_t tiles = (size_t)job->bins->across * job->bins->down;
    for (size_t tile = begin; tile < end && !job->scratch[worker].failed; tile++)
        render_tile(job, tile, &job->scratch[worker]);
    if (worker == 0) /* the caller's own thread */
        log_progress(job->env, "reference", (double)end / (double)tiles);
}

static enum stp_result render(const struct stp_env *env, const struct medium *medium,
                              const struct planes *planes)
{
    unsigned threads = thread_count(env);
    struct medium_bins bins;
    struct scratch *scratch = mem_zalloc(threads, sizeof *scratch);
    if (!scratch)
        return log_no_memory(env, threads * sizeof *scratch, "the reference's tiles");
    enum stp_result result = medium_bins_build(env, medium, &bins);
    if (result == STP_OK) {
        struct job job = { env, medium, &bins, planes, scratch };
        parallel_for(env, (size_t)bins.across * bins.down, 1, render_tiles, &job);
        medium_bins_release(&bins);
    }
    for (unsigned i = 0; i < threads; i++) {
        if (result == STP_OK && scratch[i].failed)
            result = log_no_memory(env, scratch[i].capacity * 2 * sizeof *scratch[i].fragment,
                                   "the fragments of a tile");
        mem_free(scratch[i].fragment);
    }
    mem_free(scratch);
    return result;
}

enum stp_result medium_render(const struct stp_env *env, const struct view *view,
                              const struct planes *planes, const struct stp_render_params *params,
                              double least_alpha)
{
    struct medium medium;
    enum stp_result result = medium_init(env, view, &medium);
    if (result != STP_OK)
        return result;
    medium.least_alpha = least_alpha;
    result = render(env, &medium, planes);
    medium_release(&medium);
    if (result == STP_OK)
        planes_finish(env, planes, view, params);
    return result;
}
