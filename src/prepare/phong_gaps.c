#include "prepare/phong_gaps.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_clip.h"
#include "prepare/phong_face.h"
#include "prepare/phong_holders.h"

#define GRAIN  512
#define AROUND 16      /* splats looked at about a site */
#define MARGIN 0.5     /* of its distance from the samples: a corner is inside by so much */
#define MOST   2.0     /* times a splat's radii may grow */
#define UNIT   0x1p-28 /* of growth: the largest of integers does not depend on their order */

struct gaps {
    const struct fit_cloud *cloud;
    const struct patch_set *set;
    const struct splats *splats;
    struct holders holders;
    double depth;
    _Atomic uint32_t *growth; /* a splat */
};

/* The splats about a site. */
struct around {
    unsigned count;
    uint32_t splat[AROUND];
    struct face face[AROUND];
};

/* The point in the plane of 0, a and b that is as far from each; false: they are on a line. */
static bool circumcentre(struct vec3 a, struct vec3 b, struct vec3 *c)
{
    struct vec3 n = v3_cross(a, b);
    double aa = v3_dot(a, a), bb = v3_dot(b, b), nn = v3_dot(n, n);
    if (!(nn > 1e-6 * aa * bb))
        return false;
    *c = v3_scale(v3_add(v3_scale(v3_cross(b, n), aa), v3_scale(v3_cross(n, a), bb)), 0.5 / nn);
    return true;
}

/* Corners of the cell of a site, from its place. */
struct corners {
    unsigned count;
    struct vec3 at[SITE_NEAR * (SITE_NEAR - 1) / 2];
};

static bool is_empty(const struct vec3 *near, unsigned count, struct vec3 c)
{
    double least = v3_dot(c, c) * (1 - 1e-9);
    for (unsigned k = 0; k < count; k++) {
        struct vec3 d = v3_sub(near[k], c);
        if (v3_dot(d, d) < least)
            return false;
    }
    return true;
}

/* reach: of the site's own disc. */
static void find_corners(const struct fit_cloud *cloud, uint32_t i, double reach,
                         struct corners *corners)
{
    struct vec3 near[SITE_NEAR], p = v3_load(cloud->site[i].p), c;
    unsigned count = 0;
    for (unsigned k = 0; k < SITE_NEAR; k++)
        if (cloud->near[i][k] != NO_SITE)
            near[count++] = v3_sub(v3_load(cloud->site[cloud->near[i][k]].p), p);
    corners->count = 0;
    for (unsigned a = 1; a < count; a++)
        for (unsigned b = 0; b < a; b++)
            if (circumcentre(near[a], near[b], &c) && v3_dot(c, c) <= reach * reach &&
                is_empty(near, count, c))
                corners->at[corners->count++] = c;
}

/* The splats of a site's holders that are not there yet. */
static void add_holders(const struct gaps *g, uint32_t site, struct around *all)
{
    const struct holders *h = &g->holders;
    for (size_t i = h->begin[site]; i < h->begin[site + 1] && all->count < AROUND; i++) {
        unsigned k = 0;
        while (k < all->count && all->splat[k] != h->patch[i])
            k++;
        if (k == all->count)
            all->splat[all->count++] = h->patch[i];
    }
}

static bool holds(const struct holders *h, uint32_t site, uint32_t patch)
{
    for (size_t i = h->begin[site]; i < h->begin[site + 1]; i++)
        if (h->patch[i] == patch)
            return true;
    return false;
}

/* Does one splat hold the site and all its neighbours? It is convex, and there is no gap. */
static bool is_inside(const struct gaps *g, uint32_t i)
{
    const struct holders *h = &g->holders;
    for (size_t k = h->begin[i]; k < h->begin[i + 1]; k++) {
        bool all = !g->splats->phong[h->patch[k]].reflex;
        for (unsigned n = 0; n < SITE_NEAR && all; n++)
            all = g->cloud->near[i][n] == NO_SITE || holds(h, g->cloud->near[i][n], h->patch[k]);
        if (all)
            return true;
    }
    return false;
}

static void look_around(const struct gaps *g, uint32_t i, struct around *all)
{
    all->count = 0;
    add_holders(g, i, all);
    for (unsigned n = 0; n < SITE_NEAR; n++)
        if (g->cloud->near[i][n] != NO_SITE)
            add_holders(g, g->cloud->near[i][n], all);
    for (unsigned k = 0; k < all->count; k++)
        all->face[k] = face_of(g->splats, all->splat[k], g->cloud->origin);
}

