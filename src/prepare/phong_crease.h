/* Sharp features of samples: edges where two planes meet, corners of three. */
#ifndef STP_PREPARE_PHONG_CREASE_H
#define STP_PREPARE_PHONG_CREASE_H

#include "prepare/phong_fit.h"

#define MOST_SIDES 3

/* n.p + d = 0, p relative to the cloud's origin. */
struct fit_plane {
    struct vec3 n;
    double d;
};

/* Of a site near a sharp feature: the planes of the other sides. */
struct crease {
    unsigned sides; /* 1: an edge, 2: a corner */
    struct fit_plane side[MOST_SIDES - 1];
};

/* Finds the cloud's creases. Sites near them get their own side's normal (those on an edge of a
 * mesh carry a mean of both sides'), and are no longer neighbours of sites across the edge. */
enum stp_result creases_find(const struct stp_env *env, struct fit_cloud *cloud);

#endif
