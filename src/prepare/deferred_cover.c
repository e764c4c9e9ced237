/* ZP 4.2: extended grouping, from prepared splats to groups that each cover the surface. */
#include "prepare/deferred_cover.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "prepare/deferred_blocks.h"
#include "prepare/deferred_bsp.h"

#include <math.h>
#include <string.h>

#define MOST_EDGES       64 /* undirected, a splat */
#define MIN_EDGES        ((size_t)1 << 20)
#define CROWD            64               /* larger splats over one that is crowded */
#define DUPLICATE_GROUPS 4                /* AUTO: the most groups that take duplicates */
#define ROUNDS           3                /* of duplicates */
#define MOST_MEMBERS     (UINT32_MAX / 3) /* a draw counts three vertices each */
#define MOST_DUPLICATES  0.45             /* BOTH: of the splats */
#define MISSED           2e-3             /* of the surface, and then more is done */
#define MEASURE_BUDGET   ((size_t)1 << 22)

static void release(struct cover *cover)
{
    size_t pools = (cover->splats->count + OVERLAP_POOL - 1) / OVERLAP_POOL;
    for (size_t i = 0; cover->mask && i < pools; i++)
        mem_free(cover->mask[i]);
    mem_free(cover->mask);
    mem_free(cover->depth);
    mem_free(cover->member);
    mem_free(cover->skip);
    mem_free(cover->home);
    mem_free((void *)cover->epsilon);
    overlap_graph_release(&cover->graph);
}

static enum stp_result start(struct cover *cover, const struct stp_scene *scene)
{
    size_t n = scene->splats.count;
    double *epsilon = mem_alloc(scene->object_count, sizeof *epsilon);
    cover->epsilon = epsilon;
    cover->skip = mem_zalloc(n, 1);
    cover->member = mem_zalloc(n, sizeof *cover->member);
    cover->home = mem_alloc(n, 1);
    if (!epsilon || !cover->skip || !cover->member || !cover->home)
        return log_no_memory(cover->env, n * 9, "groups");
    for (unsigned i = 0; i < scene->object_count; i++)
        epsilon[i] = scene->objects[i].epsilon;
    for (size_t i = 0; i < n; i++) {
        bool seen = !scene->splats.opacity || scene->splats.opacity[i] > 0;
        bool equal = i > 0 && splats_equal(&scene->splats, i - 1, i);
        cover->skip[i] = seen && !equal ? 0 : COVER_OUT;
        cover->home[i] = UINT8_MAX;
    }
    return STP_OK;
}

/* Discs that overlap; larger radii reach farther. Where there are far too many, the crowded leave.
 */
static enum stp_result build_graph(struct cover *cover, double reach)
{
    size_t n = cover->splats->count, most = n * MOST_EDGES, crowded;
    struct overlap_params params = { reach, STP_RELAX_OPPOSED, cover->skip,
                                     most > MIN_EDGES ? most : MIN_EDGES };
    bool over = false;
    enum stp_result result =
        overlap_graph_build(cover->env, cover->splats, &params, &cover->graph, &over);
    if (result != STP_OK || !over)
        return result;
    uint8_t *skip = mem_alloc(n, 1);
    if (!skip)
        return log_no_memory(cover->env, n, "groups");
    memcpy(skip, cover->skip, n);
    result = block_tree_crowded(cover->env, cover->splats, reach, CROWD, skip, &crowded);
    for (size_t i = 0; i < n; i++)
        cover->skip[i] = skip[i] == 2 ? COVER_CROWDED : cover->skip[i];
    mem_free(skip);
    params.max_edges = 0;
    return result == STP_OK
               ? overlap_graph_build(cover->env, cover->splats, &params, &cover->graph, NULL)
               : result;
}

static double largest_factor(enum stp_extend extend)
{
    return extend == STP_EXTEND_ENLARGE ? 2 : extend == STP_EXTEND_BOTH ? 1.2 : 1;
}

static double least(const double *share, unsigned count)
{
    double least = share[0];
    for (unsigned k = 1; k < count; k++)
        least = fmin(least, share[k]);
    return least;
}

static enum stp_result measure(const struct cover *cover, struct stp_cover *facts, size_t *points)
{
    return cover_measure(cover, facts->factor, MEASURE_BUDGET, facts->coverage, points);
}

