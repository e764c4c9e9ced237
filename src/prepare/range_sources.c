/* Which frames see an ellipsoid, how sure they are of it, and what its colour is to them. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/range.h"
#include "scene/range.h"

struct seeing {
    const struct range *range;
    const float *deviation;
    struct kernels *kernels;
    bool fill;
};

struct seen {
    struct kernel_source source;
    double at[2];
};

/* The weight of frame `index` on the place: the inverse of its variance over the own frame's. 0: it
 * sees something else, or nothing. */
static double weight_of(const struct range *range, unsigned index, struct vec3 place,
                        double deviation, double at[2])
{
    const struct range_frame *f = &range->frame[index];
    double z;
    if (!range_project(f, place, at, &z))
        return 0;
    size_t u = (size_t)at[0], v = (size_t)at[1];
    double depth = (double)f->depth[v * f->width + u];
    if (!(depth > 0))
        return 0;
    double footprint = depth / fmin(f->camera.fx, f->camera.fy);
    double own =
        fmax(range->uncertainty * range_deviation(f, depth), RANGE_LEAST_DEPTH * footprint);
    double variance = deviation * deviation + own * own + footprint * footprint;
    if ((z - depth) * (z - depth) > RANGE_AGREEMENT * RANGE_AGREEMENT * variance)
        return 0;
    return deviation * deviation / (own * own);
}

/* The lightest goes where there are too many; the first, the own frame's, stays. */
static unsigned keep(struct seen *list, unsigned count, const struct seen *one)
{
    unsigned to = count;
    if (count == RANGE_SOURCES) {
        to = 1;
        for (unsigned i = 2; i < count; i++)
            if (list[i].source.weight < list[to].source.weight)
                to = i;
        if (list[to].source.weight >= one->source.weight)
            return count;
    }
    list[to] = *one;
    return count == RANGE_SOURCES ? count : count + 1;
}

static unsigned frame_of(const struct range *range, uint32_t pixel, double at[2])
{
    unsigned frame = 0;
    size_t first = 0;
    for (size_t size;
         first + (size = (size_t)range->frame[frame].width * range->frame[frame].height) <= pixel;
         frame++)
        first += size;
    at[0] = (double)((pixel - first) % range->frame[frame].width) + 0.5;
    at[1] = (double)((pixel - first) / range->frame[frame].width) + 0.5;
    return frame;
}

static unsigned find(const struct seeing *s, size_t i, struct seen list[RANGE_SOURCES])
{
    const struct range *range = s->range;
    struct vec3 place = v3_load(s->kernels->place[i]);
    unsigned own = frame_of(range, s->kernels->voxel[i], list[0].at), count = 1;
    list[0].source = (struct kernel_source){ own, 1 };
    for (unsigned f = 0; f < range->count; f++) {
        struct seen one;
        double weight = f == own ? 0 : weight_of(range, f, place, (double)s->deviation[i], one.at);
        one.source = (struct kernel_source){ f, (float)weight };
        if (one.source.weight > 0)
            count = keep(list, count, &one);
    }
    return count;
}

/* Bilinear, clamped at the edges. */
static void color_at(const struct range_frame *f, const double at[2], float color[3])
{
    double x = fmin(fmax(at[0] - 0.5, 0), f->width - 1.0);
    double y = fmin(fmax(at[1] - 0.5, 0), f->height - 1.0);
    size_t u = (size_t)x, v = (size_t)y, u1 = u + 1 < f->width ? u + 1 : u,
           v1 = v + 1 < f->height ? v + 1 : v;
    for (int k = 0; k < 3; k++) {
        double a = (double)f->color[v * f->width + u][k],
               b = (double)f->color[v * f->width + u1][k];
        double c = (double)f->color[v1 * f->width + u][k],
               d = (double)f->color[v1 * f->width + u1][k];
        double top = a + (b - a) * (x - (double)u), low = c + (d - c) * (x - (double)u);
        color[k] = (float)(top + (low - top) * (y - (double)v));
    }
}

static void see_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct seeing *s = context;
    struct kernels *k = s->kernels;
    for (size_t i = begin; i < end; i++) {
        struct seen list[RANGE_SOURCES];
        unsigned count = find(s, i, list);
        if (!s->fill) {
            k->source_first[i + 1] = count;
            continue;
        }
        for (unsigned n = 0; n < count; n++) {
            size_t to = k->source_first[i] + n;
            k->source[to] = list[n].source;
            if (k->source_color)
                color_at(&s->range->frame[list[n].source.frame], list[n].at, k->source_color[to]);
        }
    }
}

enum stp_result range_find_sources(const struct stp_env *env, const struct range *range,
                                   const float *deviation, struct kernels *k)
{
    struct seeing s = { range, deviation, k, false };
    k->source_first = mem_alloc(k->count + 1, sizeof *k->source_first);
    if (!k->source_first)
        return log_no_memory(env, (k->count + 1) * sizeof *k->source_first, "sources");
    parallel_for(env, k->count, 4096, see_range, &s);
    size_t total = 0;
    k->source_first[0] = 0;
    for (size_t i = 1; i <= k->count; i++) {
        total += k->source_first[i];
        if (total > UINT32_MAX)
            return log_error(env, STP_ERROR_ARGUMENT,
                             "range images see each other's points more than 2^32 times: fewer "
                             "frames at once");
        k->source_first[i] = (uint32_t)total;
    }
    k->source = mem_alloc(total, sizeof *k->source);
    k->source_color = range->by_views ? mem_alloc(total, sizeof *k->source_color) : NULL;
    if (!k->source || (range->by_views && !k->source_color))
        return log_no_memory(env, total * (sizeof *k->source + 12), "sources");
    s.fill = true;
    parallel_for(env, k->count, 4096, see_range, &s);
    return STP_OK;
}
