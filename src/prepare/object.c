#include "prepare/object.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/collect.h"
#include "prepare/color.h"
#include "prepare/normals.h"
#include "prepare/order.h"
#include "prepare/orient.h"
#include "prepare/radii.h"
#include "scene/axes.h"
#include "scene/phong.h"

/* What an object lacks, and the tree that finds it. */
struct need {
    struct splats *splats;
    struct places places; /* found, and the tree built, only when something is missing */
    struct neighbour_tree tree;
    bool all_normals, some_normals, radii, monsters;
    float median; /* of the given radii */
};

static enum stp_result find_needs(const struct stp_env *env, struct need *need,
                                  struct stp_facts *facts)
{
    struct splats *s = need->splats;
    size_t unknown = normals_unknown(s);
    if (s->normal)
        facts->bad_normals += unknown;
    need->all_normals = unknown > s->count - unknown;
    need->some_normals = unknown > 0 && !need->all_normals;
    need->radii = !s->radius;
    if (!s->radius)
        return STP_OK;
    size_t blank = radii_unknown(s->radius, s->count);
    facts->bad_radii += blank;
    need->radii = blank > 0;
    enum stp_result result = radii_median(env, s->radius, s->count, &need->median);
    if (result == STP_OK) /* an ellipse is as large as it was made */
        need->monsters = !s->phong && radii_are_suspect(s->radius, s->count, need->median);
    return result;
}

static enum stp_result drop_monsters(const struct stp_env *env, struct need *need,
                                     struct stp_facts *facts)
{
    size_t count;
    if (!need->monsters)
        return STP_OK;
    enum stp_result result =
        radii_blank_monsters(env, &need->places, &need->tree, need->splats->radius,
                             need->splats->count, need->median, &count);
    if (result != STP_OK)
        return result;
    facts->bad_radii += count;
    need->radii |= count > 0;
    return STP_OK;
}

static enum stp_result fill_radii(const struct stp_env *env, struct need *need,
                                  const struct surroundings *all, struct stp_facts *facts)
{
    struct splats *s = need->splats;
    size_t outliers;
    if (!need->radii)
        return STP_OK;
    if (!s->radius)
        s->radius = mem_zalloc(s->count, sizeof *s->radius);
    if (!s->radius)
        return log_no_memory(env, s->count * sizeof *s->radius, "radii");
    enum stp_result result = radii_fill(env, &need->places, all, s->radius, s->count, &outliers);
    if (result == STP_OK)
        facts->outliers += outliers;
    return result;
}

/* A normal a place becomes a normal a splat. */
static enum stp_result spread_normals(const struct stp_env *env, const struct need *need,
                                      struct surroundings *all)
{
    struct splats *s = need->splats;
    mem_free(s->normal);
    s->normal = all->normal;
    all->normal = NULL;
    if (!need->places.of)
        return STP_OK;
    float(*of_place)[3] = s->normal;
    s->normal = mem_alloc(s->count, sizeof *s->normal);
    for (size_t i = 0; s->normal && i < s->count; i++)
        memcpy(s->normal[i], of_place[need->places.of[i]], sizeof s->normal[i]);
    mem_free(of_place);
    return s->normal ? STP_OK : log_no_memory(env, s->count * sizeof *s->normal, "normals");
}

/* Both come from the same neighbours: they are looked for once. */
static enum stp_result fill_from_surroundings(const struct stp_env *env, struct need *need,
                                              struct vec3 up, struct stp_facts *facts)
{
    struct surroundings all;
    if (!need->all_normals && !need->radii)
        return STP_OK;
    enum stp_result result = surroundings_find(env, &need->tree, need->all_normals, &all);
    if (result != STP_OK)
        return result;
    neighbour_tree_release(&need->tree); /* its work is done: orientation needs the room */
    result = fill_radii(env, need, &all, facts);
    if (need->all_normals && result == STP_OK)
        result = orient_normals(env, &need->places, &all, up);
    if (need->all_normals && result == STP_OK)
        result = spread_normals(env, need, &all);
    surroundings_release(&all);
    return result;
}

/* What had no ellipse, or none that could be used, is a disc, now that normal and radius are known.
 */
static void fill_discs(struct splats *s)
{
    for (size_t i = 0; s->phong && i < s->count; i++)
        if (phong_is_disc(&s->phong[i]) || s->phong[i].radius[0] == 0)
            s->phong[i] = phong_of_disc(s->normal[i], s->radius[i]);
}

static enum stp_result complete(const struct stp_env *env, struct need *need, struct vec3 up,
                                struct stp_facts *facts)
{
    struct splats *s = need->splats;
    enum stp_result result = find_needs(env, need, facts);
    bool any = need->all_normals || need->some_normals || need->radii || need->monsters;
    if (result != STP_OK || !any)
        return result;
    result = places_find(env, s, &need->places);
    if (result == STP_OK)
        result = neighbour_tree_build(env, need->places.position, need->places.count, &need->tree);
    if (result == STP_OK)
        result = drop_monsters(env, need, facts);
    if (result == STP_OK && need->some_normals)
        result = normals_mend(env, s, &need->places, &need->tree);
    if (result == STP_OK)
        result = fill_from_surroundings(env, need, up, facts);
    neighbour_tree_release(&need->tree);
    places_release(&need->places);
    return result;
}

static enum stp_result finish(const struct stp_env *env, struct scene_object *object,
                              enum stp_up up, bool want_color, struct splats *s)
{
    enum stp_result result = STP_OK;
    float median;
    if (object->epsilon == 0) {
        result = radii_median(env, s->radius, s->count, &median);
        if (result == STP_OK)
            object->epsilon = (double)median;
    }
    return result == STP_OK && want_color ? color_object(env, object, up, s) : result;
}

enum stp_result prepare_object(const struct stp_env *env, struct scene_object *object,
                               enum stp_up up, const double *clip_box, bool want_color,
                               struct stp_facts *facts, struct object_splats *out)
{
    struct object_splats made = { 0 };
    struct need need = { .splats = &made.splats };
    size_t duplicates = 0;
    enum stp_result result = collect_cloud(env, &object->cloud, clip_box, &made.splats, facts);
    if (result == STP_OK)
        result = opacity_object(env, object, &made.splats); /* before: it is part of the order */
    if (result == STP_OK)
        result = order_splats(env, &made.splats, &duplicates);
    facts->duplicates += duplicates;
    if (result == STP_OK && made.splats.count > 0) {
        result = complete(env, &need, scene_axes(up).up, facts);
        made.estimated = object->estimated |= need.all_normals;
        if (result == STP_OK) {
            fill_discs(&made.splats);
            result = finish(env, object, up, want_color, &made.splats);
        }
    }
    if (result != STP_OK) {
        splats_release(&made.splats);
        return result;
    }
    facts->no_normal += normals_unknown(&made.splats);
    *out = made;
    return STP_OK;
}