static size_t members(const struct cover *cover)
{
    size_t sum = 0;
    for (size_t i = 0; i < cover->splats->count; i++)
        sum += (size_t)__builtin_popcountll(cover->member[i]);
    return sum;
}

/* Duplicates are chosen by few points a disc, which flatter the groups: where other points see
 * less than the target, it is raised by what is missing. At most `most` members in all. */
static enum stp_result duplicate(struct cover *cover, struct stp_cover *facts, double target,
                                 size_t most, size_t *points)
{
    double raised = target;
    for (unsigned round = 0; round < ROUNDS; round++) {
        size_t taken = members(cover), room = most > taken ? (most - taken) / cover->groups : 0;
        enum stp_result result = cover_duplicate(cover, raised, room);
        if (result == STP_OK)
            result = measure(cover, facts, points);
        double missing = target - least(facts->coverage, cover->groups);
        if (result != STP_OK || missing <= 0 || room == 0)
            return result;
        raised = fmin(1, raised + 1.25 * missing);
    }
    return STP_OK;
}

static enum stp_result enlarge(struct cover *cover, struct stp_cover *facts, double target,
                               size_t *points)
{
    enum stp_result result =
        cover_enlarge(cover, target, largest_factor(facts->extend), facts->factor);
    return result == STP_OK ? measure(cover, facts, points) : result;
}

/* Few duplicates, larger radii for the rest; where even those are too small, as many duplicates
 * as it takes. */
static enum stp_result extend_both(struct cover *cover, struct stp_cover *facts, double target,
                                   size_t *points)
{
    size_t most = members(cover) + (size_t)(MOST_DUPLICATES * (double)members(cover));
    enum stp_result result = duplicate(cover, facts, target, most, points);
    if (result == STP_OK && least(facts->coverage, cover->groups) < target - MISSED)
        result = enlarge(cover, facts, target, points);
    if (result != STP_OK || least(facts->coverage, cover->groups) >= target - MISSED)
        return result;
    for (unsigned k = 0; k < cover->groups; k++)
        facts->factor[k] = 1;
    return duplicate(cover, facts, target, SIZE_MAX, points);
}

static enum stp_result extend(struct cover *cover, struct stp_cover *facts, double target)
{
    enum stp_result result;
    size_t points = 0;
    if (facts->extend == STP_EXTEND_DUPLICATE)
        result = duplicate(cover, facts, target, SIZE_MAX, &points);
    else if (facts->extend == STP_EXTEND_ENLARGE)
        result = enlarge(cover, facts, target, &points);
    else
        result = extend_both(cover, facts, target, &points);
    if (result != STP_OK)
        return result;
    double worst = 0;
    for (unsigned k = 0; k < cover->groups; k++)
        worst = fmax(worst, facts->coverage[k] * (1 - facts->coverage[k]));
    facts->error = points ? sqrt(worst / (double)points) : 0;
    return STP_OK;
}

/* Several groups. */
static enum stp_result make_groups(struct cover *cover, struct stp_cover *facts, double target)
{
    enum stp_result result = build_graph(cover, (1 + largest_factor(facts->extend)) / 2);
    if (result == STP_OK)
        result = cover_masks_build(cover);
    if (result != STP_OK)
        return result;
    cover_assign(cover);
    result = cover_measure(cover, NULL, MEASURE_BUDGET, facts->before, NULL);
    return result == STP_OK ? extend(cover, facts, target) : result;
}

/* All splats are one group, and cover what they cover. */
static void make_one(struct cover *cover, struct stp_cover *facts)
{
    for (size_t i = 0; i < cover->splats->count; i++) {
        cover->member[i] = cover->skip[i] != COVER_OUT;
        cover->home[i] = cover->member[i] ? 0 : UINT8_MAX;
    }
    facts->before[0] = facts->coverage[0] = 1;
}

