/* The samples as sites, and which sites are neighbours on one side of the surface. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/neighbours.h"
#include "prepare/phong_fit.h"
#include "prepare/places.h"

#define ONE_SIDE   0.5  /* cosine: samples of a place beyond it are different sides */
#define OTHER_SIDE -0.5 /* below, they are two sides of a sheet, not of an edge */
#define GRAIN      1024
/* Signs are not to be trusted where more pairs of near samples than this are opposed, */
#define MOST_OPPOSED 0.25
/* unless the opposed ones are another sheet: this many times as far off each other's planes. */
#define OTHER_SHEET 4.0

struct sites_build {
    const struct splats *samples;
    struct fit_cloud *cloud;
    struct places places;
    struct neighbour_tree tree;
    uint32_t *first;                /* place -> its first site; count + 1 */
    uint32_t (*nearest)[SITE_NEAR]; /* place -> places */
    double (*signs)[4];             /* a block: pairs agreeing, their offsets, opposed, theirs */
};

static void compare_signs(const struct sites_build *b, size_t place, const struct neighbours *n,
                          double sum[4])
{
    const struct splats *s = b->samples;
    struct vec3 own = v3_loadf(s->normal[splat_of(&b->places, place)]);
    struct vec3 p = v3_load(b->places.position[place]);
    for (unsigned k = 0; k < n->count && k < 3; k++) {
        struct vec3 other = v3_loadf(s->normal[splat_of(&b->places, n->id[k])]);
        struct vec3 d = v3_sub(v3_load(b->places.position[n->id[k]]), p);
        double dot = v3_dot(own, other), length = v3_length(d);
        if (fabs(dot) < ONE_SIDE || !(length > 0))
            continue;
        sum[dot < 0 ? 2 : 0] += 1;
        sum[dot < 0 ? 3 : 1] += fabs(v3_dot(own, d)) / length;
    }
}

static void nearest_range(void *context, size_t begin, size_t end, unsigned)
{
    struct sites_build *b = context;
    for (size_t i = begin; i < end; i++) {
        struct neighbours n;
        neighbours_of(&b->tree, i, SITE_NEAR, &n);
        for (unsigned k = 0; k < SITE_NEAR; k++)
            b->nearest[i][k] = k < n.count ? n.id[k] : NO_SITE;
        compare_signs(b, i, &n, b->signs[begin / GRAIN]);
    }
}

static enum stp_result find_nearest(const struct stp_env *env, struct sites_build *b)
{
    size_t count = b->places.count, blocks = (count + GRAIN - 1) / GRAIN;
    double sum[4] = { 0 };
    enum stp_result result = neighbour_tree_build(env, b->places.position, count, &b->tree);
    if (result != STP_OK)
        return result;
    b->nearest = mem_alloc(count, sizeof *b->nearest);
    b->signs = mem_zalloc(blocks, sizeof *b->signs);
    if (!b->nearest || !b->signs)
        return log_no_memory(env, count * sizeof *b->nearest, "the samples' neighbours");
    parallel_for(env, count, GRAIN, nearest_range, b);
    for (size_t block = 0; block < blocks; block++)
        for (int i = 0; i < 4; i++)
            sum[i] += b->signs[block][i];
    double agreeing = sum[0] > 0 ? sum[1] / sum[0] : 0, opposed = sum[2] > 0 ? sum[3] / sum[2] : 0;
    b->cloud->signs =
        sum[2] <= MOST_OPPOSED * (sum[0] + sum[2]) || opposed > OTHER_SHEET * agreeing;
    return STP_OK;
}

static bool same_site(const struct sites_build *b, size_t a, size_t i)
{
    const struct splats *s = b->samples;
    double dot = v3_dot(v3_loadf(s->normal[a]), v3_loadf(s->normal[i]));
    if (s->object && s->object[a] != s->object[i])
        return false;
    if (v3_length(v3_loadf(s->normal[a])) == 0)
        return true;
    return (b->cloud->signs ? dot : fabs(dot)) > ONE_SIDE;
}

/* The samples of a place, [begin, end), run by run in canonical order: normals are sorted, so one
 * side's samples mostly lie together. Returns how many runs; writes them where `first` is given. */
static uint32_t cut_place(const struct sites_build *b, size_t begin, size_t end, bool join,
                          uint32_t *first)
{
    uint32_t runs = 0;
    size_t start = begin;
    for (size_t i = begin; i < end; i++) {
        if (i > begin && join && same_site(b, start, i))
            continue;
        start = i;
        if (first)
            first[runs] = (uint32_t)i;
        runs++;
    }
    return runs;
}

