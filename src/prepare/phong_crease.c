/* The sites around one are split among two planes, or three, each plane then fitted to its sites,
 * until that settles (k-planes). Where the planes hold the sites far better than one plane does,
 * better than two could hold a bent sheet, there is an edge or a corner. */
#include "prepare/phong_crease.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_sides.h"

#define RUN        8         /* sites in Morton order that one of them is asked for first */
#define FLAT       0.02      /* deviation from one plane, in radii of the ball: there is no edge */
#define HOLDS      0.03      /* deviation from the planes, in radii of the ball */
#define BETTER     6.0       /* than one plane; two planes hold a bent sheet 4 times better */
#define BETTER_3   14.0      /* three planes hold a bent sheet 9 times better */
#define ALIKE      (1.0 / 6) /* of the angle between sides: a site's normal is its side's */
#define MOST_ALIKE 0.7       /* of the sites; of a bent sheet's, a third */
#define MAY        0.3       /* of the sites; fewer where it is noisy */
#define PERHAPS    3.0       /* worth a look at the run's other sites */
#define SHARP      0.94      /* cosine, 20 degrees, between sides */
#define TURNS      0.96      /* cosine, 16 degrees: half a blunt edge's and more */
#define GRAIN      256

static double angle_between(struct vec3 a, struct vec3 b)
{
    return acos(fmin(fabs(v3_dot(a, b)), 1));
}

/* Do most sites have their side's normal? On a bent sheet the normals turn all the way. */
static bool have_sides_normals(const struct fit_cloud *cloud, const struct ball *b,
                               const struct sides *s)
{
    double least = INFINITY;
    unsigned alike = 0, asked = 0;
    for (unsigned i = 0; i < s->count; i++)
        for (unsigned j = 0; j < i; j++)
            least = fmin(least, angle_between(s->plane[i].n, s->plane[j].n));
    for (unsigned k = 0; k < b->count; k++) {
        struct vec3 n = v3_loadf(cloud->site[b->site[k]].n);
        double near = 0.5 * (double)cloud->site[b->site[k]].spacing;
        unsigned sides = 0;
        for (unsigned i = 0; i < s->count; i++)
            sides += off_plane(&s->plane[i], b->p[k]) < near;
        if (sides > 1) /* on the edge: a mean of both sides' normals is what meshes have there */
            continue;
        asked++;
        alike += angle_between(n, s->plane[b->side[k]].n) < ALIKE * least;
    }
    return asked > 0 && alike >= MOST_ALIKE * asked;
}

/* The same of the two normals that differ most, before any plane is fitted: at a corner of three
 * they are two thirds of the sites' normals. */
static bool may_have_sides(const struct fit_cloud *cloud, const struct ball *b)
{
    struct vec3 n[2] = { v3_loadf(cloud->site[b->site[0]].n) };
    n[0] = v3_loadf(cloud->site[b->site[ball_most_unlike(cloud, b, n, 1)]].n);
    n[1] = v3_loadf(cloud->site[b->site[ball_most_unlike(cloud, b, n, 1)]].n);
    double least = cos(ALIKE * angle_between(n[0], n[1]));
    unsigned alike = 0;
    for (unsigned k = 0; k < b->count; k++) {
        struct vec3 own = v3_loadf(cloud->site[b->site[k]].n);
        alike += fabs(v3_dot(own, n[0])) > least || fabs(v3_dot(own, n[1])) > least;
    }
    return alike >= MAY * b->count;
}

static bool are_sharp(const struct sides *s)
{
    for (unsigned i = 0; i < s->count; i++)
        for (unsigned j = 0; j < i; j++)
            if (fabs(v3_dot(s->plane[i].n, s->plane[j].n)) > SHARP)
                return false;
    return true;
}

/* 2: an edge or a corner; 1: nearly; 0: neither. */
static int look(const struct fit_cloud *cloud, uint32_t i, struct ball *b, struct sides *s)
{
    struct fit_plane one;
    int best = 0;
    ball_gather(cloud, i, b);
    if (b->count < 2 * SIDE_FEWEST || !may_have_sides(cloud, b) ||
        !side_fit(b, MOST_SIDES, &one, &s->one) || s->one < FLAT * b->radius)
        return 0;
    for (unsigned count = 2; count <= MOST_SIDES; count++) {
        if (!sides_split(cloud, b, count, s) || !are_sharp(s))
            continue;
        if (s->all * (count == 2 ? BETTER : BETTER_3) < s->one && s->all < HOLDS * b->radius &&
            have_sides_normals(cloud, b, s))
            return 2;
        if (s->all * PERHAPS < s->one)
            best = 1;
    }
    return best;
}

