/* ZP 4.2: groups that each cover the surface, for transparency. The surface is what the discs
 * themselves cover: a point of disc i is covered by disc j when it lies within j's radius, seen
 * along j's normal, and within epsilon of its plane, both face the same way, and are of one object:
 * they are then fragments of one layer. All areas are sampled; every splat's points are weighted by
 * one over the number of discs that cover them, so that overlaps count once (ZP Eq. 7 counts them
 * twice).
 *
 * What each step needs is filled by the one before it: masks, assign, then duplicate or enlarge. */
#ifndef STP_PREPARE_DEFERRED_COVER_H
#define STP_PREPARE_DEFERRED_COVER_H

#include "prepare/prepare.h"

#define COVER_POINTS 32 /* of a disc while groups are made: a bit each */

/* Splats that take no part: COVER_OUT ones are in no group, being equal to their predecessor
 * or of opacity 0;
 * COVER_CROWDED ones lie in heaps, under many larger ones, and are dealt to the groups in turn. */
enum { COVER_OUT = 1, COVER_CROWDED = 2 };

struct cover {
    const struct stp_env *env;
    const struct splats *splats;
    const double *epsilon;      /* one an object */
    unsigned groups;            /* K */
    struct overlap_graph graph; /* of discs that may cover each other */
    uint8_t *skip;              /* one of the above, or 0 */
    uint32_t **mask;            /* beside every edge: the points of i that the neighbour covers */
    uint8_t (*depth)[COVER_POINTS]; /* how many discs cover a point, at least 1, at most 255 */
    uint8_t *home;                  /* the group at first; 255: none */
    uint64_t *member;               /* bit k: the splat is in group k */
};

/* Fills mask and depth. */
enum stp_result cover_masks_build(struct cover *cover);
/* The mask of i's points under its neighbour number e; that of j's points under i. */
uint32_t cover_edge(const struct cover *cover, size_t i, size_t e);
uint32_t cover_edge_back(const struct cover *cover, size_t i, size_t j);

/* Every splat to the group whose members cover it least, over and over in canonical order until
 * few move: groups of like size that overlap themselves little. Those left out take turns. */
void cover_assign(struct cover *cover);

/* Adds splats to groups, largest new area first, until each covers `target` of the surface or has
 * taken `room` of them. */
enum stp_result cover_duplicate(struct cover *cover, double target, size_t room);

/* Share of the surface that each group covers when its radii are multiplied by factor[k], from
 * points that no other step has seen: about `budget` of them, at least one a splat counted. The
 * standard error of a share is sqrt(share (1 - share) / points) at most. */
enum stp_result cover_measure(const struct cover *cover, const double *factor, size_t budget,
                              double *share, size_t *points);

/* ZP Eq. 9, one factor a group: from factor[k] = 1 up to `most` until the group covers `target`
 * but for a 2000th of the surface. It never falls, and stops. The graph reaches
 * (1 + most) / 2 times the radii's sum: what a much larger disc covers beyond that is not seen, so
 * shares are never overstated. */
enum stp_result cover_enlarge(const struct cover *cover, double target, double most,
                              double *factor);

#endif
