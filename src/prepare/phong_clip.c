#include "prepare/phong_clip.h"

#include <math.h>
#include <string.h>

#include "prepare/phong_crease.h"

#define ONE_EDGE 0.9 /* cosine, 26 degrees: lines of one, perhaps curved, edge */
#define STEEP    0.3 /* sine of the least angle between the planes of a line */
#define BESIDE   1.0 /* spacings: a site so near an edge is at it */
#define THIRD                                                                                      \
    2.0 /* spacings: so near a third edge no line cuts the ellipse that reaches beyond             \
         */
#define SPACINGS 0.75 /* a member may be so far beyond the edge where samples straddle it */

#define AREA_GRID 24
#define PI        3.14159265358979323846

bool patch_is_at_edges(const struct fit_cloud *cloud, const struct patch *patch)
{
    for (uint32_t k = 0; cloud->crease && k < patch->count; k++)
        if (cloud->crease_of[patch->member[k]] != NO_SITE)
            return true;
    return false;
}

bool clip_meet(const struct fit_plane *plane, const struct patch_frame *f, double line[3])
{
    double a = v3_dot(plane->n, f->u), b = v3_dot(plane->n, f->v);
    double length = hypot(a, b);
    if (length < STEEP * v3_length(plane->n))
        return false;
    line[0] = a / length;
    line[1] = b / length;
    line[2] = (v3_dot(plane->n, f->c) + plane->d) / length;
    return true;
}

/* The edge that the line belongs to; -1: a new one. */
static int known_edge(const struct clip_track *track, const double line[3], struct xy foot,
                      double allowed)
{
    for (unsigned i = 0; i < track->found.count; i++) {
        const double *l = track->found.line[i];
        if (fabs(l[0] * line[0] + l[1] * line[1]) > ONE_EDGE && fabs(line_at(l, foot)) <= allowed)
            return (int)i;
    }
    return -1;
}

/* Two lines can be the sides of one reflex corner: not where they are nearly parallel. */
static bool can_be_reflex(const struct clip_lines *lines)
{
    const double *p = lines->line[0], *q = lines->line[1];
    return lines->count == 2 && fabs(p[0] * q[1] - p[1] * q[0]) > STEEP;
}

/* Is p beyond the edges, seen from the middle of the sites so far? Beyond any; round a reflex
 * corner, beyond both. */
static bool is_beyond(const struct clip_track *track, struct xy p, double allowed)
{
    struct xy middle = { track->x / track->sites, track->y / track->sites };
    unsigned beyond = 0, count = track->found.count;
    for (unsigned i = 0; i < count; i++) {
        const double *l = track->found.line[i];
        double off = line_at(l, p);
        beyond += fabs(off) > allowed && off * line_at(l, middle) <= 0;
    }
    return beyond > (can_be_reflex(&track->found) ? 1u : 0u);
}

/* Adds the site's edges; false: there would be a third. */
static bool note_edges(const struct fit_cloud *cloud, const struct patch_frame *frame,
                       uint32_t site, double slack, struct clip_track *track)
{
    uint32_t id = cloud->crease ? cloud->crease_of[site] : NO_SITE;
    double spacing = (double)cloud->site[site].spacing;
    struct xy p = in_plane(cloud, site, frame);
    for (unsigned i = 0; id != NO_SITE && i < cloud->crease[id].sides; i++) {
        double line[3], off, sign;
        if (!clip_meet(&cloud->crease[id].side[i], frame, line))
            continue;
        off = line_at(line, p);
        struct xy foot = { p.x - off * line[0], p.y - off * line[1] };
        int edge = known_edge(track, line, foot, fmax(slack, BENT * spacing));
        if (edge < 0 && track->found.count == 2 && fabs(off) <= THIRD * spacing)
            return false;
        if (fabs(off) > BESIDE * spacing)
            continue;
        if (edge < 0) {
            edge = (int)track->found.count++;
            memcpy(track->found.line[edge], line, sizeof line);
        }
        const double *first = track->found.line[edge];
        sign = first[0] * line[0] + first[1] * line[1] < 0 ? -1 : 1;
        for (int j = 0; j < 3; j++)
            track->sum[edge][j] += sign * line[j];
    }
    return true;
}