/* Its own side: the nearest plane, and of planes as near (it is on the edge) that of the likest
 * normal. */
static unsigned own_side(const struct fit_cloud *cloud, const struct ball *b, const struct sides *s)
{
    struct vec3 n = v3_loadf(cloud->site[b->site[0]].n);
    double slack = 0.05 * b->radius + off_plane(&s->plane[b->side[0]], b->p[0]);
    unsigned best = b->side[0];
    for (unsigned i = 0; i < s->count; i++)
        if (off_plane(&s->plane[i], b->p[0]) <= slack &&
            fabs(v3_dot(s->plane[i].n, n)) > fabs(v3_dot(s->plane[best].n, n)))
            best = i;
    return best;
}

/* Turned to where the side's normals look. */
static void turn_plane(const struct fit_cloud *cloud, const struct ball *b, unsigned side,
                       struct fit_plane *plane)
{
    double sum = 0;
    for (unsigned k = 0; k < b->count; k++)
        if (b->side[k] == side)
            sum += v3_dot(v3_loadf(cloud->site[b->site[k]].n), plane->n);
    if (sum < 0)
        *plane = (struct fit_plane){ v3_scale(plane->n, -1), -plane->d };
}

/* A curved side's normals may differ from its plane's by what its deviation shows; others are
 * mixtures of two sides', and give way to the plane's. */
static void sharpen(const struct site *site, const struct fit_plane *own, double bent, float n[3])
{
    struct vec3 given = v3_loadf(site->n), plane = own->n;
    double dot = v3_dot(given, plane);
    double least = cos(fmin(fmax(5 * bent, 0.01), 0.2));
    if (dot < 0) {
        dot = -dot;
        plane = v3_scale(plane, -1);
    }
    struct vec3 sharp = dot >= least ? given : plane;
    v3_storef(sharp, n);
}

struct finding {
    uint32_t site;
    bool found;
    float n[3];
    struct crease crease;
};

static void study(const struct fit_cloud *cloud, struct finding *f)
{
    struct ball b;
    struct sides s;
    if (look(cloud, f->site, &b, &s) != 2)
        return;
    unsigned own = own_side(cloud, &b, &s);
    struct vec3 middle = v3_load(cloud->site[f->site].p);
    f->found = true;
    for (unsigned i = 0; i < s.count; i++)
        turn_plane(cloud, &b, i, &s.plane[i]);
    sharpen(&cloud->site[f->site], &s.plane[own], s.deviation[own] / b.radius, f->n);
    for (unsigned i = 0; i < s.count; i++) {
        if (i == own)
            continue;
        struct fit_plane plane = s.plane[i];
        plane.d -= v3_dot(plane.n, middle);
        f->crease.side[f->crease.sides++] = plane;
    }
}

struct crease_job {
    struct fit_cloud *cloud;
    uint8_t *run; /* its sites are to be looked at */
    struct finding *finding;
    uint32_t *lent; /* a site: the crease of a neighbour; NO_SITE: none */
};

/* A look costs: only where some normal near the run turns as far as between the sides of an edge.
 */
static bool normals_turn(const struct fit_cloud *cloud, size_t begin, size_t middle)
{
    struct vec3 n = v3_loadf(cloud->site[middle].n);
    for (size_t i = begin; i < begin + RUN && i < cloud->count; i++)
        for (unsigned k = 0; k < SITE_NEAR; k++) {
            uint32_t j = cloud->near[i][k];
            double dot = j == NO_SITE ? 1 : v3_dot(n, v3_loadf(cloud->site[j].n));
            if ((cloud->signs ? dot : fabs(dot)) < TURNS)
                return true;
        }
    return false;
}

static void run_range(void *context, size_t begin, size_t end, unsigned)
{
    struct crease_job *job = context;
    for (size_t i = begin; i < end; i++) {
        struct ball b;
        struct sides s;
        size_t middle = i * RUN + RUN / 2;
        middle = middle < job->cloud->count ? middle : job->cloud->count - 1;
        job->run[i] = normals_turn(job->cloud, i * RUN, middle) &&
                      look(job->cloud, (uint32_t)middle, &b, &s) > 0;
    }
}

static void study_range(void *context, size_t begin, size_t end, unsigned)
{
    struct crease_job *job = context;
    for (size_t i = begin; i < end; i++)
        study(job->cloud, &job->finding[i]);
}

/* A site that was not found to be at an edge, for there noise had the say, though most neighbours
 * of its side were, is at that of the nearest of them. */
