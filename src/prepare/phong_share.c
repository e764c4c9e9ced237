#include "prepare/phong_share.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_clip.h"

#define GRAIN    64
#define LONGEST  3.0 /* ratio of the axes, as patches grow */
#define STEEPEST 0.1 /* cosine of a normal to the plane, as patches grow */
#define OPEN     5   /* fewer members: the plane of the whole patch says more */
#define BESIDE   1.5 /* times the least squared distance: holders as near as that share a site */
#define LEANS    0.5 /* cosine, 60 degrees: where splats bend more, rays pass between their planes */

struct sharing {
    const struct fit_cloud *cloud;
    struct patch_set *set;
    double tolerance;
    _Atomic uint32_t *nearest; /* a site: the least distance of its holders, as bits */
};

/* Whether a patch keeps all it holds: at edges the lines were found with it, and splats beside them
 * do not grow into gaps. */
static bool is_whole(const struct fit_cloud *cloud, const struct patch *p)
{
    for (uint32_t k = 0; k < p->count; k++)
        if (v3_dot(site_normal(cloud, p->member[k], p->frame.n), p->frame.n) < LEANS)
            return true;
    return patch_is_at_edges(cloud, p);
}

/* Of the members' spread along u over that along v. */
static double spread_ratio(const struct fit_cloud *cloud, const struct patch *p)
{
    double xx = 0, yy = 0;
    for (uint32_t k = 0; k < p->count; k++) {
        struct xy at = in_plane(cloud, p->member[k], &p->frame);
        xx += at.x * at.x;
        yy += at.y * at.y;
    }
    double ratio = xx > 0 && yy > 0 ? sqrt(xx / yy) : 1;
    return fmin(fmax(ratio, 1 / LONGEST), LONGEST);
}

/* Squared, in an ellipse of that ratio with a circle's area. */
static float distance_to(const struct fit_cloud *cloud, const struct patch *p, double ratio,
                         uint32_t site)
{
    struct xy at = in_plane(cloud, site, &p->frame);
    return (float)(at.x * at.x / ratio + at.y * at.y * ratio);
}

/* Distances are not negative: their bits order as they do. */
static void claim(_Atomic uint32_t *nearest, float distance)
{
    uint32_t bits, now = atomic_load_explicit(nearest, memory_order_relaxed);
    memcpy(&bits, &distance, sizeof bits);
    while (bits < now && !atomic_compare_exchange_weak(nearest, &now, bits))
        ;
}

static void claim_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct sharing *s = context;
    for (size_t i = begin; i < end; i++) {
        const struct patch *p = &s->set->patch[i];
        double ratio = spread_ratio(s->cloud, p);
        for (uint32_t k = 0; k < p->count; k++)
            claim(&s->nearest[p->member[k]], distance_to(s->cloud, p, ratio, p->member[k]));
    }
}

static bool holds_all(const struct sharing *s, const struct patch *p,
                      const struct patch_frame *frame)
{
    for (uint32_t k = 0; k < p->count; k++) {
        struct vec3 d = v3_sub(v3_load(s->cloud->site[p->member[k]].p), frame->c);
        if (fabs(v3_dot(d, frame->n)) > s->tolerance ||
            v3_dot(site_normal(s->cloud, p->member[k], frame->n), frame->n) < STEEPEST)
            return false;
    }
    return true;
}

static void refit(const struct sharing *s, struct patch *p)
{
    struct patch_frame frame;
    if (p->count < OPEN)
        return;
    patch_plane(s->cloud, p->member, p->count, p->frame.n, &frame);
    if (!holds_all(s, p, &frame))
        return;
    patch_axes(s->cloud, p->member, p->count, &frame);
    p->frame = frame;
}

static double least_distance(const struct sharing *s, uint32_t site)
{
    uint32_t bits = s->nearest[site];
    float least;
    memcpy(&least, &bits, sizeof least);
    return (double)least;
}

/* Something is left: a cover has no patch without a site of its own. */
static void keep_nearest(const struct sharing *s, struct patch *p)
{
    uint32_t kept = 0, seed = NO_SITE;
    if (is_whole(s->cloud, p))
        return;
    double ratio = spread_ratio(s->cloud, p);
    for (uint32_t k = 0; k < p->count; k++) {
        uint32_t site = p->member[k];
        if ((double)distance_to(s->cloud, p, ratio, site) > BESIDE * least_distance(s, site))
            continue;
        seed = seed == NO_SITE || site == p->seed ? site : seed;
        p->member[kept++] = site;
    }
    if (kept == p->count)
        return;
    p->count = kept;
    p->seed = seed;
    refit(s, p);
}

static void keep_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct sharing *s = context;
    for (size_t i = begin; i < end; i++)
        keep_nearest(s, &s->set->patch[i]);
}

enum stp_result patches_share(const struct stp_env *env, const struct fit_cloud *cloud,
                              double tolerance, struct patch_set *set)
{
    struct sharing s = { .cloud = cloud,
                         .set = set,
                         .tolerance = tolerance,
                         .nearest = mem_alloc(cloud->count, sizeof *s.nearest) };
    if (!s.nearest)
        return log_no_memory(env, cloud->count * sizeof *s.nearest, "the holders of sites");
    memset(s.nearest, 0xff, cloud->count * sizeof *s.nearest);
    parallel_for(env, set->count, GRAIN, claim_range, &s);
    parallel_for(env, set->count, GRAIN, keep_range, &s);
    mem_free(s.nearest);
    return STP_OK;
}