bool clip_admits(const struct fit_cloud *cloud, const struct patch_frame *frame, uint32_t site,
                 double slack, struct clip_track *track)
{
    if (!cloud->crease)
        return true;
    struct xy p = in_plane(cloud, site, frame);
    double allowed = fmax(slack, 0.5 * SPACINGS * (double)cloud->site[site].spacing);
    if (is_beyond(track, p, allowed) || !note_edges(cloud, frame, site, slack, track))
        return false;
    track->x += p.x;
    track->y += p.y;
    track->sites++;
    return true;
}

/* Of the unit disc, on the origin's side of a line at this distance. */
static double segment_share(double h)
{
    return h >= 1 ? 1 : h <= -1 ? 0 : 1 - (acos(h) - h * sqrt(1 - h * h)) / PI;
}

double clip_share(const struct clip_track *track, const double radius[2])
{
    struct xy middle = { track->x / track->sites, track->y / track->sites };
    double share = 1;
    for (unsigned i = 0; i < track->found.count; i++) {
        const double *l = track->found.line[i];
        double h = l[2] / hypot(l[0] * radius[0], l[1] * radius[1]);
        share -= 1 - segment_share(line_at(l, middle) < 0 ? -h : h);
    }
    return fmax(share, 0.05);
}

double clip_area(const struct clip_lines *lines, const double center[2], const double radius[2])
{
    unsigned kept = 0, all = 0;
    for (int i = 0; i < AREA_GRID * AREA_GRID; i++) {
        double s = (i % AREA_GRID * 2 + 1.0) / AREA_GRID - 1;
        double t = (i / AREA_GRID * 2 + 1.0) / AREA_GRID - 1;
        struct xy p = { center[0] + s * radius[0], center[1] + t * radius[1] };
        unsigned on = 0;
        if (s * s + t * t > 1)
            continue;
        for (unsigned k = 0; k < lines->count; k++)
            on += line_at(lines->line[k], p) >= 0;
        all++;
        kept += lines->reflex ? on > 0 : on == lines->count;
    }
    return PI * radius[0] * radius[1] * kept / all;
}

/* Each edge's mean line. */
static void mean_lines(const struct clip_track *track, struct clip_lines *lines)
{
    for (unsigned i = 0; i < track->found.count; i++) {
        double length = hypot(track->sum[i][0], track->sum[i][1]);
        for (int j = 0; j < 3 && length > 0; j++)
            lines->line[lines->count][j] = track->sum[i][j] / length;
        lines->count += length > 0;
    }
}

/* Keeps the side on which the members lie. */
static void turn_line(const struct fit_cloud *cloud, const struct patch *patch,
                      const struct patch_frame *f, double line[3])
{
    double sum = 0;
    for (uint32_t k = 0; k < patch->count; k++)
        sum += line_at(line, in_plane(cloud, patch->member[k], f));
    for (int j = 0; sum < 0 && j < 3; j++)
        line[j] = -line[j];
}

/* How far outwards the lines must move to keep every member: where both must, each line by its own
 * worst; where either may, by the lesser of a member's two. False: farther than is allowed. */
static bool keep_members(const struct fit_cloud *cloud, const struct patch *patch,
                         const struct patch_frame *f, double slack, struct clip_lines *lines)
{
    double move[2] = { 0, 0 };
    for (uint32_t k = 0; k < patch->count; k++) {
        struct xy p = in_plane(cloud, patch->member[k], f);
        double off[2] = { -line_at(lines->line[0], p),
                          lines->count > 1 ? -line_at(lines->line[1], p) : -INFINITY };
        double allowed = fmax(slack, SPACINGS * (double)cloud->site[patch->member[k]].spacing);
        for (unsigned i = 0; i < lines->count; i++) {
            if (lines->reflex && (off[i] > off[1 - i] || (off[i] == off[1 - i] && i == 1)))
                continue;
            if (off[i] > allowed)
                return false;
            move[i] = fmax(move[i], off[i]);
        }
    }
    for (unsigned i = 0; i < lines->count; i++)
        lines->line[i][2] += move[i] > 0 ? move[i] * (1 + 1e-6) : 0;
    return true;
}

