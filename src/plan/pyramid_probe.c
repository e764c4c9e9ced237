/* The last push, the rim and the light of the probe's pixels (glsl/passes/pyramid_shade.comp,
 * pyramid_rim_*.comp), and what the pyramid tells auto. */
#include "plan/pyramid_probe.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"

#define NEAR_REACH 1.5
#define MOST_CROWD 0.6

struct drawing {
    const struct pyramid *p;
    const struct probe *probe;
    struct probe_color *color;
    struct open *open;
    uint32_t *cell_of;     /* of each place where a cell may be, row by row */
    uint32_t across, down; /* such places */
};

/* What a pixel shows: normal in the device's frame. */
struct shown {
    double depth, normal[3], color[3];
    uint32_t id;
};

/* A pixel of the probe that discs from afar may reach yet: nothing covers it, or they may hide what
 * it shows. */
struct open {
    bool is;
    double limit; /* depth of what it shows */
    double depth; /* of the nearest disc that reaches it */
};

/* Of probe pixel i: its place in the grid, and in the picture. False: outside. */
static bool locate(const struct drawing *d, size_t i, int64_t at[2], double q[2])
{
    const uint32_t *corner = d->probe->corner[i / PROBE_CELL_PIXELS];
    uint32_t x = corner[0] + i % PROBE_CELL_PIXELS % PROBE_CELL,
             y = corner[1] + i % PROBE_CELL_PIXELS / PROBE_CELL;
    at[0] = (int64_t)x - d->p->plan->grid.x;
    at[1] = (int64_t)y - d->p->plan->grid.y;
    q[0] = x + 0.5;
    q[1] = y + 0.5;
    return x < d->probe->view.width && y < d->probe->view.height && at[0] >= 0 && at[1] >= 0 &&
           at[0] < d->p->width[0] && at[1] < d->p->height[0];
}

static void show(const struct drawing *d, size_t i, const struct shown *s)
{
    const struct view *view = &d->probe->view;
    const struct ray *ray = &d->probe->ray[i];
    struct surface surface = { .depth = s->depth,
                               .weight = 1,
                               .opacity = 1,
                               .normal = v3_unit(v3(s->normal[0], -s->normal[1], -s->normal[2])),
                               .point = ray_at(ray, s->depth),
                               .albedo = v3(s->color[0], s->color[1], s->color[2]),
                               .count = 1,
                               .id = s->id,
                               .layers = 1 };
    struct vec3 c = surface_shade(view, &surface);
    struct probe_color *out = &d->color[i];
    memcpy(out->color, (double[3]){ c.x, c.y, c.z }, sizeof out->color);
    out->covered = true;
}

static struct shown shown_point(const struct pyramid_texel *t, double depth)
{
    struct shown s = { .depth = depth, .id = t->id };
    for (int k = 0; k < 3; k++) {
        s.normal[k] = (double)t->normal[k];
        s.color[k] = (double)t->color[k];
    }
    return s;
}

static void center_of(const struct pyramid *p, const struct pyramid_texel *t, int64_t x, int64_t y,
                      double center[2])
{
    pyramid_middle(p, 0, x, y, center);
    for (int k = 0; k < 2; k++)
        center[k] += (double)t->center[k];
}

/* The rim, as in glsl/lib/rim.glsl. */
static double crowd_of(const struct pyramid *p, const struct pyramid_texel *t,
                       const double center[2])
{
    const struct eye *e = &p->view->eye;
    double scale = e->orthographic ? 1 : 1 / (double)t->depth, facing = fabs((double)t->normal[2]);
    if (!e->orthographic)
        facing =
            fabs(v3_dot(v3_loadf(t->normal),
                        v3_unit(v3((center[0] - e->cx) / e->fx, (center[1] - e->cy) / e->fy, 1))));
    double r = (double)t->radius * scale, area = 3.14159 * r * r * e->fx * e->fy * facing;
    return MOST_CROWD * fmin(fmax((16 - area) / 12, 0), 1);
}

