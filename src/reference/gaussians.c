/* A surface's splats as truncated Gaussians in every ray's own order (docs/axis.md, "A surface's
 * splat"): all fragments of a tile's rays are kept, sorted along each ray, and composited. */
#include "reference/gaussians.h"

#include <stdlib.h>

#include "base/memory.h"

#define LEAST_ALPHA 1e-4 /* HM 5: smaller contributions are dropped */

void gaussians_release(struct gaussians *gaussians)
{
    mem_free(gaussians->fragment);
    gaussians->fragment = NULL;
    gaussians->capacity = 0;
}

/* Lit once, at its centre, by its own normal there. */
static struct vec3 splat_light(const struct view *view, uint32_t id, const struct disc *disc)
{
    const struct fragment centre = { .s = 0, .t = 0 };
    struct surface lit = { .normal = fragment_normal(disc, &centre),
                           .point = disc->centre,
                           .albedo = splat_albedo(view, id),
                           .id = id };
    return surface_shade(view, &lit);
}

static void visit(const struct tile *tile, size_t at, uint32_t id, const struct disc *disc,
                  const struct fragment *fragment)
{
    struct gaussians *g = &tile->scratch->gaussians;
    double alpha = splat_opacity(tile->view, id) * exp(-2 * fragment->rho2);
    if (alpha < LEAST_ALPHA)
        return;
    if (g->fill)
        g->fragment[g->next[at]] = (struct gaussian){ .depth = fragment->depth,
                                                      .alpha = alpha,
                                                      .color = splat_light(tile->view, id, disc),
                                                      .id = id };
    g->next[at]++;
}

/* Room for what was counted; the counts become places. */
static bool make_room(struct gaussians *g)
{
    size_t total = 0;
    for (size_t i = 0; i < TILE * TILE; i++) {
        g->first[i] = total;
        total += g->next[i];
        g->next[i] = g->first[i];
    }
    g->first[TILE * TILE] = total;
    if (total <= g->capacity)
        return true;
    struct gaussian *grown = mem_realloc(g->fragment, total, sizeof *grown);
    if (!grown)
        return false;
    g->fragment = grown;
    g->capacity = total;
    return true;
}

static int by_depth(const void *a, const void *b)
{
    const struct gaussian *x = a, *y = b;
    if (x->depth != y->depth)
        return x->depth < y->depth ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

/* Of an opaque surface, what covers half of a ray or more is all there is of it. */
static double normalised(const struct view *view, double alpha)
{
    return view->scene->facts.transparent ? 1 : fmin(1, 2 * alpha) / alpha;
}

/* Front to back. */
static void composite(const struct tile *tile, size_t at)
{
    struct gaussians *g = &tile->scratch->gaussians;
    struct gaussian *f = g->fragment + g->first[at];
    size_t count = g->first[at + 1] - g->first[at];
    struct surface s = { .count = (uint32_t)count, .layers = 1 };
    struct vec3 color = v3(0, 0, 0);
    double left = 1, most = 0, alpha = 0;
    if (count == 0)
        return;
    qsort(f, count, sizeof *f, by_depth);
    for (size_t i = 0; i < count; i++) {
        double w = left * f[i].alpha;
        color = v3_add(color, v3_scale(f[i].color, w));
        s.albedo = v3_add(s.albedo, v3_scale(splat_albedo(tile->view, f[i].id), w));
        s.depth += w * f[i].depth;
        alpha += w;
        s.id = w > most ? f[i].id : s.id;
        most = fmax(most, w);
        left *= 1 - f[i].alpha;
    }
    double scale = normalised(tile->view, alpha);
    s.depth /= alpha;
    s.albedo = v3_scale(s.albedo, 1 / alpha);
    s.weight = alpha;
    s.point = ray_at(&tile->scratch->ray[at], s.depth);
    tile_hit(tile, at, &s, v3_scale(color, scale), alpha * scale);
}

void tile_gaussians(const struct tile *tile)
{
    struct gaussians *g = &tile->scratch->gaussians;
    for (size_t i = 0; i < TILE * TILE; i++)
        g->next[i] = 0;
    g->fill = false;
    tile_visit(tile, visit);
    if (!make_room(g)) {
        tile->scratch->no_memory = true;
        return;
    }
    g->fill = true;
    tile_visit(tile, visit);
    tile_each(tile, composite);
}
