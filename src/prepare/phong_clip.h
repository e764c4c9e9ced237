/* BSK Fig. 9: the clip lines of a patch that ends at a sharp feature. */
#ifndef STP_PREPARE_PHONG_CLIP_H
#define STP_PREPARE_PHONG_CLIP_H

#include "prepare/phong_fit.h"

#define BENT 0.12 /* spacings: an edge may leave its line by so much */

struct fit_plane;

/* In a frame's plane, from its c. */
struct xy {
    double x, y;
};

static inline struct xy in_plane(const struct fit_cloud *cloud, uint32_t site,
                                 const struct patch_frame *f)
{
    struct vec3 d = v3_sub(v3_load(cloud->site[site].p), f->c);
    return (struct xy){ v3_dot(d, f->u), v3_dot(d, f->v) };
}

static inline double line_at(const double line[3], struct xy p)
{
    return line[0] * p.x + line[1] * p.y + line[2];
}

/* In the frame's plane, from its c: a x + b y + c >= 0 is kept, a^2 + b^2 = 1. */
struct clip_lines {
    unsigned count;
    bool reflex; /* of two: either may keep it */
    double line[2][3];
};

/* The edges that a patch has met while it grows: two lines are all that a splat can carry. */
struct clip_track {
    struct clip_lines found; /* the first line of each edge, either way round */
    double sum[2][3];        /* of all lines of that edge */
    double x, y;             /* sums over the sites */
    unsigned sites;
};
/* Takes a site in, and the edges beside it. False: it lies beyond the edges, or at a third one, or
 * where an edge is too bent for a line. slack: of a site from its edge's line. */
bool clip_admits(const struct fit_cloud *cloud, const struct patch_frame *frame, uint32_t site,
                 double slack, struct clip_track *track);

/* Is any member near a sharp feature? */
bool patch_is_at_edges(const struct fit_cloud *cloud, const struct patch *patch);

/* The line where the plane meets the frame's; false: they are nearly parallel. */
bool clip_meet(const struct fit_plane *plane, const struct patch_frame *f, double line[3]);

/* About how much of the ellipse about the frame's c the edges leave: a share of its area. */
double clip_share(const struct clip_track *track, const double radius[2]);

/* The lines where the frame's plane meets the other sides' planes. Every member is kept; where
 * lines that keep all would be off the edge by more than `slack` beyond their member's spacing,
 * there are none. */
void patch_clips(const struct fit_cloud *cloud, const struct patch *patch,
                 const struct patch_frame *frame, double slack, struct clip_lines *lines);

/* The area that is left of an ellipse, in the frame's plane. */
double clip_area(const struct clip_lines *lines, const double center[2], const double radius[2]);

/* The point of the edges that belongs to a member near them, for the ellipse to reach: returns how
 * many of xy were filled. */
unsigned clip_feet(const struct clip_lines *lines, double x, double y, double reach,
                   double xy[3][2]);

#endif