static bool rim_hit(const struct pyramid *p, const struct pyramid_texel *t, double crowd,
                    const double center[2], const double q[2], double *depth)
{
    const struct eye *e = &p->view->eye;
    double d[2] = { center[0] - q[0], center[1] - q[1] }, away = hypot(d[0], d[1]);
    double part = fmin(crowd, away) / fmax(away, 1e-6);
    const double at[2] = { q[0] + d[0] * part, q[1] + d[1] * part };
    struct pyramid_meeting m = pyramid_meet(p, t, center, at);
    *depth = m.depth;
    return m.hit && m.depth >= e->near_depth && m.depth <= e->far_depth;
}

static struct shown shown_mean(const struct pyramid_push *r)
{
    struct shown s = { .depth = r->depth, .id = r->disc.id };
    for (int k = 0; k < 3; k++) {
        s.normal[k] = r->normal[k];
        s.color[k] = r->color[k] / r->weight;
    }
    return s;
}

/* glsl/lib/rim_surface.glsl: what a pixel shows that the disc of t reaches at this depth. */
static struct shown rim_surface(const struct drawing *d, const int64_t at[2], const double q[2],
                                const struct pyramid_texel *t, double depth)
{
    const struct eye *e = &d->p->view->eye;
    struct pyramid_texel own = pyramid_load(d->p, 0, at[0], at[1]);
    struct pyramid_push r = pyramid_push(d->p, 1, at[0], at[1], q, false);
    bool mean = !isfinite(own.depth) && r.weight > 0 && r.depth <= depth + (double)t->radius &&
                r.depth >= e->near_depth && r.depth <= e->far_depth;
    return mean ? shown_mean(&r) : shown_point(t, depth);
}

/* The nearest of the discs of the pixels round about that reach this one. */
static bool rim_near(const struct drawing *d, const int64_t at[2], const double q[2], bool doubtful,
                     struct shown *s, double *reach)
{
    double nearest = INFINITY, depth, center[2];
    for (int i = 0; i < 9; i++) {
        int64_t x = at[0] + i % 3 - 1, y = at[1] + i / 3 - 1;
        struct pyramid_texel t = pyramid_load(d->p, 0, x, y);
        if (!isfinite(t.depth))
            continue;
        center_of(d->p, &t, x, y, center);
        double crowd = doubtful ? 0 : crowd_of(d->p, &t, center);
        if (!rim_hit(d->p, &t, crowd, center, q, &depth) || !(depth < nearest))
            continue;
        nearest = depth;
        *reach = depth + (double)t.radius;
        *s = rim_surface(d, at, q, &t, depth);
    }
    return isfinite(nearest);
}

/* A point's disc into the open pixels of a cell, where it is before what they show by its radius.
 */
static void reach_cell(const struct drawing *d, uint32_t cell, const struct pyramid_texel *t,
                       const double center[2])
{
    for (uint32_t k = 0; k < PROBE_CELL_PIXELS; k++) {
        size_t i = (size_t)cell * PROBE_CELL_PIXELS + k;
        int64_t at[2];
        double q[2], depth;
        struct open *o = &d->open[i];
        if (!o->is || !locate(d, i, at, q) || !rim_hit(d->p, t, 0, center, q, &depth) ||
            !(depth + (double)t->radius < o->limit) || !(depth < o->depth))
            continue;
        o->depth = depth;
        struct shown s = rim_surface(d, at, q, t, depth);
        show(d, i, &s);
    }
}

static void cell_range(double low, double high, uint32_t cells, int64_t *first, int64_t *last)
{
    *first = (int64_t)fmax(floor(low / PROBE_CELL), 0);
    *last = (int64_t)fmin(floor(high / PROBE_CELL), cells - 1.0);
}

