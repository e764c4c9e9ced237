/* stp_choose: best first. The cheapest way that is not yet refused is judged one step further,
 * until the cheapest one is accepted; so scenes are only grouped where groups could pay. */
#include "plan/auto.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/prepare.h"
#include "reference/reference.h"

/* Does the candidate do what the caller has fixed? */
static bool allowed(const struct choosing *c, const struct plan_candidate *way)
{
    const struct stp_render_params *p = &c->params;
    return (p->method == STP_METHOD_AUTO || p->method == way->method) &&
           (p->path == STP_PATH_AUTO || p->path == way->path) &&
           (p->payload == STP_PAYLOAD_AUTO || way->payload == STP_PAYLOAD_AUTO ||
            p->payload == way->payload) &&
           (p->voronoi == STP_VORONOI_DEFAULT || way->overlap == 0 || p->voronoi == way->voronoi) &&
           (way->transparency == STP_TRANSPARENCY_AUTO ||
            p->transparency == STP_TRANSPARENCY_AUTO || p->transparency == way->transparency);
}

/* What the caller has fixed of a way that has parameters. */
static void fix(const struct choosing *c, struct plan_candidate *way)
{
    if (c->group.overlap > 0 && way->overlap > 0)
        way->overlap = c->group.overlap;
    if (c->params.peel_layers && way->layers)
        way->layers = c->params.peel_layers;
}

/* Ways that differ only in what is fixed have become one. */
static bool repeated(const struct plan_candidate *way, unsigned i)
{
    for (unsigned k = 0; k < i; k++)
        if (way[k].method == way[i].method && way[k].path == way[i].path &&
            way[k].payload == way[i].payload && way[k].voronoi == way[i].voronoi &&
            way[k].transparency == way[i].transparency && way[k].overlap == way[i].overlap &&
            way[k].layers == way[i].layers)
            return true;
    return false;
}

static enum stp_result add(struct choosing *c, const struct plan_candidate *way, bool slow)
{
    struct auto_candidate *candidate = &c->candidate[c->count];
    struct stp_grouping none = { 0 };
    const struct auto_local *local = NULL;
    bool applies = false;
    enum stp_result result = STP_OK;
    assert(c->count < STP_MAX_CONSIDERED); /* there is room for all offers */
    *candidate = (struct auto_candidate){ .way = *way, .slow = slow, .error = NAN };
    candidate->stage = way->overlap > 0 ? AUTO_PRICED : AUTO_GROUPED;
    if (way->payload == STP_PAYLOAD_AUTO)
        candidate->way.payload = c->params.payload;
    if (way->overlap > 0)
        result = auto_local(c, way->overlap, &local);
    if (result == STP_OK)
        result = auto_price(c, candidate, local ? &local->facts : &none, &applies);
    c->count += applies;
    return result;
}

/* Those that take long to judge, since the scene is grouped for it or a picture drawn; or the
 * others. */
static enum stp_result add_offers(struct choosing *c, bool slow)
{
    enum stp_result result = STP_OK;
    for (unsigned o = 0; o < plan_offer_count; o++) {
        const struct plan_offer *offer = plan_offers[o];
        struct plan_candidate way[PLAN_MAX_OFFERED];
        unsigned count = offer->candidates(way);
        if ((offer->transparency != STP_TRANSPARENCY_AUTO) != c->scene->facts.transparent)
            continue;
        for (unsigned i = 0; result == STP_OK && i < count; i++) {
            fix(c, &way[i]);
            if (slow == (way[i].overlap > 0 || offer->draw) && !repeated(way, i) &&
                allowed(c, &way[i]))
                result = add(c, &way[i], slow);
        }
    }
    return result;
}

static enum stp_result list(struct choosing *c)
{
    enum stp_result result = add_offers(c, false);
    bool one_picture = c->params.max_error == 0 && c->params.method == STP_METHOD_AUTO;
    if (result == STP_OK && (!one_picture || c->count == 0))
        result = add_offers(c, true);
    return result;
}

