/* ZP 4.1: splats to groups that hardly overlap. */
#include "prepare/prepare.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/deferred_blocks.h"
#include "scene/phong.h"

#include <math.h>
#include <string.h>

/* Undirected edges a splat: beyond this no 64 groups can do (uniform cover needs about 3/4 of its
 * average degree in colours), so the graph is not worth its memory. */
#define MAX_EDGES_A_SPLAT 64
#define MIN_EDGES         ((size_t)1 << 20)
#define STEPS             64

enum { IN_GRAPH = 0, DUPLICATE = 1, CROWDED = 2 };

struct grouping {
    const struct stp_env *env;
    const struct splats *splats;
    unsigned relax, max_groups;
    uint8_t *skip;  /* one of the above for each splat */
    uint8_t *group; /* the best so far */
    uint8_t *trial;
    size_t crowded;
    struct stp_grouping facts; /* of `group` */
};

bool splats_equal(const struct splats *s, size_t i, size_t j)
{
    return memcmp(s->position[i], s->position[j], sizeof *s->position) == 0 &&
           memcmp(s->normal[i], s->normal[j], sizeof *s->normal) == 0 &&
           memcmp(&s->radius[i], &s->radius[j], sizeof *s->radius) == 0 &&
           (!s->color || memcmp(s->color[i], s->color[j], sizeof *s->color) == 0) &&
           (!s->opacity || memcmp(&s->opacity[i], &s->opacity[j], sizeof *s->opacity) == 0) &&
           (!s->phong || phong_equal(&s->phong[i], &s->phong[j])) &&
           (!s->object || s->object[i] == s->object[j]);
}

/* The canonical order has put equals side by side. */
static void mark_duplicates(void *context, size_t begin, size_t end, unsigned)
{
    struct grouping *g = context;
    for (size_t i = begin; i < end; i++)
        g->skip[i] = i > 0 && splats_equal(g->splats, i - 1, i) ? DUPLICATE : IN_GRAPH;
}

static void spread_left_out(const struct grouping *g, unsigned groups)
{
    size_t turn = 0;
    for (size_t i = 0; i < g->splats->count; i++)
        if (g->skip[i] == CROWDED)
            g->trial[i] = (uint8_t)(turn++ % groups);
        else if (g->skip[i] == DUPLICATE)
            g->trial[i] = g->trial[i - 1];
}

static void take_trial(struct grouping *g, double overlap, const struct overlap_graph *graph,
                       unsigned groups, size_t conflicts)
{
    uint8_t *swap = g->group;
    g->group = g->trial;
    g->trial = swap;
    g->facts.groups = groups;
    g->facts.overlap = overlap;
    g->facts.max_degree = graph->max_degree;
    g->facts.avg_degree = graph->nodes ? 2 * (double)graph->edges / (double)graph->nodes : 0;
    g->facts.crowded = g->crowded + conflicts;
}

/* Groups at this c. *fits: into max_groups; the grouping is kept when it does, or when `keep`
 * (then the crowded are out, and fewer than max_groups edges a splat are left). */
static enum stp_result try_overlap(struct grouping *g, double overlap, bool keep, bool *fits)
{
    struct overlap_graph graph;
    unsigned groups;
    size_t conflicts, edges = MAX_EDGES_A_SPLAT * g->splats->count;
    bool overload = false;
    edges = edges > MIN_EDGES ? edges : MIN_EDGES;
    struct overlap_params params = { overlap, g->relax, g->skip, keep ? 0 : edges };
    enum stp_result result = overlap_graph_build(g->env, g->splats, &params, &graph, &overload);
    *fits = false;
    if (result != STP_OK || overload)
        return result;
    result = largest_first_color(g->env, &graph, g->max_groups, g->trial, &groups, &conflicts);
    if (result == STP_OK) {
        *fits = conflicts == 0;
        if (*fits || keep) {
            spread_left_out(g, groups);
            take_trial(g, overlap, &graph, groups, conflicts);
        }
    }
    overlap_graph_release(&graph);
    return result;
}

/* Between a c that is kept and one that does not fit. */
static enum stp_result bisect(struct grouping *g, double low, double high)
{
    enum stp_result result = STP_OK;
    for (unsigned kept = 0, failed = STEPS; result == STP_OK && failed - kept > 1;) {
        unsigned middle = (kept + failed) / 2;
        bool fits;
        result = try_overlap(g, low + (high - low) * middle / STEPS, false, &fits);
        if (fits)
            kept = middle;
        else
            failed = middle;
    }
    return result;
}

/* What a heap may take of the groups: few are its own but for one, of many it leaves half to what
 * is around it. */
static unsigned heap_limit(unsigned max_groups)
{
    if (max_groups > 8)
        return max_groups / 2;
    return max_groups > 1 ? max_groups - 1 : 1;
}

