/* What the nearest neighbours say of each place (places.h): its tangent plane and local spacing. */
#ifndef STP_PREPARE_SURROUNDINGS_H
#define STP_PREPARE_SURROUNDINGS_H

#include "prepare/neighbours.h"

#define SURROUND_NEAREST 12 /* for the plane; more where these lie on a line */
#define SURROUND_GRAPH   8  /* neighbours kept */
#define NO_NEIGHBOUR     UINT32_MAX

struct surrounding {
    double normal[3]; /* unit, of the least-squares plane, either sign; 0: no plane (coincident or
                         collinear, even among MAX_NEAREST) */
    double spacing;   /* distance to the 8th neighbour (fewer in tiny clouds): discs of this
                         radius close a Poisson-random plane but for 1e-6 of it; where the nearest lie
                         on a scan line, at least the distance to the next line; 0: all coincide */
    uint32_t neighbour[SURROUND_GRAPH]; /* nearest first; NO_NEIGHBOUR where there are fewer */
};
void surrounding_of(const struct neighbour_tree *tree, size_t i, struct surrounding *s);

/* Of every point. */
struct surroundings {
    float (*normal)[3]; /* NULL unless wanted */
    float *spacing;
    uint32_t (*neighbour)[SURROUND_GRAPH];
};
enum stp_result surroundings_find(const struct stp_env *env, const struct neighbour_tree *tree,
                                  bool want_normal, struct surroundings *all);
void surroundings_release(struct surroundings *all);

#endif
