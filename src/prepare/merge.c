#include "prepare/merge.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/phong.h"

/* One attribute at a time: only one array is ever there twice. */
static void *join(struct splats *sets, unsigned count, size_t total, size_t offset, size_t size)
{
    char *joined = mem_alloc(total, size);
    size_t at = 0;
    for (unsigned i = 0; joined && i < count; i++) {
        void **array = (void **)((char *)&sets[i] + offset);
        if (sets[i].count > 0)
            memcpy(joined + at * size, *array, sets[i].count * size);
        at += sets[i].count;
        mem_free(*array);
        *array = NULL;
    }
    return joined;
}

#define JOIN(member)                                                                               \
    ((merged->member = join(sets, count, total, offsetof(struct splats, member),                   \
                            sizeof *merged->member)) != NULL)

static bool join_all(struct splats *sets, unsigned count, size_t total, struct splats *merged)
{
    bool color = false, opacity = false, phong = false;
    for (unsigned i = 0; i < count; i++) {
        phong |= sets[i].phong != NULL;
        color |= sets[i].color != NULL;
        opacity |= sets[i].opacity != NULL;
    }
    return JOIN(position) && JOIN(normal) && JOIN(radius) && JOIN(input) &&
           (!color || JOIN(color)) && (!opacity || JOIN(opacity)) && (!phong || JOIN(phong));
}

static bool fill_opacity(struct splats *sets, unsigned count)
{
    bool any = false;
    for (unsigned i = 0; i < count; i++)
        any |= sets[i].opacity != NULL;
    for (unsigned i = 0; any && i < count; i++) {
        if (sets[i].opacity)
            continue;
        sets[i].opacity = mem_alloc(sets[i].count, sizeof(float));
        if (!sets[i].opacity)
            return false;
        for (size_t j = 0; j < sets[i].count; j++)
            sets[i].opacity[j] = 1;
    }
    return true;
}

/* Sets of discs, where others have ellipses. */
static bool fill_phong(struct splats *sets, unsigned count)
{
    bool any = false;
    for (unsigned i = 0; i < count; i++)
        any |= sets[i].phong != NULL;
    for (unsigned i = 0; any && i < count; i++) {
        if (sets[i].phong)
            continue;
        sets[i].phong = mem_alloc(sets[i].count, sizeof *sets[i].phong);
        if (!sets[i].phong)
            return false;
        for (size_t j = 0; j < sets[i].count; j++)
            sets[i].phong[j] = phong_of_disc(sets[i].normal[j], sets[i].radius[j]);
    }
    return true;
}

enum stp_result merge_splats(const struct stp_env *env, struct splats *sets, unsigned count,
                             const size_t *first_input, struct splats *merged)
{
    size_t total = 0, at = 0;
    for (unsigned i = 0; i < count; i++)
        total += sets[i].count;
    struct splats m = { .count = total, .object = mem_alloc(total, sizeof *m.object) };
    if (!m.object || !fill_opacity(sets, count) || !fill_phong(sets, count) ||
        !join_all(sets, count, total, &m)) {
        splats_release(&m);
        return log_no_memory(env, total * 24, "the objects' splats");
    }
    for (unsigned i = 0; i < count; i++)
        for (size_t end = at + sets[i].count; at < end; at++) {
            m.object[at] = (uint16_t)i;
            m.input[at] += (uint32_t)first_input[i];
        }
    *merged = m;
    return STP_OK;
}
