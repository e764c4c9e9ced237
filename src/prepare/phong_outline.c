#include "prepare/phong_outline.h"

#include <math.h>
#include <string.h>

#include "prepare/phong_ellipse.h"
#include "prepare/phong_fence.h"

/* Of the mean spacing of a splat's sites: how far its axes reach beyond them, so that the surface
 * between the sites of neighbouring splats is covered too. Splats of few sites overlap less. */
#define GAP     0.5
#define GAP_FEW 0.7 /* over the root of the count */
#define DEAR    8   /* times its area is what the picture loses by what overhangs */

struct outliner {
    const struct fit_cloud *cloud;
    const struct patch *patch;
    const struct patch_frame *frame;
    struct fences fences;
    double (*point)[2];
    size_t count;
    double spacing;
};

/* Samples whose discs do not touch are no one surface: there a gap is no wider than their discs. */
static double mean_spacing(const struct fit_cloud *cloud, const struct patch *p)
{
    double sum = 0;
    for (uint32_t k = 0; k < p->count; k++) {
        uint32_t sample = cloud->first[p->member[k]];
        sum += fmin((double)cloud->site[p->member[k]].spacing,
                    2 * (double)cloud->samples->radius[sample]);
    }
    return sum / p->count;
}

/* Where members are in the frame's plane, and the feet of those near an edge. */
static void project(struct outliner *w, const struct clip_lines *lines, double gap)
{
    const struct patch *p = w->patch;
    w->count = p->count;
    for (uint32_t k = 0; k < p->count; k++) {
        struct xy at = in_plane(w->cloud, p->member[k], w->frame);
        w->point[k][0] = at.x;
        w->point[k][1] = at.y;
    }
    for (uint32_t k = 0; lines->count > 0 && k < p->count; k++)
        w->count += clip_feet(lines, w->point[k][0], w->point[k][1], 4 * gap, w->point + w->count);
}

/* The ellipse about the seed, of the shape that the patch grew in. */
static void grown_ellipse(const struct outliner *w, double center[2], double radius[2])
{
    struct xy seed = in_plane(w->cloud, w->patch->seed, w->frame);
    double most = 0, ratio = sqrt(w->patch->shape);
    center[0] = seed.x;
    center[1] = seed.y;
    for (size_t k = 0; k < w->count; k++)
        most = fmax(most, hypot((w->point[k][0] - center[0]) / ratio,
                                (w->point[k][1] - center[1]) * ratio));
    radius[0] = most * ratio * (1 + 1e-12);
    radius[1] = most / ratio * (1 + 1e-12);
}

static double overhang_of(const struct outliner *w, const struct outline *o)
{
    double reach[2] = { o->radius[0] + o->gap, o->radius[1] + o->gap };
    return fences_overhang(&w->fences, (const double(*)[2])w->point, w->patch->count, &o->lines,
                           o->center, reach);
}

/* The minimum enclosing ellipse; of a patch at edges, the better of two, for the ends of a strip
 * between edges stick out of the one and the far side of a patch that grew from its border out of
 * the other: what the lines leave, and most of all what they leave beyond other edges, is to be
 * least. */
static void fit_ellipse(const struct outliner *w, struct outline *o)
{
    struct outline other = *o;
    ellipse_enclose((const double(*)[2])w->point, w->count, 0.1 * o->gap, o->center, o->radius);
    o->overhang = 0;
    if (w->fences.count == 0 && o->lines.count == 0)
        return;
    grown_ellipse(w, other.center, other.radius);
    o->overhang = overhang_of(w, o);
    other.overhang = overhang_of(w, &other);
    if (clip_area(&other.lines, other.center, other.radius) + DEAR * other.overhang <
        clip_area(&o->lines, o->center, o->radius) + DEAR * o->overhang)
        *o = other;
    o->overhang /= w->spacing * w->spacing;
}

void patch_outline(const struct fit_cloud *cloud, const struct patch *patch,
                   const struct patch_frame *frame, double tolerance, double (*room)[2],
                   struct outline *outline)
{
    struct outliner w = { .cloud = cloud, .patch = patch, .frame = frame, .point = room };
    double share = GAP + GAP_FEW / sqrt(patch->count);
    w.spacing = mean_spacing(cloud, patch);
    if (!(w.spacing > 0))
        w.spacing = (double)cloud->samples->radius[cloud->first[patch->seed]];
    outline->gap = share * w.spacing;
    patch_clips(cloud, patch, frame, tolerance, &outline->lines);
    project(&w, &outline->lines, outline->gap);
    fences_gather(cloud, patch, frame, fmax(tolerance, BENT * w.spacing), w.spacing, &w.fences);
    fit_ellipse(&w, outline);
}
