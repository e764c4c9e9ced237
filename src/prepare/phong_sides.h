/* The sites around one, and planes fitted to parts of them (k-planes). */
#ifndef STP_PREPARE_PHONG_SIDES_H
#define STP_PREPARE_PHONG_SIDES_H

#include <math.h>

#include "prepare/phong_crease.h"

#define BALL_MOST   48 /* sites looked at */
#define SIDE_FEWEST 5  /* sites of a side */

struct ball {
    unsigned count;
    uint32_t site[BALL_MOST];
    struct vec3 p[BALL_MOST]; /* relative to the middle one */
    unsigned char side[BALL_MOST];
    double radius; /* root mean square */
};

struct sides {
    unsigned count;
    struct fit_plane plane[MOST_SIDES];     /* relative to the ball's middle */
    double deviation[MOST_SIDES], all, one; /* root mean square; of one plane for all */
};

/* The nearest sites of i in the graph, itself first. */
void ball_gather(const struct fit_cloud *cloud, uint32_t i, struct ball *b);

/* The site, of the ball, whose normal is least like any of those given. */
unsigned ball_most_unlike(const struct fit_cloud *cloud, const struct ball *b,
                          const struct vec3 *normal, unsigned count);

/* The least-squares plane of a side, and its root mean square deviation; false: too few sites, or
 * all in a line. side MOST_SIDES: of all. */
bool side_fit(const struct ball *b, unsigned side, struct fit_plane *plane, double *deviation);

/* Splits the ball's sites among `count` planes, starting from sites with unlike normals; false:
 * some plane was left with too few. */
bool sides_split(const struct fit_cloud *cloud, struct ball *b, unsigned count, struct sides *s);

static inline double off_plane(const struct fit_plane *plane, struct vec3 p)
{
    return fabs(v3_dot(plane->n, p) + plane->d);
}

#endif
