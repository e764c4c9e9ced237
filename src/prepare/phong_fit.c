#include "prepare/phong_fit.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "prepare/facts.h"
#include "prepare/order.h"
#include "prepare/phong_cover.h"
#include "prepare/phong_crease.h"
#include "prepare/phong_orient.h"
#include "prepare/phong_share.h"
#include "prepare/phong_splats.h"
#include "scene/axes.h"
#include "scene/scene.h"

#define SEARCH 24   /* fits that a count may take */
#define STALLS 3    /* of them, larger tolerances in turn that leave no fewer splats */
#define NEAR   0.98 /* of the count asked: near enough */
#define COVERS 0.9  /* of the whole fit, for its progress */
#define STEP   0.7  /* of the progress that is left, after each of the fits of a count */

struct fitting {
    const struct stp_env *env;
    const struct stp_scene *scene;
    const struct stp_fit_params *params;
    struct fit_cloud cloud;
    struct fit_limits limits;
    struct patch_set set;
    struct splats splats;
    struct stp_fit fit;
};

/* Tolerances and what they left: count falls about as a power of the tolerance. */
struct bracket {
    double low, high;             /* tolerances: too many splats, few enough */
    double low_count, high_count; /* 0: not known */
};

static double next_tolerance(const struct bracket *b, double count)
{
    if (b->high_count == 0)
        return b->low * fmax(b->low_count / count, 1.5);
    if (b->low_count == 0)
        return b->high * fmin(fmax(b->high_count / count, 1e-3), 0.5);
    double slope = log(b->low_count / b->high_count) / log(b->high / b->low);
    double guess = b->low * pow(b->low_count / count, 1 / fmax(slope, 1e-3)) * 1.003;
    double step = pow(b->high / b->low, 0.05); /* never so near an end that nothing is learnt */
    return fmin(fmax(guess, b->low * step), b->high / step);
}

/* The tolerance that more or less gives each patch its share of the sites, of a surface that bends
 * as much as most do: where the search starts. */
static double first_tolerance(const struct fit_cloud *cloud, double count)
{
    double sum = 0;
    for (size_t i = 0; i < cloud->count; i++)
        sum += (double)cloud->site[i].spacing;
    double spacing = sum > 0 ? sum / (double)cloud->count : 1;
    return 0.05 * spacing * sqrt((double)cloud->count / count);
}

static enum stp_result cover_at(struct fitting *f, double tolerance, struct patch_set *set)
{
    f->limits.tolerance = tolerance;
    return patches_cover(f->env, &f->cloud, &f->limits, set);
}

/* Keeps the set in f->set when it is the largest yet that is not too large. */
static void judge(struct fitting *f, struct bracket *b, double tolerance, double count,
                  struct patch_set *set)
{
    bool few = (double)set->count <= count;
    if (few && (b->high_count == 0 || tolerance < b->high)) {
        b->high = tolerance;
        b->high_count = (double)set->count;
        patch_set_release(&f->set);
        f->set = *set;
        f->fit.tolerance = tolerance;
        *set = (struct patch_set){ 0 };
    } else if (!few && (b->low_count == 0 || tolerance > b->low)) {
        b->low = tolerance;
        b->low_count = (double)set->count;
    }
    patch_set_release(set);
}

static enum stp_result search_count(struct fitting *f, double count)
{
    struct bracket b = { 0 };
    double tolerance = first_tolerance(&f->cloud, count);
    int stalls = 0;
    f->limits.ended = 0;
    for (int i = 0; i < SEARCH && b.high_count < NEAR * count && stalls < STALLS; i++) {
        struct patch_set set = { 0 };
        f->limits.begun = f->limits.ended;
        f->limits.ended = COVERS * (1 - pow(STEP, i + 1));
        double before = b.low_count;
        enum stp_result result = cover_at(f, tolerance, &set);
        if (result != STP_OK)
            return result;
        judge(f, &b, tolerance, count, &set);
        stalls = b.high_count == 0 && before > 0 && b.low_count > 0.99 * before ? stalls + 1 : 0;
        if (b.low_count > 0 && b.high_count > 0 && b.high < b.low * 1.0005)
            break;
        tolerance = next_tolerance(&b, count);
    }
    if (b.high_count > 0)
        return STP_OK;
    bool colored = f->cloud.samples->color && !isinf(f->limits.color);
    return log_error(f->env, STP_ERROR_ARGUMENT,
                     "%.0f splats cannot cover these points: %.0f are left at a tolerance of %g; "
                     "ask for more%s",
                     count, b.low_count, b.low,
                     colored ? ", or let one splat hold more different colours (--fit-color)" : "");
}

