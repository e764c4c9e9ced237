#include "prepare/phong_splats.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_clip.h"
#include "prepare/phong_ellipse.h"
#include "prepare/phong_field.h"
#include "scene/phong.h"

/* Of the mean spacing of a splat's sites: how far its axes reach beyond them, so that the surface
 * between the sites of neighbouring splats is covered too. Splats of few sites overlap less. */
#define GAP     0.5
#define GAP_FEW 0.7 /* over the root of the count */

struct splat_maker {
    const struct fit_cloud *cloud;
    const struct patch_set *set;
    struct splats *splats;
    double tolerance;
    bool flat;          /* constant fields */
    double (*point)[2]; /* of the patch at hand, a worker's own */
    struct field_sample *sample;
};

/* --- one splat
 * ------------------------------------------------------------------------------------- */

/* What of a splat is stored as floats, read back: everything else is computed from that. */
static void stored_frame(const float normal[3], const float u[3], struct patch_frame *frame)
{
    frame->n = v3_loadf(normal);
    frame->u = v3_loadf(u);
    frame->v = v3_cross(frame->n, frame->u);
}

static void store(float out[3], struct vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* Never below x. */
static float round_up(double x)
{
    float f = (float)x;
    return (double)f < x ? nextafterf(f, INFINITY) : f;
}

/* Where members are in the frame's plane, and the feet of those near an edge; returns how many. */
static size_t project(const struct splat_maker *m, const struct patch *p,
                      const struct patch_frame *f, const struct clip_lines *lines, double gap,
                      double (*point)[2])
{
    size_t count = p->count;
    for (uint32_t k = 0; k < p->count; k++) {
        struct vec3 d = v3_sub(v3_load(m->cloud->site[p->member[k]].p), f->c);
        point[k][0] = v3_dot(d, f->u);
        point[k][1] = v3_dot(d, f->v);
    }
    for (uint32_t k = 0; lines->count > 0 && k < p->count; k++)
        count += clip_feet(lines, point[k][0], point[k][1], 4 * gap, point + count);
    return count;
}

/* From the plane's x and y to the ellipse's s and t. Lines that do not meet the ellipse are left.
 */
static void store_lines(const struct clip_lines *lines, const double center[2],
                        struct stp_phong_splat *phong)
{
    for (unsigned i = 0; i < lines->count; i++) {
        const double *l = lines->line[i];
        double a = l[0] * (double)phong->radius[0], b = l[1] * (double)phong->radius[1];
        double c = l[0] * center[0] + l[1] * center[1] + l[2];
        bool meets = fabs(c) < hypot(a, b);
        if (!meets && lines->reflex && c > 0) { /* either may keep it, and this one keeps all */
            phong->clips = 0;
            return;
        }
        if (!meets)
            continue; /* keeps all where both must, or nothing where either may */
        phong->clip[phong->clips][0] = (float)a;
        phong->clip[phong->clips][1] = (float)b;
        phong->clip[phong->clips++][2] = (float)c;
    }
    phong->reflex = lines->reflex && phong->clips == 2;
}

static double mean_spacing(const struct fit_cloud *cloud, const struct patch *p)
{
    double sum = 0;
    for (uint32_t k = 0; k < p->count; k++)
        sum += (double)cloud->site[p->member[k]].spacing;
    return sum / p->count;
}

/* Eq. 2-4: normals in the frame, with the third coordinate 1. They are tangents of the tilt: a
 * weight of its cosine to the fourth makes their squared differences those of angles, and keeps the
 * few that are tilted far from ruling the rest. */
static void fit_field(const struct splat_maker *m, const struct patch *p,
                      const struct patch_frame *f, const double center[2],
                      struct stp_phong_splat *phong)
{
    size_t count = 0;
    double field[4];
    for (uint32_t k = 0; k < p->count; k++) {
        struct vec3 n = site_normal(m->cloud, p->member[k], f->n);
        double z = v3_dot(n, f->n);
        if (z <= 0.1) /* 84 degrees: it tells the side no more */
            continue;
        m->sample[count++] =
            (struct field_sample){ (m->point[k][0] - center[0]) / (double)phong->radius[0],
                                   (m->point[k][1] - center[1]) / (double)phong->radius[1],
                                   v3_dot(n, f->u) / z, v3_dot(n, f->v) / z, z * z * z * z };
    }
    field_fit(m->sample, count, m->flat, field);
    for (int i = 0; i < 4; i++)
        phong->field[i] = (float)field[i];
}

static void mean_color(const struct splat_maker *m, const struct patch *p, size_t at)
{
    const struct splats *s = m->cloud->samples;
    double sum[3] = { 0 }, n = 0;
    for (uint32_t k = 0; k < p->count; k++)
        for (uint32_t i = m->cloud->first[p->member[k]]; i < m->cloud->first[p->member[k] + 1];
             i++) {
            n += 1;
            for (int c = 0; c < 3; c++)
                sum[c] += (double)s->color[i][c];
        }
    for (int c = 0; c < 3; c++)
        m->splats->color[at][c] = (float)(sum[c] / n);
}

/* What the splat takes over from one sample. */
static void inherit(const struct splat_maker *m, uint32_t sample, size_t at)
{
    const struct splats *s = m->cloud->samples;
    struct splats *out = m->splats;
    out->input[at] = s->input[sample];
    if (out->object)
        out->object[at] = s->object[sample];
    if (out->opacity)
        out->opacity[at] = s->opacity[sample];
    if (out->color)
        memcpy(out->color[at], s->color[sample], sizeof out->color[at]);
}

/* A disc of the sample's own radius and normal. */
static void single(const struct splat_maker *m, uint32_t sample, const float n[3], size_t at)
{
    const struct splats *s = m->cloud->samples;
    memcpy(m->splats->position[at], s->position[sample], sizeof s->position[sample]);
    memcpy(m->splats->normal[at], n, sizeof m->splats->normal[at]);
    m->splats->radius[at] = s->radius[sample];
    m->splats->phong[at] = phong_of_disc(n, s->radius[sample]);
    inherit(m, sample, at);
}

/* The ellipse about the seed, of the shape that the patch grew in. */
static void grown_ellipse(const struct splat_maker *m, const struct patch *p,
                          const struct patch_frame *f, size_t count, double center[2],
                          double radius[2])
{
    struct vec3 d = v3_sub(v3_load(m->cloud->site[p->seed].p), f->c);
    double most = 0, ratio = sqrt(p->shape);
    center[0] = v3_dot(d, f->u);
    center[1] = v3_dot(d, f->v);
    for (size_t k = 0; k < count; k++)
        most = fmax(most, hypot((m->point[k][0] - center[0]) / ratio,
                                (m->point[k][1] - center[1]) * ratio));
    radius[0] = most * ratio * (1 + 1e-12);
    radius[1] = most / ratio * (1 + 1e-12);
}

/* The minimum enclosing ellipse; of a patch that edges cut off, the better of two, for the ends of
 * a strip between edges stick out of the one and the far side of a patch that grew from its border
 * out of the other: what the lines leave is to be least. */
static void fit_ellipse(const struct splat_maker *m, const struct patch *p,
                        const struct patch_frame *f, const struct clip_lines *lines, size_t count,
                        double gap, double center[2], double radius[2])
{
    double other[2], axes[2];
    ellipse_enclose((const double(*)[2])m->point, count, 0.1 * gap, center, radius);
    if (lines->count == 0)
        return;
    grown_ellipse(m, p, f, count, other, axes);
    if (clip_area(lines, other, axes) >= clip_area(lines, center, radius))
        return;
    memcpy(center, other, sizeof other);
    memcpy(radius, axes, sizeof axes);
}

static void make_splat(const struct splat_maker *m, size_t at)
{
    const struct patch *p = &m->set->patch[at];
    const struct fit_cloud *cloud = m->cloud;
    struct splats *out = m->splats;
    struct stp_phong_splat phong = { 0 };
    struct patch_frame f = p->frame;
    struct clip_lines lines;
    double center[2], radius[2], share = GAP + GAP_FEW / sqrt(p->count);
    double gap = share * mean_spacing(cloud, p);
    if (p->count == 1 && cloud->first[p->seed + 1] - cloud->first[p->seed] == 1) {
        single(m, cloud->first[p->seed], cloud->site[p->seed].n, at);
        return;
    }
    gap = gap > 0 ? gap : share * (double)cloud->samples->radius[cloud->first[p->seed]];
    inherit(m, cloud->first[p->seed], at);
    store(out->normal[at], f.n);
    store(phong.u, f.u);
    stored_frame(out->normal[at], phong.u, &f);
    patch_clips(cloud, p, &f, m->tolerance, &lines);
    size_t count = project(m, p, &f, &lines, gap, m->point);
    fit_ellipse(m, p, &f, &lines, count, gap, center, radius);
    struct vec3 c = v3_add(f.c, v3_add(v3_scale(f.u, center[0]), v3_scale(f.v, center[1])));
    out->position[at][0] = cloud->origin[0] + c.x;
    out->position[at][1] = cloud->origin[1] + c.y;
    out->position[at][2] = cloud->origin[2] + c.z;
    for (int i = 0; i < 2; i++)
        phong.radius[i] = round_up(radius[i] + gap);
    store_lines(&lines, center, &phong);
    fit_field(m, p, &f, center, &phong);
    out->radius[at] = fmaxf(phong.radius[0], phong.radius[1]);
    out->phong[at] = phong;
    if (out->color)
        mean_color(m, p, at);
}

/* --- what the stored splat covers ---------------------------------------------------------------
 */

static bool is_kept(const struct stp_phong_splat *phong, double s, double t)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < phong->clips; i++)
        kept += (double)phong->clip[i][0] * s + (double)phong->clip[i][1] * t +
                    (double)phong->clip[i][2] >=
                0;
    return phong->reflex ? kept > 0 : kept == phong->clips;
}