/* Pixels that the disc reaches, in each direction. */
static void disc_reach(const struct drawing *d, const struct pyramid_texel *t, double reach[2])
{
    const struct eye *e = &d->p->view->eye;
    double r = (double)t->radius, z = (double)t->depth;
    double nearest = e->orthographic ? 1 : fmax(z - r, 0.5 * z);
    double floor_ = (double)d->p->plan->frame.pyramid_floor;
    reach[0] = fmax(r * e->fx / nearest, floor_);
    reach[1] = fmax(r * e->fy / nearest, floor_);
}

/* Some disc reaches beyond the pixels beside its point's own. */
static bool discs_far(const struct drawing *d)
{
    struct pyramid_texel t;
    double center[2], reach[2];
    bool far = false;
    for (size_t i = 0; d->p->plan->rim_far && i < d->p->view->scene->splats.count && !far; i++) {
        if (!pyramid_point(d->p, i, &t, center))
            continue;
        disc_reach(d, &t, reach);
        far = fmax(reach[0], reach[1]) > NEAR_REACH - MOST_CROWD;
    }
    return far;
}

static void reach_far(const struct drawing *d, size_t id)
{
    struct pyramid_texel t;
    int64_t low[2], high[2];
    double center[2], r[2];
    if (!pyramid_point(d->p, id, &t, center))
        return;
    disc_reach(d, &t, r);
    for (int k = 0; k < 2; k++) {
        r[k] = fmin(r[k] + 0.5, STP_RIM_REACH);
        cell_range(center[k] - r[k], center[k] + r[k], k ? d->down : d->across, &low[k], &high[k]);
    }
    for (int64_t by = low[1]; by <= high[1]; by++)
        for (int64_t bx = low[0]; bx <= high[0]; bx++) {
            uint32_t cell = d->cell_of[(size_t)by * d->across + (size_t)bx];
            if (cell != PROBE_NO_CELL)
                reach_cell(d, cell, &t, center);
        }
}

/* The push of level 0: what the pixel shows. *doubtful: discs may hide that yet. */
static bool shade_pixel(const struct drawing *d, const int64_t at[2], const double q[2],
                        struct shown *s, bool *doubtful)
{
    const struct eye *e = &d->p->view->eye;
    struct pyramid_texel own = pyramid_load(d->p, 0, at[0], at[1]);
    bool valid = isfinite(own.depth), copied = false;
    struct pyramid_push r = pyramid_push(d->p, 1, at[0], at[1], q, valid);
    bool there = r.weight > 0 && r.depth >= e->near_depth && r.depth <= e->far_depth;
    *doubtful = false;
    if (valid) {
        double center[2];
        center_of(d->p, &own, at[0], at[1], center);
        struct pyramid_meeting m = pyramid_meet(d->p, &own, center, q);
        *s = shown_point(&own, m.hit ? fmax(m.depth, e->near_depth) : (double)own.depth);
        copied = !(there && s->depth > r.reach);
        *doubtful = copied && s->depth > r.before;
    }
    if (copied)
        return true;
    bool rim = r.disc.rim && !valid; /* there the points' own discs decide */
    if (rim || !there)
        return false;
    *s = shown_mean(&r);
    *doubtful = s->depth > r.before;
    return true;
}

static void draw_pixel(const struct drawing *d, size_t i)
{
    int64_t at[2];
    double q[2], reach = INFINITY;
    struct shown own = { 0 }, other = { 0 };
    bool doubtful;
    if (!locate(d, i, at, q))
        return;
    bool hit = shade_pixel(d, at, q, &own, &doubtful);
    bool found = (!hit || doubtful) && rim_near(d, at, q, doubtful, &other, &reach);
    bool hidden = !hit || (doubtful && found && own.depth > reach);
    if (!hidden)
        show(d, i, &own);
    else if (found)
        show(d, i, &other);
    if (hidden ? !found : doubtful)
        d->open[i] = (struct open){ true, hit ? own.depth : INFINITY, INFINITY };
}

