/* Patches grown from seeds over neighbours, as far as the tolerance lets them: an ellipse in the
 * seed's tangent plane, its axes those of curvature, is scaled until a site that it reaches is off
 * the least-squares plane of those nearer than it. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_outline.h"
#include "prepare/phong_fit.h"
#include "prepare/phong_reach.h"

#define RING     24  /* sites that the first frame is estimated from */
#define LONGEST  3.0 /* ratio of the axes */
#define STEEPEST 0.1 /* the same to the plane that was fitted, 84 degrees */
#define ROUNDS   10
#define OVERHANG                                                                                   \
    1.2             /* of the ellipse over the sites' own area, against where they were densest    \
                     */
#define GROWTH 1.6  /* of the radius where nothing was in the way */
#define BEYOND 0.5  /* squares of the spacing: a splat may show so much beyond an edge */
#define TRIM   0.75 /* of its members a patch keeps that shows more */

/* A member, and what the plane of it and of those before is made of. */
struct admitted {
    struct vec3 p, n;
    struct plane_sums sums;
};

struct grower {
    const struct fit_cloud *cloud;
    const struct fit_limits *limits;
    struct reach reach;
    uint32_t *member;
    struct admitted *admitted;
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

static bool make_room(struct grower *g, size_t count)
{
    if (count <= g->capacity)
        return true;
    size_t capacity = count > 256 ? 2 * count : 256;
    uint32_t *member = mem_realloc(g->member, capacity, sizeof *member);
    g->member = member ? member : g->member;
    struct admitted *admitted = mem_realloc(g->admitted, capacity, sizeof *admitted);
    g->admitted = admitted ? admitted : g->admitted;
    double(*room)[2] = mem_realloc(g->room, 4 * capacity, sizeof *room);
    g->room = room ? room : g->room;
    if (!member || !admitted || !room)
        return false;
    g->capacity = capacity;
    return true;
}

/* Sites that the ellipse reaches, of which there is room for that many members; 0: no memory. */
static size_t collect(struct grower *g, const struct ellipse *e, uint32_t seed, size_t most,
                      double *blocked)
{
    size_t count = reach_collect(&g->reach, e, seed, most, blocked);
    g->out_of_memory |= count == 0 || !make_room(g, count);
    return g->out_of_memory ? 0 : count;
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

/* The k-th member. hint: the side of the normals. */
static void admit(struct grower *g, size_t k, uint32_t site, struct vec3 hint)
{
    struct admitted *a = &g->admitted[k];
    a->p = v3_load(g->cloud->site[site].p);
    a->n = v3_loadf(g->cloud->site[site].n);
    a->sums = k > 0 ? a[-1].sums : (struct plane_sums){ 0 };
    plane_sums_add(&a->sums, v3_sub(a->p, g->admitted[0].p), site_normal(g->cloud, site, hint));
    g->member[k] = site;
}

/* Nearest first, the seed always; what lies beyond an obstacle, or a third edge, or where the
 * ellipse holds much more than the sites' own area (it has grown over a border), is left out. */
static size_t admit_reached(struct grower *g, const struct ellipse *e, size_t count, double blocked,
                            struct vec3 hint)
{
    size_t kept = 0;
    struct clip_track track = { 0 };
    double area = 0, least = INFINITY;
    count = reach_sort(&g->reach, count, blocked);
    for (size_t k = 0; k < count; k++) {
        const struct reached *reached = &g->reach.list[k];
        uint32_t site = reached->site;
        double spacing = (double)g->cloud->site[site].spacing;
        if (!clip_admits(g->cloud, &e->frame, site, g->limits->tolerance, &track))
            break;
        area += spacing * spacing;
        if (k >= RING && is_sparse(e, &track, reached->metric, k, area, &least))
            break;
        admit(g, kept++, site, hint);
    }
    return kept;
}

/* Within the tolerance of the frame's plane, and not too steep to it? The farthest come first: they
 * are the likeliest not to be. */
static bool all_within(const struct grower *g, size_t count, const struct patch_frame *f)
{
    double offset = v3_dot(f->c, f->n);
    for (size_t k = count; k-- > 0;) {
        const struct admitted *a = &g->admitted[k];
        if (fabs(v3_dot(a->p, f->n) - offset) > g->limits->tolerance)
            return false;
        double dot = v3_dot(a->n, f->n);
        if ((g->cloud->signs ? dot : fabs(dot)) < STEEPEST && v3_dot(a->n, a->n) > 0)
            return false;
    }
    return true;
}

static bool fits(const struct grower *g, size_t count, struct vec3 hint, struct patch_frame *frame)
{
    plane_of_sums(&g->admitted[count - 1].sums, g->admitted[0].p, hint, frame);
    return all_within(g, count, frame);
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
    plane_of_sums(&g->admitted[good - 1].sums, g->admitted[0].p, hint, frame);
    return good;
}

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
        g->member[k] = g->reach.list[k].site;
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
        size_t kept = admit_reached(g, &e, all, blocked, side),
               count = longest_prefix(g, kept, side, &frame);
        patch_axes(g->cloud, g->member, count, &frame);
        if (count > made->count)
            keep_patch(g, seed, count, &frame, e.radius[0] / e.radius[1], made);
        bool stopped = count < all;
        if (stopped ? refined : all == before)
            return;
        refined = refined || stopped;
        before = all;
        double reach = stopped ? sqrt(fmax(g->reach.list[count - 1].metric, 0)) : GROWTH;
        scale *= stopped ? clamp(1.25 * reach, 0.25, 1.25) : GROWTH;
        e.frame = frame;
        e.frame.c = v3_load(g->cloud->site[seed].p);
    }
}

/* The most members, of TRIM of them and TRIM of those, that have a plane. */
static void trim_once(struct grower *g, struct patch *made)
{
    struct vec3 side = made->frame.n;
    bool good;
    for (uint32_t k = 0; k < made->count; k++)
        admit(g, k, made->member[k], side);
    do {
        made->count = (uint32_t)(TRIM * made->count);
        good = fits(g, made->count, side, &made->frame);
    } while (made->count > 1 && !good);
    patch_axes(g->cloud, made->member, made->count, &made->frame);
}

/* Fewer members, until the splat shows next to nothing beyond edges that its lines do not follow.
 */
static void trim(struct grower *g, struct patch *made)
{
    struct outline o;
    if (made->count < 2 || !patch_is_at_edges(g->cloud, made))
        return;
    patch_outline(g->cloud, made, &made->frame, g->limits->tolerance, g->room, &o);
    while (o.overhang > BEYOND && made->count > 1) {
        trim_once(g, made);
        patch_outline(g->cloud, made, &made->frame, g->limits->tolerance, g->room, &o);
    }
}

static void grow_range(void *context, size_t begin, size_t end, unsigned worker)
{
    struct grow_job *job = context;
    struct grower *g = &job->grower[worker];
    if (!g->reach.stamp && !g->out_of_memory)
        g->out_of_memory = reach_open(&g->reach, job->cloud, job->limits) != STP_OK;
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
        reach_release(&job.grower[i].reach);
        mem_free(job.grower[i].member);
        mem_free(job.grower[i].admitted);
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