/* The members of each group, ascending, then its tree. */
static enum stp_result make_trees(struct cover *cover, struct stp_cover *facts,
                                  struct cover_groups *made)
{
    size_t n = cover->splats->count, splats = 0;
    for (size_t i = 0; i < n; i++) {
        facts->members += (size_t)__builtin_popcountll(cover->member[i]);
        splats += cover->member[i] != 0;
    }
    facts->duplicates = splats ? (double)(facts->members - splats) / (double)splats : 0;
    uint32_t *member =
        facts->members <= MOST_MEMBERS ? mem_alloc(facts->members, sizeof *member) : NULL;
    if (!member)
        return log_no_memory(cover->env, facts->members * sizeof *member, "groups");
    size_t at = 0;
    made->groups = cover->groups;
    for (unsigned k = 0; k < cover->groups; k++) {
        for (size_t i = 0; i < n; i++)
            if (cover->member[i] >> k & 1)
                member[at++] = (uint32_t)i;
        made->first[k + 1] = (uint32_t)at;
        made->factor[k] = (float)facts->factor[k];
    }
    enum stp_result result = bsp_build(cover->env, cover->splats, made, member);
    mem_free(member);
    if (result == STP_OK) {
        made->home = cover->home;
        cover->home = NULL;
    }
    return result;
}

static enum stp_result check(const struct stp_env *env, const struct stp_scene *scene,
                             const struct stp_cover_params *p)
{
    if (!scene->prepared || !scene->splats.count)
        return log_error(env, STP_ERROR_ARGUMENT, "coverage: the scene is not prepared");
    if (p->groups > STP_MAX_GROUPS)
        return log_error(env, STP_ERROR_ARGUMENT, "coverage: %u groups; at most %d can be asked",
                         p->groups, STP_MAX_GROUPS);
    if (!(p->coverage >= 0 && p->coverage <= 1))
        return log_error(env, STP_ERROR_ARGUMENT, "coverage: %g is not in (0, 1]", p->coverage);
    if (p->extend > STP_EXTEND_BOTH)
        return log_error(env, STP_ERROR_ARGUMENT, "coverage: extend %d means nothing",
                         (int)p->extend);
    return STP_OK;
}

static struct stp_cover asked(const struct stp_cover_params *p)
{
    struct stp_cover facts = { .groups = p->groups ? p->groups : STP_DEFAULT_COVER_GROUPS };
    facts.extend = p->extend != STP_EXTEND_AUTO       ? p->extend
                   : facts.groups <= DUPLICATE_GROUPS ? STP_EXTEND_BOTH
                                                      : STP_EXTEND_ENLARGE;
    for (unsigned k = 0; k < facts.groups; k++)
        facts.factor[k] = 1;
    return facts;
}

/* Into scene->cover and facts.cover. Splats of opacity 0, and those that equal their predecessor,
 * are in no group. Where more overlap than any K could make use of (128 a splat on average), those
 * under 64 or more larger ones count as crowded: they are dealt out in turn and not sampled, so
 * that a million coincident splats take no more time than others. */
static enum stp_result cover_scene(const struct stp_env *env, struct stp_scene *scene,
                                   const struct stp_cover_params *params)
{
    const struct stp_cover_params none = { 0 }, *p = params ? params : &none;
    enum stp_result result = check(env, scene, p);
    if (result != STP_OK)
        return result;
    double begin = clock_ms();
    struct stp_cover facts = asked(p);
    struct cover cover = { .env = env, .splats = &scene->splats, .groups = facts.groups };
    struct cover_groups made = { 0 };
    result = start(&cover, scene);
    if (result == STP_OK && facts.groups > 1)
        result = make_groups(&cover, &facts, p->coverage > 0 ? p->coverage : STP_DEFAULT_COVERAGE);
    else if (result == STP_OK)
        make_one(&cover, &facts);
    if (result == STP_OK)
        result = make_trees(&cover, &facts, &made);
    release(&cover);
    if (result != STP_OK)
        return result;
    facts.milliseconds = clock_ms() - begin;
    cover_groups_release(&scene->cover);
    scene->cover = made;
    scene->facts.cover = facts;
    scene->version.cover = scene_change(scene);
    return STP_OK;
}

enum stp_result stp_scene_cover(const struct stp_env *env, struct stp_scene *scene,
                                const struct stp_cover_params *params)
{
    if (!scene)
        return log_error(env, STP_ERROR_ARGUMENT, "stp_scene_cover: the scene is NULL");
    enum stp_result result = scene_check_whole(env, scene, "covering");
    return result == STP_OK ? cover_scene(env, scene, params) : result;
}
