/* The distinct positions of splats in canonical order: a heap of coincident points is one place, so
 * that it neither hides its surroundings nor makes their search slow. */
#ifndef STP_PREPARE_PLACES_H
#define STP_PREPARE_PLACES_H

#include "scene/splats.h"

struct places {
    size_t count;
    const double (*position)[3]; /* the splats' own where all are distinct */
    double (*owned)[3];          /* else these; NULL where all are distinct, as of and first are */
    uint32_t *of;                /* a splat: its place */
    uint32_t *first;             /* a place: its first splat */
};

enum stp_result places_find(const struct stp_env *env, const struct splats *splats,
                            struct places *places);
void places_release(struct places *places);

static inline size_t place_of(const struct places *p, size_t splat)
{
    return p->of ? p->of[splat] : splat;
}
static inline size_t splat_of(const struct places *p, size_t place)
{
    return p->first ? p->first[place] : place;
}

#endif
