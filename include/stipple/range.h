/* Range images: posed frames of depth and colour, drawn as what is known of the surface: every
 * pixel a Gaussian ellipsoid, stretched along its ray by the uncertainty of its depth
 * (docs/range.md). */
#ifndef STIPPLE_RANGE_H
#define STIPPLE_RANGE_H

#include <stipple/result.h>

#ifdef __cplusplus
extern "C" {
#endif

enum stp_range_splats {
    STP_RANGE_AUTO = 0, /* what a scene .json says, else ellipsoids */
    STP_RANGE_ELLIPSOIDS,
    STP_RANGE_DISCS, /* plain discs of the same points: an ordinary scene of one object */
};

/* How range images are read and shown; what is set wins over a scene .json. */
struct stp_range_params {
    enum stp_range_splats splats;
    double uncertainty; /* times the deviation of every depth; 0: 1; negative: 0 */
};

/* What is known of a scene's range images; facts.points counts their pixels, facts.splats the
 * ellipsoids. */
struct stp_range_facts {
    unsigned frames;         /* 0: the scene has no range images, or they are discs */
    size_t holes;            /* pixels without a reading */
    double deviation_median; /* of the depths, scene units, times uncertainty */
    double sources;          /* frames that see a point, its own included, on average */
    bool by_views;           /* colours of all frames, by their angles */
};

#ifdef __cplusplus
}
#endif
#endif