/* The distance of a sample from the splat's plane; INFINITY: the splat does not cover it. */
static double distance_to(const struct splats *splats, size_t at, const double position[3])
{
    const struct stp_phong_splat *phong = &splats->phong[at];
    struct patch_frame f;
    struct vec3 d = v3_sub(v3_load(position), v3_load(splats->position[at]));
    stored_frame(splats->normal[at], phong->u, &f);
    double s = v3_dot(d, f.u) / (double)phong->radius[0];
    double t = v3_dot(d, f.v) / (double)phong->radius[1];
    return s * s + t * t <= 1 && is_kept(phong, s, t) ? fabs(v3_dot(d, f.n)) : INFINITY;
}

/* --- all
 * -------------------------------------------------------------------------------------------- */

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
        make_splat(&m, i);
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
    for (size_t at = 0; at < set->count; at++)
        for (uint32_t k = 0; k < set->patch[at].count; k++) {
            uint32_t site = set->patch[at].member[k], first = cloud->first[site];
            double distance = distance_to(splats, at, cloud->samples->position[first]);
            for (uint32_t i = first; i < cloud->first[site + 1]; i++)
                nearest[i] = fmin(nearest[i], distance);
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
            single(m, (uint32_t)i, m->cloud->samples->normal[i], at++);
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
                                  const struct patch_set *set, double tolerance, bool flat,
                                  struct splats *splats, double *deviation)
{
    struct splats made;
    struct splat_job job = { .maker = { .cloud = cloud,
                                        .set = set,
                                        .splats = &made,
                                        .flat = flat,
                                        .tolerance = tolerance } };
    size_t samples = cloud->samples->count;
    double *nearest = mem_alloc(samples, sizeof *nearest), most = 0;
    enum stp_result result = allocate(env, cloud->samples, set->count, &made);
    if (result == STP_OK && !nearest)
        result = log_no_memory(env, samples * sizeof *nearest, "the deviations of points");
    if (result == STP_OK)
        result = make_all(env, &job);
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
