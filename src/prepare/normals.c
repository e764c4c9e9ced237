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

struct mend {
    const struct splats *splats;
    const struct places *places;
    const struct neighbour_tree *tree;
    const uint32_t *bad;
    float (*normal)[3]; /* of the bad ones: the given ones stay readable */
};

/* A known one of the place; 0: there is none. Canonical order puts unknown normals, whose bits are
 * all 0, before known ones: the last splat of a place tells. */
static struct vec3 normal_of_place(const struct mend *m, size_t place)
{
    bool last = place + 1 == m->places->count;
    size_t end = last ? m->splats->count : splat_of(m->places, place + 1);
    return v3_loadf(m->splats->normal[end - 1]);
}

static struct vec3 mended_normal(const struct mend *m, size_t i)
{
    struct surrounding around;
    size_t place = place_of(m->places, i);
    struct vec3 sum = v3(0, 0, 0), nearest = v3(0, 0, 0), own = normal_of_place(m, place);
    if (v3_length(own) > 0)
        return own;
    surrounding_of(m->tree, place, &around);
    for (unsigned k = SURROUND_GRAPH; k-- > 0;) {
        if (around.neighbour[k] == NO_NEIGHBOUR)
            continue;
        struct vec3 normal = normal_of_place(m, around.neighbour[k]);
        nearest = v3_length(normal) > 0 ? normal : nearest;
        sum = v3_add(sum, normal);
    }
    if (v3_length(sum) > 0.1)
        return v3_unit(sum);
    struct vec3 plane = v3_load(around.normal);
    return v3_dot(plane, nearest) < 0 ? v3_scale(plane, -1) : plane;
}

static void mend_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct mend *m = context;
    for (size_t i = begin; i < end; i++) {
        struct vec3 n = mended_normal(m, m->bad[i]);
        v3_storef(n, m->normal[i]);
    }
}

enum stp_result normals_mend(const struct stp_env *env, struct splats *s,
                             const struct places *places, const struct neighbour_tree *tree)
{
    size_t unknown = normals_unknown(s), at = 0;
    uint32_t *bad = mem_alloc(unknown, sizeof *bad);
    struct mend m = { s, places, tree, bad, mem_alloc(unknown, sizeof *m.normal) };
    if (bad && m.normal) {
        for (size_t i = 0; i < s->count; i++)
            if (normal_is_unknown(s->normal[i]))
                bad[at++] = (uint32_t)i;
        parallel_for(env, unknown, 256, mend_range, &m);
        for (size_t i = 0; i < unknown; i++)
            memcpy(s->normal[bad[i]], m.normal[i], sizeof m.normal[i]);
    }
    bool done = bad && m.normal;
    mem_free(bad);
    mem_free(m.normal);
    return done ? STP_OK : log_no_memory(env, unknown * 16, "normals");
}
