/* Patches grown from seeds over neighbours, as far as the tolerance lets them: an ellipse in the
 * seed's tangent plane, its axes those of curvature, is scaled until a site that it reaches is off
 * the least-squares plane of those nearer than it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_outline.h"
#include "prepare/phong_fit.h"

#define RING     24   /* sites that the first frame is estimated from */
#define CONE     0.26 /* cosine, 75 degrees: beyond it the linear field is of no use */
#define LONGEST  3.0  /* ratio of the axes */
#define STEEPEST 0.1  /* the same to the plane that was fitted, 84 degrees */
#define ROUNDS   10
#define FAR      4.0 /* tolerances from the plane: in the way whatever plane is fitted */
#define OVERHANG                                                                                   \
    1.2            /* of the ellipse over the sites' own area, against where they were densest     \
                    */
#define GROWTH 1.6 /* of the radius where nothing was in the way */
#define SEED   (-1.0)
#define BEYOND 0.5  /* squares of the spacing: a splat may show so much beyond an edge */
#define TRIM   0.75 /* of its members a patch keeps that shows more */

struct reached {
    double metric; /* s^2 + t^2; below 0: the seed, which comes before sites of its own place */
    uint32_t site;
};

struct grower {
    const struct fit_cloud *cloud;
    const struct fit_limits *limits;
    uint32_t *stamp, tick; /* of the sites seen */
    struct reached *reached;
    uint32_t *member;
    double (*room)[2]; /* of an outline */
    size_t capacity;
    bool out_of_memory;
};

struct grow_job {
    const struct fit_cloud *cloud;
    const struct fit_limits *limits;
    const uint32_t *seed;
    struct patch *made;
    struct grower *grower; /* a worker */
};

/* --- collecting ----------------------------------------------------------------------------------
 */

static bool make_room(struct grower *g, size_t count)
{
    if (count < g->capacity)
        return true;
    size_t capacity = g->capacity ? 2 * g->capacity : 256;
    struct reached *reached = mem_realloc(g->reached, capacity, sizeof *reached);
    if (reached)
        g->reached = reached;
    uint32_t *member = mem_realloc(g->member, capacity, sizeof *member);
    if (member)
        g->member = member;
    double(*room)[2] = mem_realloc(g->room, 4 * capacity, sizeof *room);
    if (room)
        g->room = room;
    g->out_of_memory = !reached || !member || !room;
    if (!g->out_of_memory)
        g->capacity = capacity;
    return !g->out_of_memory;
}

static bool same_color(const struct grower *g, uint32_t a, uint32_t b)
{
    const struct splats *s = g->cloud->samples;
    const float *p, *q;
    size_t i = g->cloud->first[a], j = g->cloud->first[b];
    if (s->opacity && s->opacity[i] != s->opacity[j])
        return false;
    if (!s->color || isinf(g->limits->color))
        return true;
    p = s->color[i];
    q = s->color[j];
    for (int c = 0; c < 3; c++)
        if (fabs((double)p[c] - (double)q[c]) > g->limits->color)
            return false;
    return true;
}

struct ellipse {
    struct patch_frame frame; /* c is the seed's place */
    double radius[2];
};

/* Does the ellipse reach site i, and on the frame's side? Sets *blocked to the metric of a site
 * that is so far off the plane that no patch can hold it. */
static bool is_reached(const struct grower *g, const struct ellipse *e, uint32_t seed, uint32_t i,
                       double *metric, double *blocked)
{
    const struct site *site = &g->cloud->site[i];
    struct vec3 d = v3_sub(v3_load(site->p), e->frame.c);
    double s = v3_dot(d, e->frame.u) / e->radius[0], t = v3_dot(d, e->frame.v) / e->radius[1];
    *metric = s * s + t * t;
    if (*metric > 1)
        return false;
    if (v3_dot(site_normal(g->cloud, i, e->frame.n), e->frame.n) < CONE)
        return false;
    if (fabs(v3_dot(d, e->frame.n)) > FAR * g->limits->tolerance || !same_color(g, seed, i)) {
        *blocked = fmin(*blocked, *metric);
        return false;
    }
    return true;
}

/* Sites within the ellipse that chains of neighbours join to the seed. */
static size_t collect(struct grower *g, const struct ellipse *e, uint32_t seed, size_t most,
                      double *blocked)
{
    size_t count = 1;
    g->tick++;
    g->stamp[seed] = g->tick;
    *blocked = INFINITY;
    if (!make_room(g, 1))
        return 0;
    g->reached[0] = (struct reached){ SEED, seed };
    for (size_t head = 0; head < count && count < most; head++) {
        const uint32_t *near = g->cloud->near[g->reached[head].site];
        for (unsigned k = 0; k < SITE_NEAR; k++) {
            double metric;
            if (near[k] == NO_SITE || g->stamp[near[k]] == g->tick)
                continue;
            g->stamp[near[k]] = g->tick;
            if (!is_reached(g, e, seed, near[k], &metric, blocked))
                continue;
            if (!make_room(g, count + 1))
                return 0;
            g->reached[count++] = (struct reached){ metric, near[k] };
        }
    }
    return count;
}