/* Some splats are in heaps that no c spreads out: these leave, the rest is grouped. */
static enum stp_result without_crowds(struct grouping *g, double least, double overlap)
{
    unsigned limit = heap_limit(g->max_groups);
    bool fits = false;
    enum stp_result result =
        block_tree_crowded(g->env, g->splats, least, limit, g->skip, &g->crowded);
    if (result == STP_OK && g->crowded)
        result = try_overlap(g, overlap, false, &fits);
    if (result != STP_OK || fits)
        return result;
    result = try_overlap(g, least, true, &fits);
    return result == STP_OK && fits ? bisect(g, least, overlap) : result;
}

static enum stp_result lower_overlap(struct grouping *g, double overlap)
{
    double least = overlap < GROUP_MIN_OVERLAP ? overlap : GROUP_MIN_OVERLAP;
    bool fits;
    enum stp_result result = try_overlap(g, least, false, &fits);
    if (result != STP_OK)
        return result;
    return fits ? bisect(g, least, overlap) : without_crowds(g, least, overlap);
}

static double overlap_of(const struct stp_group_params *p)
{
    return p->overlap > 0 ? p->overlap : STP_DEFAULT_OVERLAP;
}

static unsigned most_groups(const struct stp_group_params *p)
{
    return p->max_groups ? p->max_groups : STP_MAX_GROUPS;
}

void group_warn(const struct stp_env *env, const struct stp_scene *scene,
                const struct stp_group_params *p)
{
    const struct stp_grouping *facts = &scene->facts.grouping;
    if (facts->overlap < overlap_of(p))
        log_warning(env, "grouping: overlap %g needs more than %u groups; %.4g is used instead",
                    overlap_of(p), most_groups(p), facts->overlap);
    if (facts->crowded)
        log_warning(env,
                    "grouping: %zu of %zu splats lie in heaps that %u groups cannot hold; they "
                    "share a group with others that they overlap",
                    facts->crowded, scene->splats.count, most_groups(p));
}

static enum stp_result group_splats(struct grouping *g, double overlap)
{
    double start = clock_ms();
    bool fits;
    parallel_for(g->env, g->splats->count, 16384, mark_duplicates, g);
    enum stp_result result = try_overlap(g, overlap, false, &fits);
    if (result == STP_OK && !fits)
        result = lower_overlap(g, overlap);
    g->facts.milliseconds = clock_ms() - start;
    return result;
}

static enum stp_result check(const struct stp_env *env, const struct stp_scene *scene,
                             const struct stp_group_params *p)
{
    const unsigned spare = STP_RELAX_COPLANAR | STP_RELAX_OPPOSED;
    if (!scene->prepared || !scene->splats.count)
        return log_error(env, STP_ERROR_ARGUMENT, "grouping: the scene is not prepared");
    if (!(p->overlap >= 0 && p->overlap <= 1))
        return log_error(env, STP_ERROR_ARGUMENT, "grouping: overlap %g is not in (0, 1]",
                         p->overlap);
    if (p->max_groups > STP_MAX_GROUPS)
        return log_error(env, STP_ERROR_ARGUMENT, "grouping: %u groups; at most %d can be asked",
                         p->max_groups, STP_MAX_GROUPS);
    if ((p->relax & ~(spare | STP_RELAX_NONE)) || ((p->relax & STP_RELAX_NONE) && p->relax & spare))
        return log_error(env, STP_ERROR_ARGUMENT, "grouping: relax %#x means nothing", p->relax);
    return STP_OK;
}

enum stp_result group_scene(const struct stp_env *env, struct stp_scene *scene,
                            const struct stp_group_params *params)
{
    const struct stp_group_params none = { 0 }, *p = params ? params : &none;
    struct grouping g = { .env = env, .splats = &scene->splats };
    enum stp_result result = check(env, scene, p);
    if (result != STP_OK)
        return result;
    size_t count = scene->splats.count;
    g.relax = p->relax ? p->relax : STP_RELAX_OPPOSED;
    g.max_groups = most_groups(p);
    g.facts.relax = g.relax;
    g.skip = mem_alloc(count, 1);
    g.group = mem_alloc(count, 1);
    g.trial = mem_alloc(count, 1);
    result = g.skip && g.group && g.trial ? group_splats(&g, overlap_of(p))
                                          : log_no_memory(env, count, "the groups");
    if (result == STP_OK) {
        uint8_t *old = scene->splats.group;
        if (!old || memcmp(old, g.group, count) != 0) /* found again, it is the same */
            scene->version.groups = scene_change(scene);
        scene->splats.group = g.group;
        scene->facts.grouping = g.facts;
        g.group = old;
    }
    mem_free(g.skip);
    mem_free(g.group);
    mem_free(g.trial);
    return result;
}

enum stp_result stp_scene_group(const struct stp_env *env, struct stp_scene *scene,
                                const struct stp_group_params *params)
{
    if (!scene)
        return log_error(env, STP_ERROR_ARGUMENT, "stp_scene_group: the scene is NULL");
    const struct stp_group_params none = { 0 };
    enum stp_result result = scene_check_whole(env, scene, "grouping");
    if (result == STP_OK)
        result = group_scene(env, scene, params);
    if (result == STP_OK)
        group_warn(env, scene, params ? params : &none);
    return result;
}