/* Moves each line out to the feet of its edge, bit by bit beside the members: what bends outwards
 * between them is shown, and the other side's splats end there too, so that no slit opens. */
static void keep_feet(const struct fit_cloud *cloud, const struct patch *patch,
                      const struct patch_frame *f, double slack, const struct clip_track *track,
                      struct clip_lines *lines)
{
    double move[2] = { 0, 0 };
    for (uint32_t k = 0; k < patch->count; k++) {
        uint32_t id = cloud->crease_of[patch->member[k]];
        double spacing = (double)cloud->site[patch->member[k]].spacing;
        struct xy p = in_plane(cloud, patch->member[k], f);
        for (unsigned i = 0; id != NO_SITE && i < cloud->crease[id].sides; i++) {
            double line[3], off;
            if (!clip_meet(&cloud->crease[id].side[i], f, line))
                continue;
            off = line_at(line, p);
            struct xy foot = { p.x - off * line[0], p.y - off * line[1] };
            double allowed = fmax(slack, BENT * spacing);
            int edge = known_edge(track, line, foot, allowed);
            if (edge >= 0 && fabs(off) <= BESIDE * spacing)
                move[edge] = fmax(move[edge], fmin(-line_at(lines->line[edge], foot), allowed));
        }
    }
    for (unsigned i = 0; i < lines->count; i++)
        lines->line[i][2] += move[i];
}

void patch_clips(const struct fit_cloud *cloud, const struct patch *patch,
                 const struct patch_frame *frame, double slack, struct clip_lines *lines)
{
    struct clip_lines made = { 0 };
    struct clip_track track = { 0 };
    *lines = made;
    if (!cloud->crease)
        return;
    for (uint32_t k = 0; k < patch->count; k++)
        note_edges(cloud, frame, patch->member[k], slack, &track);
    mean_lines(&track, &made);
    for (unsigned i = 0; i < made.count; i++)
        turn_line(cloud, patch, frame, made.line[i]);
    if (made.count == track.found.count)
        keep_feet(cloud, patch, frame, slack, &track, &made);
    for (int way = 0; way < 4; way++) { /* both, either, the first edge alone, the second */
        struct clip_lines tried = made;
        tried.reflex = way == 1;
        if (way >= 2)
            tried.count = 1;
        if (way == 3)
            memcpy(tried.line[0], made.line[1], sizeof tried.line[0]);
        if ((made.count < 2 && way % 2) || (way == 1 && !can_be_reflex(&made)) ||
            !keep_members(cloud, patch, frame, slack, &tried))
            continue;
        *lines = tried;
        return;
    }
}

unsigned clip_feet(const struct clip_lines *lines, double x, double y, double reach,
                   double xy[3][2])
{
    unsigned count = 0;
    double off[2];
    for (unsigned i = 0; i < lines->count; i++) {
        const double *line = lines->line[i];
        off[i] = line_at(line, (struct xy){ x, y });
        if (fabs(off[i]) > reach)
            continue;
        xy[count][0] = x - off[i] * line[0];
        xy[count++][1] = y - off[i] * line[1];
    }
    if (count < 2)
        return count;
    const double *p = lines->line[0], *q = lines->line[1];
    double det = p[0] * q[1] - p[1] * q[0];
    double cx = (p[1] * q[2] - q[1] * p[2]) / det, cy = (q[0] * p[2] - p[0] * q[2]) / det;
    if (fabs(det) > 0.1 && hypot(cx - x, cy - y) <= 2 * reach) {
        xy[count][0] = cx;
        xy[count++][1] = cy;
    }
    return count;
}