static int by_metric(const void *a, const void *b)
{
    const struct reached *p = a, *q = b;
    if (p->metric != q->metric)
        return p->metric < q->metric ? -1 : 1;
    return (p->site > q->site) - (p->site < q->site);
}

/* Does the ellipse that holds the first k sites hold much more than their own area? It has grown
 * over a border then. *least: the least that it held of other area yet. */
static bool is_sparse(const struct ellipse *e, const struct clip_track *track, double metric,
                      size_t k, double area, double *least)
{
    double scale = sqrt(metric), radius[2] = { scale * e->radius[0], scale * e->radius[1] };
    double sparse =
        (track->found.count ? clip_share(track, radius) : 1) * radius[0] * radius[1] / area;
    *least = fmin(*least, sparse);
    return sparse > *least * (OVERHANG + 1.5 / sqrt((double)k));
}

/* Nearest first, into member, the seed always; what lies beyond an obstacle, or a third edge, or
 * where the ellipse holds much more than the sites' own area (it has grown over a border), is left
 * out. */
static size_t sort_reached(struct grower *g, const struct ellipse *e, size_t count, double blocked)
{
    size_t kept = 0;
    struct clip_track track = { 0 };
    double area = 0, least = INFINITY;
    qsort(g->reached, count, sizeof *g->reached, by_metric);
    for (size_t k = 0; k < count && g->reached[k].metric < blocked; k++) {
        uint32_t site = g->reached[k].site;
        double spacing = (double)g->cloud->site[site].spacing;
        if (!clip_admits(g->cloud, &e->frame, site, g->limits->tolerance, &track))
            break;
        area += spacing * spacing;
        if (k >= RING && is_sparse(e, &track, g->reached[k].metric, k, area, &least))
            break;
        g->member[kept++] = site;
    }
    return kept;
}

/* --- how many of the nearest make a patch
 * ---------------------------------------------------------- */

static bool fits(const struct grower *g, size_t count, struct vec3 hint, struct patch_frame *frame)
{
    patch_plane(g->cloud, g->member, count, hint, frame);
    if (patch_deviation(g->cloud, g->member, count, frame) > g->limits->tolerance)
        return false;
    for (size_t k = 0; k < count; k++)
        if (v3_dot(site_normal(g->cloud, g->member[k], frame->n), frame->n) < STEEPEST)
            return false;
    return true;
}

/* The most of member[0..count) that fit, by bisection; the frame is theirs. */
static size_t longest_prefix(const struct grower *g, size_t count, struct vec3 hint,
                             struct patch_frame *frame)
{
    size_t good = 1, bad = count;
    if (fits(g, count, hint, frame))
        return count;
    while (bad - good > 1 + good / 16) {
        size_t middle = good + (bad - good) / 2;
        if (fits(g, middle, hint, frame))
            good = middle;
        else
            bad = middle;
    }
    patch_plane(g->cloud, g->member, good, hint, frame);
    return good;
}

/* --- one patch
 * --------------------------------------------------------------------------------------- */