/* What splat k must grow to, of its size, to hold p with the margin; 0: it reaches as far (p
 * itself may lie `away` farther off its plane than it shows: a splat that holds one of p's samples,
 * within `depth` of its plane, tilts no farther off over that way, which is less than the sample's
 * own radius; one that lies deeper shows another part of the surface); INFINITY: it cannot. away:
 * of p from its samples. *more: by what length. */
static double growth_for(const struct gaps *g, const struct around *all, unsigned k, struct vec3 p,
                         double away, double *more)
{
    const struct face *f = &all->face[k];
    struct on_face at = face_place(f, p);
    double rho = sqrt(at.s * at.s + at.t * at.t), height = fabs(at.height);
    if (height > g->depth + away || !face_keeps(f, at))
        return INFINITY;
    double length = hypot(at.s * (double)f->phong.radius[0], at.t * (double)f->phong.radius[1]);
    double growth = length > 0 ? rho * (length + MARGIN * away) / length : 0;
    if (growth <= 1)
        return 0;
    *more = length / rho * (growth - 1);
    return height <= g->depth ? growth : INFINITY;
}

static void grow_to(struct gaps *g, uint32_t splat, double growth)
{
    uint32_t wanted = (uint32_t)ceil((growth - 1) / UNIT), now = g->growth[splat];
    while (now < wanted && !atomic_compare_exchange_weak(&g->growth[splat], &now, wanted))
        ;
}

/* A single sample's disc stays as it is, and what lies at edges ends where they are. */
static bool may_grow(const struct gaps *g, uint32_t splat)
{
    const struct patch *p = &g->set->patch[splat];
    return p->count > 1 && !patch_is_at_edges(g->cloud, p);
}

static void close_corner(struct gaps *g, const struct around *all, struct vec3 p, double margin)
{
    double least = INFINITY, wanted = 1;
    unsigned best = AROUND;
    for (unsigned k = 0; k < all->count; k++) {
        double more = 0, growth = growth_for(g, all, k, p, margin, &more);
        if (growth == 0)
            return;
        bool less =
            more < least || (more == least && best < AROUND && all->splat[k] < all->splat[best]);
        if (growth <= MOST && less && may_grow(g, all->splat[k])) {
            least = more;
            wanted = growth;
            best = k;
        }
    }
    if (best < AROUND)
        grow_to(g, all->splat[best], wanted);
}

static void close_range(void *context, size_t begin, size_t end, unsigned)
{
    struct gaps *g = context;
    struct around all;
    struct corners corners;
    for (size_t i = begin; i < end; i++) {
        uint32_t site = (uint32_t)i;
        if (is_inside(g, site))
            continue;
        struct vec3 p = v3_load(g->cloud->site[i].p);
        find_corners(g->cloud, site, (double)g->cloud->samples->radius[g->cloud->first[i]],
                     &corners);
        if (corners.count > 0)
            look_around(g, site, &all);
        for (unsigned k = 0; k < corners.count; k++)
            close_corner(g, &all, v3_add(p, corners.at[k]), v3_length(corners.at[k]));
    }
}

/* The plane, the field and the lines stay; they are said in parts of the radii. */
static void enlarge(struct splats *splats, size_t at, double growth)
{
    struct stp_phong_splat *phong = &splats->phong[at];
    for (int i = 0; i < 2; i++) {
        double radius = growth * (double)phong->radius[i];
        phong->radius[i] = nextafterf((float)radius, INFINITY);
        phong->field[2 * i + 1] = (float)(growth * (double)phong->field[2 * i + 1]);
    }
    for (unsigned i = 0; i < phong->clips; i++) {
        float *line = phong->clip[i];
        for (int k = 0; k < 2; k++)
            line[k] = (float)(growth * (double)line[k]);
        line[2] = nextafterf(line[2] + FLT_EPSILON * (fabsf(line[0]) + fabsf(line[1])), INFINITY);
    }
    splats->radius[at] = fmaxf(phong->radius[0], phong->radius[1]);
}

enum stp_result gaps_close(const struct stp_env *env, const struct fit_cloud *cloud,
                           const struct patch_set *set, double depth, struct splats *splats)
{
    struct gaps g = { .cloud = cloud,
                      .set = set,
                      .splats = splats,
                      .depth = depth,
                      .growth = mem_zalloc(set->count, sizeof *g.growth) };
    enum stp_result result =
        g.growth ? holders_find(env, cloud, set, &g.holders)
                 : log_no_memory(env, set->count * sizeof *g.growth, "the gaps between splats");
    if (result == STP_OK) {
        parallel_for(env, cloud->count, GRAIN, close_range, &g);
        for (size_t i = 0; i < set->count; i++)
            if (g.growth[i] > 0)
                enlarge(splats, i, 1 + UNIT * g.growth[i]);
    }
    holders_release(&g.holders);
    mem_free(g.growth);
    return result;
}
