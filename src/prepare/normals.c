#include "prepare/normals.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "base/vec.h"

bool normal_is_unknown(const float n[3])
{
    return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

size_t normals_unknown(const struct splats *s)
{
    size_t unknown = 0;
    if (!s->normal)
        return s->count;
    for (size_t i = 0; i < s->count; i++)
        unknown += normal_is_unknown(s->normal[i]);
    return unknown;
}

/* What is left without a normal, and what is found once about it. */
struct lost {
    uint32_t splat;
    uint32_t neighbour[SURROUND_GRAPH];
    float plane[3], normal[3]; /* normal: this round's; 0: not yet */
};

struct mend {
    const struct splats *splats; /* their normals stay as they are while a round reads them */
    const struct places *places;
    const struct neighbour_tree *tree;
    struct lost *lost;
    struct vec3 middle;
    bool first; /* round: beside given normals */
};

/* A known one of the place; 0: there is none. Canonical order puts unknown normals, whose bits are
 * all 0, before known ones: the last splat of a place tells. */
static struct vec3 normal_of_place(const struct mend *m, size_t place)
{
    bool last = place + 1 == m->places->count;
    size_t end = last ? m->splats->count : splat_of(m->places, place + 1);
    return v3_loadf(m->splats->normal[end - 1]);
}

static void look_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct mend *m = context;
    for (size_t i = begin; i < end; i++) {
        struct surrounding around;
        struct lost *l = &m->lost[i];
        surrounding_of(m->tree, place_of(m->places, l->splat), &around);
        memcpy(l->neighbour, around.neighbour, sizeof l->neighbour);
        v3_storef(v3_load(around.normal), l->plane);
    }
}

/* Of those that are known now; *nearest: the nearest of them. */
static struct vec3 sum_of_neighbours(const struct mend *m, const struct lost *l,
                                     struct vec3 *nearest)
{
    struct vec3 sum = *nearest = v3(0, 0, 0);
    for (unsigned k = SURROUND_GRAPH; k-- > 0;) {
        if (l->neighbour[k] == NO_NEIGHBOUR)
            continue;
        struct vec3 normal = normal_of_place(m, l->neighbour[k]);
        *nearest = v3_length(normal) > 0 ? normal : *nearest;
        sum = v3_add(sum, normal);
    }
    return sum;
}

/* Given normals are averaged. Averages of averages would flatten what is far from all given ones:
 * there the plane is taken, and only its side is handed on. */
static struct vec3 mended_normal(const struct mend *m, const struct lost *l)
{
    struct vec3 nearest, own = normal_of_place(m, place_of(m->places, l->splat));
    if (v3_length(own) > 0)
        return own;
    struct vec3 sum = sum_of_neighbours(m, l, &nearest), plane = v3_loadf(l->plane);
    if (v3_length(nearest) == 0)
        return v3(0, 0, 0);
    if (v3_length(sum) > 0.1 && (m->first || v3_length(plane) == 0))
        return v3_unit(sum);
    return v3_dot(plane, v3_length(sum) > 0.1 ? sum : nearest) < 0 ? v3_scale(plane, -1) : plane;
}

static void mend_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct mend *m = context;
    for (size_t i = begin; i < end; i++)
        v3_storef(mended_normal(m, &m->lost[i]), m->lost[i].normal);
}

/* Those that were found become known; returns how many are left. */
static size_t show_found(const struct mend *m, size_t count)
{
    size_t left = 0;
    for (size_t i = 0; i < count; i++)
        if (normal_is_unknown(m->lost[i].normal))
            m->lost[left++] = m->lost[i];
        else
            memcpy(m->splats->normal[m->lost[i].splat], m->lost[i].normal,
                   sizeof m->lost[i].normal);
    return left;
}

/* What no known one is joined to by neighbours faces away from the middle. */
static void face_outward(const struct mend *m, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        size_t splat = m->lost[i].splat;
        struct vec3 plane = v3_loadf(m->lost[i].plane),
                    out = v3_sub(v3_load(m->splats->position[splat]), m->middle);
        v3_storef(v3_dot(plane, out) < 0 ? v3_scale(plane, -1) : plane, m->splats->normal[splat]);
    }
}

static struct vec3 middle_of(const struct places *places)
{
    struct vec3 first = v3_load(places->position[0]), sum = v3(0, 0, 0);
    for (size_t i = 0; i < places->count; i++)
        sum = v3_add(sum, v3_sub(v3_load(places->position[i]), first));
    return v3_add(first, v3_scale(sum, 1 / (double)places->count));
}

/* Rounds from the rims of what is lost inwards: none reads what it writes, so that the order of
 * splats does not tell. */
static void mend_all(const struct stp_env *env, struct mend *m, size_t count)
{
    size_t before = SIZE_MAX;
    parallel_for(env, count, 256, look_range, m);
    while (count < before) {
        before = count;
        parallel_for(env, count, 256, mend_range, m);
        count = show_found(m, count);
        m->first = false;
    }
    face_outward(m, count);
}

enum stp_result normals_mend(const struct stp_env *env, struct splats *s,
                             const struct places *places, const struct neighbour_tree *tree)
{
    size_t unknown = normals_unknown(s), at = 0;
    struct lost *lost = mem_alloc(unknown, sizeof *lost);
    if (!lost)
        return log_no_memory(env, unknown * sizeof *lost, "normals");
    for (size_t i = 0; i < s->count; i++)
        if (normal_is_unknown(s->normal[i]))
            lost[at++].splat = (uint32_t)i;
    struct mend m = { s, places, tree, lost, middle_of(places), .first = true };
    mend_all(env, &m, unknown);
    mem_free(lost);
    return STP_OK;
}