static double clamp(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* Axes whose ends deviate alike, |bend| r^2: the ratio is the root of the curvatures'. */
static void shape_ellipse(struct ellipse *e, double scale)
{
    double a = fabs(e->frame.bend[0]), b = fabs(e->frame.bend[1]);
    double ratio = a + b > 0 ? sqrt(clamp(b / fmax(a, 1e-300), 1e-9, 1e9)) : 1;
    ratio = clamp(ratio, 1 / LONGEST, LONGEST);
    e->radius[0] = scale * sqrt(ratio);
    e->radius[1] = scale / sqrt(ratio);
}

/* The first frame, from the nearest sites whatever their distance. */
static double first_ellipse(struct grower *g, uint32_t seed, struct ellipse *e)
{
    const struct site *site = &g->cloud->site[seed];
    double blocked, spacing = site->spacing > 0 ? (double)site->spacing : 1;
    struct vec3 n = v3_unit(v3_loadf(site->n));
    e->frame = (struct patch_frame){ .n = v3_length(n) > 0 ? n : v3(0, 0, 1) };
    patch_plane(g->cloud, &seed, 1, e->frame.n, &e->frame);
    e->radius[0] = e->radius[1] = 4 * spacing;
    size_t count = collect(g, e, seed, RING, &blocked);
    for (size_t k = 0; k < count; k++)
        g->member[k] = g->reached[k].site;
    if (count >= 3)
        patch_plane(g->cloud, g->member, count, e->frame.n, &e->frame);
    if (count >= 5)
        patch_axes(g->cloud, g->member, count, &e->frame);
    e->frame.c = v3_load(site->p);
    double bend = fmax(fabs(e->frame.bend[0]), fabs(e->frame.bend[1]));
    double scale = bend > 0 ? sqrt(4 * g->limits->tolerance / bend) : 4 * spacing;
    return clamp(scale, spacing, 64 * spacing);
}

static void keep_patch(struct grower *g, uint32_t seed, size_t count,
                       const struct patch_frame *frame, double shape, struct patch *made)
{
    uint32_t *member = mem_alloc(count, sizeof *member);
    if (!member) {
        g->out_of_memory = true;
        return;
    }
    memcpy(member, g->member, count * sizeof *member);
    mem_free(made->member);
    *made = (struct patch){ *frame, shape, seed, (uint32_t)count, member };
}

/* Larger ellipses until one meets what stops it; then once more in the frame that was found. */
static void grow(struct grower *g, uint32_t seed, struct patch *made)
{
    struct ellipse e;
    double scale = first_ellipse(g, seed, &e), blocked;
    struct vec3 side = e.frame.n;
    bool refined = false;
    size_t before = 0;
    for (int round = 0; round < ROUNDS && !g->out_of_memory; round++) {
        struct patch_frame frame;
        shape_ellipse(&e, scale);
        size_t all = collect(g, &e, seed, SIZE_MAX, &blocked);
        if (all == 0)
            return;
        size_t kept = sort_reached(g, &e, all, blocked),
               count = longest_prefix(g, kept, side, &frame);
        patch_axes(g->cloud, g->member, count, &frame);
        if (count > made->count)
            keep_patch(g, seed, count, &frame, e.radius[0] / e.radius[1], made);
        bool stopped = count < all;
        if (stopped ? refined : all == before)
            return;
        refined = refined || stopped;
        before = all;
        double reach = stopped ? sqrt(fmax(g->reached[count - 1].metric, 0)) : GROWTH;
        scale *= stopped ? clamp(1.25 * reach, 0.25, 1.25) : GROWTH;
        e.frame = frame;
        e.frame.c = v3_load(g->cloud->site[seed].p);
    }
}

/* Fewer members, until the splat shows next to nothing beyond edges that its lines do not follow.
 */
static void trim(struct grower *g, struct patch *made)
{
    struct outline o;
    if (!g->cloud->crease || made->count < 2)
        return;
    memcpy(g->member, made->member, made->count * sizeof *made->member);
    patch_outline(g->cloud, made, &made->frame, g->limits->tolerance, g->room, &o);
    while (o.overhang > BEYOND && made->count > 1) {
        struct vec3 side = made->frame.n;
        bool good;
        do {
            made->count = (uint32_t)(TRIM * made->count);
            good = fits(g, made->count, side, &made->frame);
        } while (made->count > 1 && !good);
        patch_axes(g->cloud, g->member, made->count, &made->frame);
        patch_outline(g->cloud, made, &made->frame, g->limits->tolerance, g->room, &o);
    }
}

static void grow_range(void *context, size_t begin, size_t end, unsigned worker)
{
    struct grow_job *job = context;
    struct grower *g = &job->grower[worker];
    if (!g->stamp && !g->out_of_memory) {
        g->stamp = mem_zalloc(job->cloud->count, sizeof *g->stamp);
        g->out_of_memory = !g->stamp;
    }
    g->cloud = job->cloud;
    g->limits = job->limits;
    for (size_t i = begin; i < end && !g->out_of_memory; i++) {
        grow(g, job->seed[i], &job->made[i]);
        if (!g->out_of_memory)
            trim(g, &job->made[i]);
    }
}

enum stp_result patches_grow(const struct stp_env *env, const struct fit_cloud *cloud,
                             const struct fit_limits *limits, const uint32_t *seed, size_t count,
                             struct patch *made)
{
    unsigned workers = thread_count(env);
    bool failed = false;
    struct grow_job job = { cloud, limits, seed, made, mem_zalloc(workers, sizeof *job.grower) };
    if (!job.grower)
        return log_no_memory(env, workers * sizeof *job.grower, "growing patches");
    memset(made, 0, count * sizeof *made);
    parallel_for(env, count, 16, grow_range, &job);
    for (unsigned i = 0; i < workers; i++) {
        failed |= job.grower[i].out_of_memory;
        mem_free(job.grower[i].stamp);
        mem_free(job.grower[i].reached);
        mem_free(job.grower[i].member);
        mem_free(job.grower[i].room);
    }
    mem_free(job.grower);
    if (!failed)
        return STP_OK;
    patches_release(made, count);
    return log_no_memory(env, cloud->count * sizeof(uint32_t), "growing patches");
}

void patches_release(struct patch *patches, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        mem_free(patches[i].member);
        patches[i] = (struct patch){ 0 };
    }
}
