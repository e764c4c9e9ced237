#include "prepare/collect.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "base/vec.h"
#include "prepare/radii.h"
#include "scene/phong.h"

#define FARTHEST 1e18 /* its square fits float32 */
#define GRAIN    16384

enum verdict { KEEP = 0, NOT_FINITE, CLIPPED, BAD_PHONG, VERDICTS };

struct collect {
    struct splats *splats;
    const double *clip_box;
    size_t (*dropped)[VERDICTS - NOT_FINITE]; /* a worker: how many of each */
};

static enum verdict judge(const double p[3], const double *box)
{
    for (int axis = 0; axis < 3; axis++)
        if (!(fabs(p[axis]) <= FARTHEST))
            return NOT_FINITE;
    for (int axis = 0; box && axis < 3; axis++)
        if (p[axis] < box[axis] || p[axis] > box[axis + 3])
            return CLIPPED;
    return KEEP;
}

static void clean_normal(float normal[3])
{
    struct vec3 n = v3_loadf(normal);
    double length = v3_length(n);
    bool usable = length > 1e-30 && length < INFINITY;
    /* Unit to rounding stays as it is: what was prepared once reads back bit for bit. */
    if (usable && fabs(length - 1) < 2e-7)
        return;
    n = usable ? v3_scale(n, 1 / length) : v3(0, 0, 0);
    v3_storef(n, normal);
}

static void clean_color(float color[3])
{
    for (int c = 0; c < 3; c++)
        if (!isfinite(color[c]))
            color[c] = isnan(color[c]) || color[c] < 0 ? 0 : 65504;
}

static float clean_opacity(float opacity)
{
    return isnan(opacity) || opacity > 1 ? 1 : opacity < 0 ? 0 : opacity;
}

/* False: not usable, and made a disc. A disc's radius and normal may have to be found first. */
static bool clean_phong(const struct splats *s, size_t i)
{
    struct stp_phong_splat *phong = &s->phong[i];
    bool disc = phong_is_disc(phong);
    bool good = radius_is_good(phong->radius[0]) && radius_is_good(phong->radius[1]);
    if (!disc && good && phong_clean(phong, s->normal[i])) {
        s->radius[i] = fmaxf(phong->radius[0], phong->radius[1]);
        return true;
    }
    *phong = phong_of_disc(s->normal[i], s->radius[i]);
    return disc;
}

static void clean_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct collect *c = context;
    const struct splats *s = c->splats;
    for (size_t i = begin; i < end; i++) {
        enum verdict verdict = judge(s->position[i], c->clip_box);
        if (verdict != KEEP)
            c->dropped[worker][verdict - NOT_FINITE]++;
        if (s->normal)
            clean_normal(s->normal[i]);
        if (s->radius && !radius_is_good(s->radius[i]))
            s->radius[i] = 0;
        if (s->color)
            clean_color(s->color[i]);
        if (s->opacity)
            s->opacity[i] = clean_opacity(s->opacity[i]);
        if (s->phong)
            c->dropped[worker][BAD_PHONG - NOT_FINITE] += !clean_phong(s, i);
    }
}

static void move_splat(struct splats *s, size_t to, size_t from)
{
    memmove(s->position[to], s->position[from], sizeof s->position[to]);
    if (s->normal)
        memmove(s->normal[to], s->normal[from], sizeof s->normal[to]);
    if (s->radius)
        s->radius[to] = s->radius[from];
    if (s->color)
        memmove(s->color[to], s->color[from], sizeof s->color[to]);
    if (s->opacity)
        s->opacity[to] = s->opacity[from];
    if (s->phong)
        s->phong[to] = s->phong[from];
    s->input[to] = (uint32_t)from;
}

static enum stp_result drop(const struct stp_env *env, struct splats *s, const double *clip_box,
                            size_t dropped)
{
    size_t kept = 0;
    s->input = mem_alloc(s->count - dropped, sizeof *s->input);
    if (!s->input)
        return log_no_memory(env, (s->count - dropped) * sizeof *s->input, "points");
    for (size_t i = 0; i < s->count; i++)
        if (judge(s->position[i], clip_box) == KEEP)
            move_splat(s, kept++, i);
    s->count = kept;
    return STP_OK;
}

static void take_arrays(struct cloud *cloud, struct splats *s)
{
    *s = (struct splats){ .count = cloud->count,
                          .position = cloud->position,
                          .normal = cloud->normal,
                          .radius = cloud->radius,
                          .color = cloud->color,
                          .opacity = cloud->opacity,
                          .phong = cloud->phong };
    cloud->position = NULL;
    cloud->normal = NULL;
    cloud->radius = NULL;
    cloud->color = NULL;
    cloud->opacity = NULL;
    cloud->phong = NULL;
    cloud_release(cloud);
}

enum stp_result collect_cloud(const struct stp_env *env, struct cloud *cloud,
                              const double *clip_box, struct splats *splats,
                              struct stp_facts *facts)
{
    unsigned threads = thread_count(env);
    struct collect c = { splats, clip_box, mem_zalloc(threads, sizeof *c.dropped) };
    size_t dropped[VERDICTS - NOT_FINITE] = { 0 };
    if (!c.dropped)
        return log_no_memory(env, threads * sizeof *c.dropped, "counters");
    take_arrays(cloud, splats);
    if (splats->phong && !splats->radius)
        splats->radius = mem_zalloc(splats->count, sizeof *splats->radius);
    if (splats->phong && !splats->radius) {
        mem_free(c.dropped);
        return log_no_memory(env, splats->count * sizeof *splats->radius, "radii");
    }
    parallel_for(env, splats->count, GRAIN, clean_range, &c);
    for (unsigned worker = 0; worker < threads; worker++)
        for (int why = 0; why < VERDICTS - NOT_FINITE; why++)
            dropped[why] += c.dropped[worker][why];
    mem_free(c.dropped);
    facts->not_finite += dropped[0];
    facts->clipped += dropped[1];
    facts->bad_phong += dropped[2];
    if (dropped[0] + dropped[1] == 0)
        return STP_OK;
    return drop(env, splats, clip_box, dropped[0] + dropped[1]);
}
