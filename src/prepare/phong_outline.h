/* The ellipse of a patch and its clip lines (BSK Eq. 1, Fig. 9), in the patch's plane. */
#ifndef STP_PREPARE_PHONG_OUTLINE_H
#define STP_PREPARE_PHONG_OUTLINE_H

#include "prepare/phong_clip.h"

struct outline {
    struct clip_lines lines;
    double center[2], radius[2]; /* from the frame's c; every member is inside */
    double gap;                  /* what the axes reach beyond `radius` */
    double overhang;             /* what is shown beyond an edge, in squares of the spacing */
};

/* tolerance: of the fit. room: 4 places a member. */
void patch_outline(const struct fit_cloud *cloud, const struct patch *patch,
                   const struct patch_frame *frame, double tolerance, double (*room)[2],
                   struct outline *outline);

#endif