/* Of equal prices the first. NULL: all are refused. */
static struct auto_candidate *cheapest(struct choosing *c)
{
    struct auto_candidate *found = NULL;
    for (unsigned i = 0; i < c->count; i++) {
        struct auto_candidate *candidate = &c->candidate[i];
        if (candidate->stage != AUTO_REFUSED &&
            (!found || auto_reckoned(candidate) < auto_reckoned(found)))
            found = candidate;
    }
    return found;
}

/* Errors that differ by less than what an estimate leaves open are alike: of these the cheapest. */
#define ALIKE 1.05
static struct auto_candidate *most_exact(struct choosing *c)
{
    double least = INFINITY;
    for (unsigned i = 0; i < c->count; i++)
        least = fmin(least, c->candidate[i].error);
    struct auto_candidate *found = NULL;
    for (unsigned i = 0; i < c->count; i++) {
        struct auto_candidate *candidate = &c->candidate[i];
        if (candidate->error <= ALIKE * least && (!found || candidate->ms < found->ms))
            found = candidate;
    }
    return found ? found : &c->candidate[0];
}

/* Of all overlaps that were tried, only of the one that is taken is it said what it lacks. */
static enum stp_result use_groups(struct choosing *c, double overlap)
{
    struct stp_group_params params = c->group;
    enum stp_result result = groupings_use(c->env, &c->groupings, &params, overlap);
    params.overlap = overlap;
    if (result == STP_OK)
        group_warn(c->env, c->scene, &params);
    return result;
}

static enum stp_result search(struct choosing *c, struct auto_candidate **chosen)
{
    struct auto_candidate *candidate;
    enum stp_result result = STP_OK;
    while (result == STP_OK && (candidate = cheapest(c)) && candidate->stage != AUTO_ACCEPTED)
        result = auto_judge(c, candidate);
    if (result != STP_OK)
        return result;
    *chosen = candidate ? candidate : most_exact(c);
    if (!candidate)
        log_warning(c->env,
                    "no method is sure to stay within an error of %g here; the most exact is "
                    "taken, with up to %.2g",
                    c->bound, (*chosen)->error);
    if ((*chosen)->way.overlap > 0)
        result = use_groups(c, (*chosen)->way.overlap);
    return result;
}

static int by_cost(const void *a, const void *b)
{
    const struct stp_considered *x = a, *y = b;
    return (x->milliseconds > y->milliseconds) - (x->milliseconds < y->milliseconds);
}

static void conclude(const struct choosing *c, const struct auto_candidate *chosen,
                     struct stp_choice *choice)
{
    *choice = (struct stp_choice){ .params = c->params, .met = chosen->stage == AUTO_ACCEPTED };
    choice->params.method = chosen->way.method;
    choice->params.path = chosen->way.path;
    choice->params.payload = chosen->way.payload;
    choice->params.voronoi = chosen->way.overlap > 0 ? chosen->way.voronoi : c->params.voronoi;
    if (chosen->way.transparency != STP_TRANSPARENCY_AUTO)
        choice->params.transparency = chosen->way.transparency;
    if (chosen->way.layers)
        choice->params.peel_layers = chosen->way.layers;
    choice->params.prediction = (struct stp_prediction){ c->bound, chosen->ms, chosen->error };
    for (unsigned i = 0; i < c->count; i++) {
        const struct auto_candidate *k = &c->candidate[i];
        choice->considered[choice->count++] = (struct stp_considered){
            .method = k->way.method,
            .path = k->way.path,
            .payload = k->way.payload,
            .voronoi = k->way.voronoi,
            .overlap = k->way.overlap,
            .groups = k->grouping.groups,
            .transparency = k->way.transparency,
            .peel_layers = k->way.layers,
            .milliseconds = k->ms,
            .error = k->error,
            .verdict = k == chosen                ? STP_VERDICT_CHOSEN
                       : k->stage == AUTO_REFUSED ? STP_VERDICT_INEXACT
                                                  : STP_VERDICT_COSTLY,
        };
    }
    qsort(choice->considered, choice->count, sizeof *choice->considered, by_cost);
}