static uint32_t lent_crease(const struct fit_cloud *cloud, size_t i)
{
    uint32_t lent = NO_SITE;
    unsigned alike = 0, found = 0;
    for (unsigned k = 0; k < SITE_NEAR; k++) {
        uint32_t j = cloud->near[i][k];
        double dot =
            j == NO_SITE ? 0 : v3_dot(v3_loadf(cloud->site[i].n), v3_loadf(cloud->site[j].n));
        if ((cloud->signs ? dot : fabs(dot)) < SHARP)
            continue;
        alike++;
        found += cloud->crease_of[j] != NO_SITE;
        lent = lent == NO_SITE ? cloud->crease_of[j] : lent;
    }
    return found >= 2 ? lent : NO_SITE;
}

static void lend_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct crease_job *job = context;
    for (size_t i = begin; i < end; i++)
        job->lent[i] = job->cloud->crease_of[i] == NO_SITE ? lent_crease(job->cloud, i) : NO_SITE;
}

/* Neighbours across an edge part. */
static void cut_range(void *context, size_t begin, size_t end, unsigned)
{
    struct fit_cloud *cloud = ((struct crease_job *)context)->cloud;
    for (size_t i = begin; i < end; i++)
        for (unsigned k = 0; k < SITE_NEAR; k++) {
            uint32_t j = cloud->near[i][k];
            if (j == NO_SITE || (cloud->crease_of[i] == NO_SITE && cloud->crease_of[j] == NO_SITE))
                continue;
            double dot = v3_dot(v3_loadf(cloud->site[i].n), v3_loadf(cloud->site[j].n));
            if ((cloud->signs ? dot : fabs(dot)) < SHARP)
                cloud->near[i][k] = NO_SITE;
        }
}

static enum stp_result keep_findings(const struct stp_env *env, struct crease_job *job,
                                     size_t count, size_t found)
{
    struct fit_cloud *cloud = job->cloud;
    cloud->crease = mem_alloc(found, sizeof *cloud->crease);
    cloud->crease_of = mem_alloc(cloud->count, sizeof *cloud->crease_of);
    if (!cloud->crease || !cloud->crease_of)
        return log_no_memory(env, found * sizeof *cloud->crease, "sharp features");
    memset(cloud->crease_of, 0xff, cloud->count * sizeof *cloud->crease_of);
    uint32_t at = 0;
    for (size_t i = 0; i < count; i++) {
        struct finding *f = &job->finding[i];
        if (!f->found)
            continue;
        memcpy(cloud->site[f->site].n, f->n, sizeof f->n);
        cloud->crease_of[f->site] = at;
        cloud->crease[at++] = f->crease;
    }
    job->lent = mem_alloc(cloud->count, sizeof *job->lent);
    if (!job->lent)
        return log_no_memory(env, cloud->count * sizeof *job->lent, "sharp features");
    parallel_for(env, cloud->count, 4096, lend_range, job);
    for (size_t i = 0; i < cloud->count; i++)
        cloud->crease_of[i] = job->lent[i] != NO_SITE ? job->lent[i] : cloud->crease_of[i];
    mem_free(job->lent);
    parallel_for(env, cloud->count, 4096, cut_range, job);
    return STP_OK;
}

static enum stp_result study_runs(const struct stp_env *env, struct crease_job *job, size_t runs)
{
    size_t count = 0, found = 0;
    for (size_t i = 0; i < runs; i++)
        count += job->run[i] ? RUN : 0;
    if (count == 0)
        return STP_OK;
    job->finding = mem_zalloc(count, sizeof *job->finding);
    if (!job->finding)
        return log_no_memory(env, count * sizeof *job->finding, "sharp features");
    count = 0;
    for (size_t i = 0; i < job->cloud->count; i++)
        if (job->run[i / RUN])
            job->finding[count++].site = (uint32_t)i;
    parallel_for(env, count, GRAIN, study_range, job);
    for (size_t i = 0; i < count; i++)
        found += job->finding[i].found;
    enum stp_result result = found > 0 ? keep_findings(env, job, count, found) : STP_OK;
    mem_free(job->finding);
    return result;
}

enum stp_result creases_find(const struct stp_env *env, struct fit_cloud *cloud)
{
    size_t runs = (cloud->count + RUN - 1) / RUN;
    struct crease_job job = { .cloud = cloud, .run = mem_alloc(runs, sizeof *job.run) };
    if (!job.run)
        return log_no_memory(env, runs, "sharp features");
    parallel_for(env, runs, GRAIN / RUN, run_range, &job);
    enum stp_result result = study_runs(env, &job, runs);
    mem_free(job.run);
    return result;
}