static enum stp_result cut_sites(const struct stp_env *env, struct sites_build *b, bool join)
{
    struct fit_cloud *cloud = b->cloud;
    size_t places = b->places.count, samples = b->samples->count;
    b->first = mem_alloc(places + 1, sizeof *b->first);
    if (!b->first)
        return log_no_memory(env, places * sizeof *b->first, "sites");
    uint32_t count = 0;
    for (size_t i = 0; i < places; i++) {
        size_t end = i + 1 < places ? splat_of(&b->places, i + 1) : samples;
        b->first[i] = count;
        count += cut_place(b, splat_of(&b->places, i), end, join, NULL);
    }
    b->first[places] = count;
    cloud->count = count;
    cloud->first = mem_alloc((size_t)count + 1, sizeof *cloud->first);
    cloud->site = mem_alloc(count, sizeof *cloud->site);
    cloud->near = mem_alloc(count, sizeof *cloud->near);
    if (!cloud->first || !cloud->site || !cloud->near)
        return log_no_memory(env, count * sizeof *cloud->site, "sites");
    for (size_t i = 0; i < places; i++) {
        size_t end = i + 1 < places ? splat_of(&b->places, i + 1) : samples;
        cut_place(b, splat_of(&b->places, i), end, join, cloud->first + b->first[i]);
    }
    cloud->first[count] = (uint32_t)samples;
    return STP_OK;
}

/* Of the sites of a place, the one whose side is that of sample a; NO_SITE: none is. */
static uint32_t site_on_side(const struct sites_build *b, uint32_t a, uint32_t place)
{
    const struct fit_cloud *cloud = b->cloud;
    const struct splats *s = b->samples;
    struct vec3 own = v3_loadf(s->normal[a]);
    uint32_t best = NO_SITE;
    double most = -INFINITY;
    for (uint32_t i = b->first[place]; i < b->first[place + 1]; i++) {
        uint32_t sample = cloud->first[i];
        struct vec3 n = v3_loadf(s->normal[sample]);
        double dot = v3_dot(own, n);
        bool known = v3_length(own) > 0 && v3_length(n) > 0;
        dot = !known ? 0.5 : cloud->signs ? dot : fabs(dot);
        if (dot <= OTHER_SIDE || dot <= most || (s->object && s->object[a] != s->object[sample]))
            continue;
        most = dot;
        best = i;
    }
    return best;
}

static float spacing_of(const struct sites_build *b, size_t place)
{
    double far = 0;
    for (unsigned k = 0; k < SPACING_RANK && b->nearest[place][k] != NO_SITE; k++)
        far = v3_length(v3_sub(v3_load(b->places.position[b->nearest[place][k]]),
                               v3_load(b->places.position[place])));
    return (float)far;
}

static void fill_range(void *context, size_t begin, size_t end, unsigned)
{
    struct sites_build *b = context;
    struct fit_cloud *cloud = b->cloud;
    for (size_t place = begin; place < end; place++) {
        float spacing = spacing_of(b, place);
        for (uint32_t i = b->first[place]; i < b->first[place + 1]; i++) {
            struct site *site = &cloud->site[i];
            for (int axis = 0; axis < 3; axis++)
                site->p[axis] = b->places.position[place][axis] - cloud->origin[axis];
            memcpy(site->n, b->samples->normal[cloud->first[i]], sizeof site->n);
            site->spacing = spacing;
            for (unsigned k = 0; k < SITE_NEAR; k++) {
                uint32_t other = b->nearest[place][k];
                cloud->near[i][k] =
                    other == NO_SITE ? NO_SITE : site_on_side(b, cloud->first[i], other);
            }
        }
    }
}

enum stp_result fit_cloud_build(const struct stp_env *env, const struct splats *samples, bool join,
                                struct fit_cloud *cloud)
{
    struct fit_cloud made = { .samples = samples };
    struct sites_build b = { .samples = samples, .cloud = &made };
    memcpy(made.origin, samples->position[0], sizeof made.origin);
    enum stp_result result = places_find(env, samples, &b.places);
    if (result == STP_OK)
        result = find_nearest(env, &b);
    if (result == STP_OK)
        result = cut_sites(env, &b, join);
    if (result == STP_OK)
        parallel_for(env, b.places.count, GRAIN, fill_range, &b);
    neighbour_tree_release(&b.tree);
    places_release(&b.places);
    mem_free(b.first);
    mem_free(b.nearest);
    mem_free(b.signs);
    if (result != STP_OK)
        fit_cloud_release(&made);
    else
        *cloud = made;
    return result;
}

void fit_cloud_release(struct fit_cloud *cloud)
{
    mem_free(cloud->site);
    mem_free(cloud->near);
    mem_free(cloud->first);
    mem_free(cloud->crease);
    mem_free(cloud->crease_of);
    *cloud = (struct fit_cloud){ 0 };
}
