#include "prepare/places.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"

/* Canonical order puts equal positions side by side. */
static bool is_new_place(const struct splats *s, size_t i)
{
    return i == 0 || memcmp(s->position[i], s->position[i - 1], sizeof s->position[i]) != 0;
}

static void fill(const struct splats *s, struct places *p)
{
    size_t place = 0;
    for (size_t i = 0; i < s->count; i++) {
        if (is_new_place(s, i)) {
            memcpy(p->owned[place], s->position[i], sizeof p->owned[place]);
            p->first[place++] = (uint32_t)i;
        }
        p->of[i] = (uint32_t)(place - 1);
    }
}

enum stp_result places_find(const struct stp_env *env, const struct splats *s,
                            struct places *places)
{
    struct places p = { .position = (const double(*)[3])s->position };
    for (size_t i = 0; i < s->count; i++)
        p.count += is_new_place(s, i);
    if (p.count < s->count) {
        p.owned = mem_alloc(p.count, sizeof *p.owned);
        p.of = mem_alloc(s->count, sizeof *p.of);
        p.first = mem_alloc(p.count, sizeof *p.first);
        if (!p.owned || !p.of || !p.first) {
            places_release(&p);
            return log_no_memory(env, s->count * sizeof *p.owned, "distinct positions");
        }
        fill(s, &p);
        p.position = (const double(*)[3])p.owned;
    }
    *places = p;
    return STP_OK;
}

void places_release(struct places *places)
{
    mem_free(places->owned);
    mem_free(places->of);
    mem_free(places->first);
    *places = (struct places){ 0 };
}
