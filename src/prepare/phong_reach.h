/* The sites that an ellipse about a seed reaches, over chains of neighbours. */
#ifndef STP_PREPARE_PHONG_REACH_H
#define STP_PREPARE_PHONG_REACH_H

#include "prepare/phong_fit.h"

/* About the seed's place, frame.c. */
struct ellipse {
    struct patch_frame frame;
    double radius[2];
};

struct reached {
    double metric; /* s^2 + t^2; below 0: the seed, which comes before sites of its own place */
    uint32_t site;
};

/* A worker's own. */
struct reach {
    const struct fit_cloud *cloud;
    const struct fit_limits *limits;
    uint32_t *stamp, tick; /* of the sites seen */
    struct reached *list, *sorted;
    uint32_t *bucket;
    size_t capacity;
};

enum stp_result reach_open(struct reach *r, const struct fit_cloud *cloud,
                           const struct fit_limits *limits);
void reach_release(struct reach *r);

/* Collects, into the list, in no order but the seed first; stops when it has `most`. *blocked: the
 * metric of the nearest site that is so far off the plane, or of such a colour, that no patch about
 * the seed can hold it. Returns how many; 0: there is no memory. */
size_t reach_collect(struct reach *r, const struct ellipse *e, uint32_t seed, size_t most,
                     double *blocked);

/* Of the first `count` of the list those below the metric, by metric, then by site. */
size_t reach_sort(struct reach *r, size_t count, double below);

/* Sorts so; room and bucket: count of each. Time is in proportion to the count where metrics are
 * spread about evenly, as those of even samples are. */
void reached_sort(struct reached *list, size_t count, struct reached *room, uint32_t *bucket);

#endif
