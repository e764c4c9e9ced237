#include "prepare/phong_splats.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_face.h"
#include "prepare/phong_gaps.h"
#include "prepare/phong_joint.h"
#include "prepare/phong_make.h"

/* Tolerances: as far off its plane a splat shows a point. A picture averages what lies within 4 of
 * the nearest, which may itself be one before the surface. */
#define SHOWN 3.0

/* The distance of a sample from the splat's plane; INFINITY: the splat does not cover it. */
static double distance_to(const struct face *f, const double position[3])
{
    struct on_face at = face_place(f, v3_load(position));
    return at.s * at.s + at.t * at.t <= 1 && face_keeps(f, at) ? fabs(at.height) : INFINITY;
}

struct splat_job {
    struct splat_maker maker; /* without the worker's own room */
    size_t most;              /* members of a patch */
    bool *failed;             /* a worker */
};

static void make_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct splat_job *job = context;
    struct splat_maker m = job->maker;
    m.point = mem_alloc(4 * job->most, sizeof *m.point); /* each member, and its feet */
    m.sample = mem_alloc(job->most, sizeof *m.sample);
    job->failed[worker] |= !m.point || !m.sample;
    for (size_t i = begin; i < end && m.point && m.sample; i++)
        splat_make(&m, i);
    mem_free(m.point);
    mem_free(m.sample);
}

static enum stp_result allocate(const struct stp_env *env, const struct splats *like, size_t count,
                                struct splats *splats)
{
    *splats = (struct splats){ .count = count,
                               .position = mem_alloc(count, sizeof *splats->position),
                               .normal = mem_alloc(count, sizeof *splats->normal),
                               .radius = mem_alloc(count, sizeof *splats->radius),
                               .phong = mem_alloc(count, sizeof *splats->phong),
                               .input = mem_alloc(count, sizeof *splats->input) };
    bool made =
        splats->position && splats->normal && splats->radius && splats->phong && splats->input;
    if (like->color)
        made &= (splats->color = mem_alloc(count, sizeof *splats->color)) != NULL;
    if (like->opacity)
        made &= (splats->opacity = mem_alloc(count, sizeof *splats->opacity)) != NULL;
    if (like->object)
        made &= (splats->object = mem_alloc(count, sizeof *splats->object)) != NULL;
    memcpy(splats->origin, like->origin, sizeof splats->origin);
    return made ? STP_OK : log_no_memory(env, count * 96, "fitted splats");
}

/* nearest[i]: the smallest distance of sample i from a splat that covers it. */
static void measure(const struct fit_cloud *cloud, const struct patch_set *set,
                    const struct splats *splats, double *nearest)
{
    for (size_t i = 0; i < cloud->samples->count; i++)
        nearest[i] = INFINITY;
    for (size_t at = 0; at < set->count; at++) {
        struct face f = face_of(splats, at, (const double[3]){ 0 });
        for (uint32_t k = 0; k < set->patch[at].count; k++) {
            uint32_t site = set->patch[at].member[k], first = cloud->first[site];
            double distance = distance_to(&f, cloud->samples->position[first]);
            for (uint32_t i = first; i < cloud->first[site + 1]; i++)
                nearest[i] = fmin(nearest[i], distance);
        }
    }
}

static bool resize(struct splats *s, size_t count)
{
#define RESIZE(member)                                                                             \
    if (s->member) {                                                                               \
        void *larger = mem_realloc(s->member, count, sizeof *s->member);                           \
        if (!larger)                                                                               \
            return false;                                                                          \
        s->member = larger;                                                                        \
    }
    RESIZE(position)
    RESIZE(normal)
    RESIZE(radius)
    RESIZE(phong)
    RESIZE(input)
    RESIZE(color)
    RESIZE(opacity)
    RESIZE(object)
#undef RESIZE
    s->count = count;
    return true;
}

/* Rounding to float can push a sample out of its ellipse or beyond the tolerance: it gets a splat
 * of its own, in its own plane. */
static enum stp_result add_singles(const struct stp_env *env, const struct splat_maker *m,
                                   double *nearest)
{
    size_t samples = m->cloud->samples->count, at = m->splats->count, missing = 0;
    for (size_t i = 0; i < samples; i++)
        missing += nearest[i] > m->tolerance;
    if (missing == 0)
        return STP_OK;
    if (!resize(m->splats, at + missing))
        return log_no_memory(env, (at + missing) * 96, "fitted splats");
    for (size_t i = 0; i < samples; i++)
        if (nearest[i] > m->tolerance) {
            splat_single(m, (uint32_t)i, m->cloud->samples->normal[i], at++);
            nearest[i] = 0;
        }
    return STP_OK;
}

static enum stp_result make_all(const struct stp_env *env, struct splat_job *job)
{
    unsigned workers = thread_count(env);
    size_t count = job->maker.set->count;
    bool failed = false;
    job->failed = mem_zalloc(workers, sizeof *job->failed);
    if (!job->failed)
        return log_no_memory(env, workers, "fitted splats");
    for (size_t i = 0; i < count; i++)
        job->most =
            job->maker.set->patch[i].count > job->most ? job->maker.set->patch[i].count : job->most;
    parallel_for(env, count, 256, make_range, job);
    for (unsigned i = 0; i < workers; i++)
        failed |= job->failed[i];
    mem_free(job->failed);
    return failed ? log_no_memory(env, job->most * 64, "fitted splats") : STP_OK;
}

enum stp_result patches_to_splats(const struct stp_env *env, const struct fit_cloud *cloud,
                                  const struct patch_set *set, double tolerance,
                                  struct field_way way, struct splats *splats, double *deviation)
{
    struct splats made;
    struct splat_job job = { .maker = { .cloud = cloud,
                                        .set = set,
                                        .splats = &made,
                                        .flat = way.flat,
                                        .tolerance = tolerance } };
    size_t samples = cloud->samples->count;
    double *nearest = mem_alloc(samples, sizeof *nearest), most = 0;
    enum stp_result result = allocate(env, cloud->samples, set->count, &made);
    if (result == STP_OK && !nearest)
        result = log_no_memory(env, samples * sizeof *nearest, "the deviations of points");
    if (result == STP_OK)
        result = make_all(env, &job);
    if (result == STP_OK)
        result = gaps_close(env, cloud, set, SHOWN * tolerance, &made);
    if (result == STP_OK && !way.alone)
        result = fields_fit_together(env, cloud, set, SHOWN * tolerance, way.flat, &made);
    if (result == STP_OK) {
        measure(cloud, set, &made, nearest);
        result = add_singles(env, &job.maker, nearest);
    }
    for (size_t i = 0; result == STP_OK && i < samples; i++)
        most = fmax(most, nearest[i]);
    mem_free(nearest);
    if (result != STP_OK) {
        splats_release(&made);
        return result;
    }
    *splats = made;
    *deviation = most;
    return STP_OK;
}