/* What is asked for is drawn, or the plan says why it cannot be. */
static void nothing_applies(const struct choosing *c, struct stp_choice *choice)
{
    *choice = (struct stp_choice){ .params = c->params, .met = c->params.max_error == 0 };
    if (c->params.max_error > 0)
        log_warning(c->env,
                    "nothing that is estimated can be drawn as asked: the bound of %g is not "
                    "looked at",
                    c->params.max_error);
}

static enum stp_result choose(struct choosing *c, struct stp_choice *choice)
{
    struct auto_candidate *chosen = NULL;
    enum stp_result result = survey_make(c->env, c->scene, c->camera, &c->params, &c->survey);
    if (c->params.max_error > 0) {
        struct view view = reference_view(c->scene, c->camera, &c->params);
        c->levels_error = probe_levels_error(c->env, &view);
    }
    if (result == STP_OK && c->scene->facts.transparent) {
        result = auto_probe(c, 0);
        c->survey.layers = c->probe[0].layers;
    }
    if (result == STP_OK)
        result = list(c);
    if (result == STP_OK && c->count)
        result = search(c, &chosen);
    if (result == STP_OK && chosen)
        conclude(c, chosen, choice);
    else if (result == STP_OK)
        nothing_applies(c, choice);
    groupings_end(&c->groupings, result == STP_OK && chosen && chosen->way.overlap > 0);
    for (unsigned i = 0; i < c->local_count; i++)
        mem_free(c->local[i].group);
    for (unsigned i = 0; i < 2; i++)
        probe_release(&c->probe[i]);
    survey_release(&c->survey);
    return result;
}

/* Of groups the fast way, unless another is asked for. */
static enum stp_transparency transparency_of(const struct stp_render_params *params)
{
    bool fast =
        params->transparency == STP_TRANSPARENCY_AUTO && params->method == STP_METHOD_DEFERRED;
    return fast ? STP_TRANSPARENCY_FAST : params->transparency;
}

/* Media have no surfaces to probe. Layers are composited by what `transparency` says while there is
 * no bound to choose by; groups that cover the surface would have to be made to judge the rest. */
bool stp_choose_estimates(const struct stp_facts *facts, const struct stp_render_params *params)
{
    params = plan_params(params);
    enum stp_transparency t = transparency_of(params);
    bool judged =
        t == STP_TRANSPARENCY_AUTO || t == STP_TRANSPARENCY_EXACT || t == STP_TRANSPARENCY_PEEL;
    return !plan_of_medium(facts) && (!facts->transparent || (params->max_error > 0 && judged));
}

enum stp_result stp_choose(const struct stp_env *env, struct stp_scene *scene,
                           const struct stp_camera *camera, const struct stp_group_params *group,
                           const struct stp_render_params *params, const struct stp_limits *limits,
                           struct stp_choice *choice)
{
    params = plan_params(params);
    enum stp_result result = scene_check_whole(env, scene, "choosing a method");
    if (result == STP_OK)
        result = plan_check(env, scene, camera, params);
    if (result != STP_OK)
        return result;
    if (!(params->max_error >= 0) || params->method == STP_METHOD_REFERENCE)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "there is nothing to choose with max_error %g and method %s",
                         params->max_error, stp_method_name(params->method));
    if (!stp_choose_estimates(&scene->facts, params)) {
        *choice = (struct stp_choice){ .params = *params, .met = params->max_error == 0 };
        if (params->max_error > 0)
            log_warning(env, "the error of %s%s is not estimated: the bound of %g is not looked at",
                        scene->volume ? "volumes and range images" : "transparency ",
                        scene->volume ? "" : stp_transparency_name(transparency_of(params)),
                        params->max_error);
        return STP_OK;
    }
    struct choosing *c = mem_zalloc(1, sizeof *c);
    if (!c)
        return log_no_memory(env, sizeof *c, "choosing a method");
    c->env = env;
    c->scene = scene;
    c->camera = camera;
    c->group = group ? *group : (struct stp_group_params){ 0 };
    c->params = *params;
    c->params.prediction = (struct stp_prediction){ 0 };
    c->limits = limits;
    c->bound = params->max_error > 0 ? params->max_error : STP_DEFAULT_MAX_ERROR;
    groupings_begin(&c->groupings, scene);
    result = choose(c, choice);
    mem_free(c);
    return result;
}
