#include "prepare/phong_fence.h"

#include <math.h>
#include <string.h>

#include "prepare/phong_crease.h"

#define REACH 5.0  /* spacings: members so near an edge tell of it */
#define SURE  0.25 /* spacings: nearer, a site's side of the edge is open */
#define APART 1.0  /* spacings between fences of one edge */
#define NEAR  0.5  /* spacings: so near a member the surface goes on, whatever is beside it */
#define FAR   1.5  /* spacings: so far from any it has ended, edge or not */
#define GRID  32   /* most cells of the ellipse's box a side, */
#define CELL  0.3  /* and none is narrower, in spacings */

static double square(double x)
{
    return x * x;
}

static double squared_distance(struct xy a, struct xy b)
{
    return square(a.x - b.x) + square(a.y - b.y);
}

static bool is_known(const struct fences *fences, const struct fence *f)
{
    for (unsigned i = 0; i < fences->count; i++) {
        const struct fence *g = &fences->fence[i];
        double along = f->line[0] * g->line[0] + f->line[1] * g->line[1];
        if (along > 0.95 &&
            hypot(f->foot.x - g->foot.x, f->foot.y - g->foot.y) < APART * fences->spacing)
            return true;
    }
    return false;
}

static void add_fence(struct fences *fences, const double line[3], struct xy p)
{
    double off = line_at(line, p), sign = off < 0 ? -1 : 1;
    struct fence f = { .foot = { p.x - off * line[0], p.y - off * line[1] } };
    for (int i = 0; i < 3; i++)
        f.line[i] = sign * line[i];
    if (fabs(off) >= SURE * fences->spacing && fabs(off) <= REACH * fences->spacing &&
        fences->count < FENCES_MOST && !is_known(fences, &f))
        fences->fence[fences->count++] = f;
}

void fences_gather(const struct fit_cloud *cloud, const struct patch *patch,
                   const struct patch_frame *frame, double slack, double spacing,
                   struct fences *fences)
{
    fences->count = 0;
    fences->slack = slack;
    fences->spacing = spacing;
    for (uint32_t k = 0; cloud->crease && k < patch->count; k++) {
        uint32_t id = cloud->crease_of[patch->member[k]];
        struct xy p = in_plane(cloud, patch->member[k], frame);
        double line[3];
        for (unsigned i = 0; id != NO_SITE && i < cloud->crease[id].sides; i++)
            if (clip_meet(&cloud->crease[id].side[i], frame, line))
                add_fence(fences, line, p);
    }
}

/* How far the middle of a cell is from the nearest member, squared; at most FAR spacings. */
struct cells {
    int count[2];
    double low[2], size[2];
    double away[GRID][GRID];
};

static void lay_cells(struct cells *c, const double center[2], const double radius[2],
                      double spacing)
{
    for (int axis = 0; axis < 2; axis++) {
        double wanted = ceil(2 * radius[axis] / (CELL * spacing));
        c->count[axis] = wanted < GRID ? (int)wanted : GRID;
        c->low[axis] = center[axis] - radius[axis];
        c->size[axis] = 2 * radius[axis] / c->count[axis];
    }
}

static struct xy cell_middle(const struct cells *c, int i, int j)
{
    return (struct xy){ c->low[0] + (i + 0.5) * c->size[0], c->low[1] + (j + 0.5) * c->size[1] };
}

static int nearest_cell(const struct cells *c, int axis, double x)
{
    double cell = (x - c->low[axis]) / c->size[axis];
    return cell < 0 ? 0 : cell >= c->count[axis] ? c->count[axis] - 1 : (int)cell;
}

static void near_cells(struct cells *c, const double p[2], double reach)
{
    int from[2], to[2];
    for (int axis = 0; axis < 2; axis++) {
        from[axis] = nearest_cell(c, axis, p[axis] - reach);
        to[axis] = nearest_cell(c, axis, p[axis] + reach);
    }
    for (int i = from[0]; i <= to[0]; i++)
        for (int j = from[1]; j <= to[1]; j++) {
            double away = squared_distance(cell_middle(c, i, j), (struct xy){ p[0], p[1] });
            if (away < c->away[i][j])
                c->away[i][j] = away;
        }
}

static bool is_beyond(const struct fences *fences, struct xy p)
{
    const struct fence *nearest = NULL;
    double least = INFINITY;
    for (unsigned i = 0; i < fences->count; i++) {
        const struct fence *f = &fences->fence[i];
        double away = squared_distance(p, f->foot);
        if (away < least) {
            least = away;
            nearest = f;
        }
    }
    return nearest && line_at(nearest->line, p) < -fences->slack;
}

static bool is_shown(const struct clip_lines *lines, struct xy p)
{
    unsigned on = 0;
    for (unsigned i = 0; i < lines->count; i++)
        on += line_at(lines->line[i], p) >= 0;
    return lines->reflex ? on > 0 : on == lines->count;
}

double fences_overhang(const struct fences *fences, const double (*point)[2], size_t count,
                       const struct clip_lines *lines, const double center[2],
                       const double radius[2])
{
    struct cells c;
    double near = NEAR * fences->spacing, far = FAR * fences->spacing, beyond = 0;
    if (fences->count == 0)
        return 0;
    lay_cells(&c, center, radius, fences->spacing);
    near = square(fmax(near, fmax(c.size[0], c.size[1])));
    far = fmax(far, 1.5 * fmax(c.size[0], c.size[1]));
    for (int i = 0; i < GRID * GRID; i++)
        c.away[i / GRID][i % GRID] = square(far);
    for (size_t k = 0; k < count; k++)
        near_cells(&c, point[k], far);
    for (int i = 0; i < c.count[0]; i++)
        for (int j = 0; j < c.count[1]; j++) {
            struct xy p = cell_middle(&c, i, j);
            bool inside =
                square((p.x - center[0]) / radius[0]) + square((p.y - center[1]) / radius[1]) <= 1;
            if (inside && c.away[i][j] > near && is_shown(lines, p) &&
                (c.away[i][j] >= square(far) || is_beyond(fences, p)))
                beyond += c.size[0] * c.size[1];
        }
    return beyond;
}