/* What nothing covers shows what is behind it all, as the truth does where it has nothing. */
static void begin_pixel(const struct drawing *d, size_t i)
{
    const struct probe_pixel nothing = { 0 };
    probe_resolve(d->probe, i, &nothing, d->color[i].color);
    d->color[i].covered = false;
    d->open[i].is = false;
}

static void draw_all(const struct drawing *d)
{
    for (size_t b = 0; b < (size_t)d->across * d->down; b++)
        d->cell_of[b] = PROBE_NO_CELL;
    for (unsigned c = 0; c < d->probe->cells; c++) {
        const uint32_t *corner = d->probe->corner[c];
        d->cell_of[(size_t)(corner[1] / PROBE_CELL) * d->across + corner[0] / PROBE_CELL] = c;
    }
    for (size_t i = 0; i < d->probe->pixels; i++) {
        begin_pixel(d, i);
        draw_pixel(d, i);
    }
    size_t points = discs_far(d) ? d->p->view->scene->splats.count : 0;
    for (size_t i = 0; i < points; i++)
        reach_far(d, i);
}

static enum stp_result draw(const struct stp_env *env, const struct probe *probe,
                            const struct stp_plan *plan, struct probe_color *color)
{
    struct pyramid pyramid = { 0 };
    struct drawing d = {
        .p = &pyramid,
        .probe = probe,
        .color = color,
        .across = (probe->view.width + SURVEY_BLOCK - 1) / SURVEY_BLOCK * PROBE_ACROSS,
        .down = (probe->view.height + SURVEY_BLOCK - 1) / SURVEY_BLOCK * PROBE_ACROSS
    };
    enum stp_result result = pyramid_make(env, plan, &probe->view, &pyramid);
    if (result != STP_OK)
        return result;
    d.open = mem_alloc(probe->pixels ? probe->pixels : 1, sizeof *d.open);
    d.cell_of = mem_alloc((size_t)d.across * d.down, sizeof *d.cell_of);
    if (d.open && d.cell_of)
        draw_all(&d);
    else
        result = log_no_memory(env, probe->pixels * sizeof *d.open, "drawing a probe");
    mem_free(d.open);
    mem_free(d.cell_of);
    pyramid_release(&pyramid);
    return result;
}

bool pyramid_can_judge(const struct stp_plan *plan)
{
    return plan->method != STP_METHOD_PYRAMID ||
           (plan->chunk_count == 0 &&
            (uint64_t)plan->grid.width * plan->grid.height <= PYRAMID_MOST_PIXELS);
}

static unsigned candidates(struct plan_candidate candidate[PLAN_MAX_OFFERED])
{
    candidate[0] = (struct plan_candidate){ .method = STP_METHOD_PYRAMID,
                                            .path = STP_PATH_COMPUTE,
                                            .voronoi = STP_VORONOI_OFF };
    return 1;
}

/* Points once, pixels level by level, and where discs may reach far, about as many as win their
 * pixels. */
static enum plan_cost cost(const struct stp_plan *plan, const struct survey *survey,
                           double amount[PLAN_TERMS])
{
    double winners = survey->drawn > survey->touched ? survey->touched / survey->drawn : 1;
    plan_common_amounts(plan, survey, amount);
    amount[PLAN_TERM_BOX] = amount[PLAN_TERM_LARGE] = amount[PLAN_TERM_LARGE_BOX] =
        amount[PLAN_TERM_FRAGMENTS] = 0;
    if (plan->rim_far)
        amount[PLAN_TERM_LARGE_BOX] = winners * (survey->small_box + survey->large_box);
    return plan->constant[PLAN_HAS_COLOR] ? PLAN_COST_PYRAMID_COLOR : PLAN_COST_PYRAMID;
}

const struct plan_offer plan_pyramid_offer = {
    .method = STP_METHOD_PYRAMID, .candidates = candidates, .cost = cost, .draw = draw
};
