/* The edges around a patch, bit by bit, whether its clip lines follow them or not: what an ellipse
 * shows beyond them overhangs. Two lines a splat leave a third edge open, and the end of a line the
 * bend of its edge. */
#ifndef STP_PREPARE_PHONG_FENCE_H
#define STP_PREPARE_PHONG_FENCE_H

#include "prepare/phong_clip.h"

#define FENCES_MOST 96

/* A bit of an edge near its foot; the patch is where the line is positive. */
struct fence {
    double line[3];
    struct xy foot;
};

struct fences {
    unsigned count;
    double slack;   /* so far beyond is still at the edge */
    double spacing; /* of the sites */
    struct fence fence[FENCES_MOST];
};

/* The edges that members lie beside. */
void fences_gather(const struct fit_cloud *cloud, const struct patch *patch,
                   const struct patch_frame *frame, double slack, double spacing,
                   struct fences *fences);

/* Of the ellipse that the lines leave, the area beyond the nearest fence where no member is near,
 * and all that is far from any: points are the members' places. 0 where there is no fence. */
double fences_overhang(const struct fences *fences, const double (*point)[2], size_t count,
                       const struct clip_lines *lines, const double center[2],
                       const double radius[2]);

#endif