static enum stp_result find_patches(struct fitting *f)
{
    if (f->params->count > 0 && f->params->count < f->scene->splats.count)
        return search_count(f, (double)f->params->count);
    f->fit.tolerance = f->params->count > 0 ? 0 : f->params->tolerance;
    return f->fit.tolerance > 0 ? cover_at(f, f->fit.tolerance, &f->set) : STP_OK;
}

static void describe(struct fitting *f)
{
    f->fit.points = f->scene->splats.count;
    f->fit.splats = f->splats.count;
    f->fit.signs = f->cloud.signs;
    f->fit.single = f->splats.count - f->set.count;
    for (size_t i = 0; i < f->set.count; i++)
        f->fit.single += f->set.patch[i].count == 1;
    for (size_t i = 0; i < f->splats.count; i++)
        f->fit.clipped += f->splats.phong[i].clips > 0;
}

static enum stp_result fit(struct fitting *f)
{
    const struct stp_env *env = f->env;
    bool single = f->params->count == 0 && f->params->tolerance == 0;
    enum stp_result result = fit_cloud_build(env, &f->scene->splats, !single, &f->cloud);
    if (result == STP_OK && !single && !f->params->smooth)
        result = creases_find(env, &f->cloud);
    if (result == STP_OK)
        result = find_patches(f);
    if (result == STP_OK && f->set.count > 0)
        result = patches_share(env, &f->cloud, f->fit.tolerance, &f->set);
    if (result == STP_OK)
        result = patches_to_splats(env, &f->cloud, &f->set, f->fit.tolerance,
                                   (struct field_way){ f->params->flat, f->params->alone },
                                   &f->splats, &f->fit.deviation);
    if (result != STP_OK)
        return result;
    describe(f);
    if (!f->cloud.signs)
        result =
            splats_orient(env, &f->cloud, &f->set, scene_axes(f->scene->facts.up).up, &f->splats);
    return result == STP_OK ? order_splats(env, &f->splats, NULL) : result;
}

/* The splats take the points' place, and the facts are theirs. */
static enum stp_result replace(struct fitting *f, struct stp_scene *scene)
{
    struct stp_facts facts = scene->facts;
    double core[6];
    enum stp_result result = facts_measure(f->env, &f->splats, &facts, core);
    if (result != STP_OK)
        return result;
    if (!facts.phong) { /* discs of constant normals need no more than a disc has */
        mem_free(f->splats.phong);
        f->splats.phong = NULL;
    }
    facts.grouping = (struct stp_grouping){ 0 };
    facts.cover = (struct stp_cover){ 0 };
    splats_release(&scene->splats);
    cover_groups_release(&scene->cover);
    scene->splats = f->splats;
    f->splats = (struct splats){ 0 };
    scene->facts = facts;
    scene->version.content = scene_change(scene);
    memcpy(scene->core, core, sizeof core);
    for (unsigned i = 0; i < scene->object_count; i++)
        scene->objects[i].epsilon = fmax(scene->objects[i].epsilon, 4 * f->fit.tolerance);
    return STP_OK;
}

static enum stp_result check(const struct stp_env *env, const struct stp_scene *scene,
                             const struct stp_fit_params *params)
{
    if (!scene || !scene->prepared)
        return log_error(env, STP_ERROR_ARGUMENT, "splats are fitted to a prepared scene");
    if (scene->volume)
        return log_error(env, STP_ERROR_ARGUMENT, "splats are fitted to points: %s",
                         scene->facts.range.frames
                             ? "range images become such by --range-splats discs"
                             : "a volume has none");
    if (scene->share.count)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "splats are fitted to all points, and this process has a share of them");
    if (scene->stream)
        return scene_check_whole(env, scene, "fitting");
    if (!(params->tolerance >= 0) || isinf(params->tolerance) || !(params->color >= 0))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "a fit wants a tolerance, 0 or more, or a count of splats");
    if (scene->splats.phong)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "these splats are fitted already: fit the points that they came from");
    return STP_OK;
}

enum stp_result stp_scene_fit(const struct stp_env *env, struct stp_scene *scene,
                              const struct stp_fit_params *params, struct stp_fit *out)
{
    static const struct stp_fit_params defaults;
    params = params ? params : &defaults;
    double start = clock_ms();
    enum stp_result result = check(env, scene, params);
    if (result != STP_OK)
        return result;
    struct fitting f = {
        .env = env, .scene = scene, .params = params, .limits = { .ended = COVERS }
    };
    log_progress(env, "fit", 0);
    f.limits.color = params->color > 0 ? params->color : STP_DEFAULT_FIT_COLOR;
    result = fit(&f);
    if (result == STP_OK)
        result = replace(&f, scene);
    if (result == STP_OK)
        log_progress(env, "fit", 1);
    patch_set_release(&f.set);
    fit_cloud_release(&f.cloud);
    splats_release(&f.splats);
    f.fit.milliseconds = clock_ms() - start;
    if (result == STP_OK && out)
        *out = f.fit;
    return result;
}
