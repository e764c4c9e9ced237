/* Transparent pixels (docs/numerics.md, "Layers"): one sweep over the fragments finds the first
 * layer, and one more each sums a layer and finds the next. */
#include "reference/tile.h"

static const struct nearest none = { .depth = INFINITY };

static void begin(const struct tile *tile, size_t at)
{
    tile->scratch->crossing[at] =
        (struct crossing){ .next = none, .opaque = none, .transmittance = 1, .tint = { 1, 1, 1 } };
}

static void find_first(const struct tile *tile, size_t at, uint32_t id, const struct disc *disc,
                       const struct fragment *fragment)
{
    struct crossing *c = &tile->scratch->crossing[at];
    nearest_take(splat_opacity(tile->view, id) == 1 ? &c->opaque : &c->next, id, disc, fragment);
}

/* The layer that comes next is the one to sum: transparent where that lies before all that is
 * opaque, which ends the ray. */
static void advance(const struct tile *tile, size_t at)
{
    struct crossing *c = &tile->scratch->crossing[at];
    c->nearest = c->next.depth < c->opaque.depth ? c->next : c->opaque;
    c->next = none;
    c->sums = (struct sums){ 0 };
}

static void sum_layer(const struct tile *tile, size_t at, uint32_t id, const struct disc *disc,
                      const struct fragment *fragment)
{
    struct crossing *c = &tile->scratch->crossing[at];
    bool opaque = splat_opacity(tile->view, id) == 1, last = c->nearest.depth == c->opaque.depth;
    if (opaque != last || fragment->depth < c->nearest.depth || !isfinite(c->nearest.depth))
        return;
    if (!opaque && fragment->depth >= c->opaque.depth)
        return;
    if (fragment->depth <= c->nearest.depth + splat_epsilon(tile->view, c->nearest.id))
        sums_add(tile->view, &c->sums, id, disc, fragment, &tile->scratch->ray[at]);
    else if (!opaque)
        nearest_take(&c->next, id, disc, fragment);
}

/* The layer that was just composited, as one of a deep picture: flattened they give the pixel. */
static void keep(const struct tile *tile, size_t at, const struct surface *s, struct vec3 own)
{
    struct crossing *c = &tile->scratch->crossing[at];
    struct deep_list *list = &tile->scratch->deep;
    if (c->first.layers == 1 && surface_is_glass(tile->view, &c->first)) {
        c->glass = surface_interface(tile->view, &c->first, 1);
        own = v3_add(v3_product(c->glass.passed, own), c->glass.mirrored);
    } else if (surface_is_glass(tile->view, &c->first)) {
        own = v3_product(c->glass.passed, own);
    }
    const struct stp_deep_layer layer = { (float)s->depth,
                                          { (float)own.x, (float)own.y, (float)own.z },
                                          (float)s->opacity };
    c->last = list->count;
    if (deep_add(list, (uint32_t)tile_pixel(tile, at), &layer) != STP_OK)
        tile->scratch->no_memory = true;
}

/* The environment behind glass stands in the last layer, which hides all else as the pixel does. */
static void keep_behind(const struct tile *tile, size_t at)
{
    const struct crossing *c = &tile->scratch->crossing[at];
    if (tile->scratch->no_memory)
        return;
    struct stp_deep_layer *layer = &tile->scratch->deep.entry[c->last].layer;
    double layers = tile->view->single_layer ? 1 : c->first.layers;
    struct glass g = surface_interface(tile->view, &c->first, layers);
    struct vec3 behind = v3_product(v3_product(g.passed, c->tint), g.seen);
    double clear = 1 - (double)layer->alpha;
    layer->color[0] = (float)((double)layer->color[0] + clear * behind.x);
    layer->color[1] = (float)((double)layer->color[1] + clear * behind.y);
    layer->color[2] = (float)((double)layer->color[2] + clear * behind.z);
    layer->alpha = 1;
}

static void composite(const struct tile *tile, size_t at)
{
    struct crossing *c = &tile->scratch->crossing[at];
    if (c->sums.count == 0)
        return;
    struct surface s = surface_resolve(tile->view, &c->nearest, &c->sums, &tile->scratch->ray[at]);
    uint32_t layers = c->first.layers + 1;
    if (layers == 1)
        c->first = s;
    c->first.layers = layers;
    struct vec3 light = v3_product(surface_shade(tile->view, &s), c->tint);
    if (tile->view->deep)
        keep(tile, at, &s, v3_scale(light, s.opacity));
    c->color = v3_add(c->color, v3_scale(light, c->transmittance * s.opacity));
    c->transmittance *= 1 - s.opacity;
    c->tint = surface_absorb(tile->view, &s, layers, c->tint);
    if (c->nearest.depth == c->opaque.depth)
        c->opaque = c->next = none;
}

static void finish(const struct tile *tile, size_t at)
{
    const struct crossing *c = &tile->scratch->crossing[at];
    if (c->first.layers == 0)
        return;
    if (!surface_is_glass(tile->view, &c->first)) {
        tile_hit(tile, at, &c->first, c->color, 1 - c->transmittance);
        return;
    }
    if (tile->view->deep)
        keep_behind(tile, at);
    tile_hit(tile, at, &c->first,
             surface_glass(tile->view, &c->first, c->color, v3_scale(c->tint, c->transmittance)),
             1);
}

static bool any_left(const struct tile *tile)
{
    bool left = false;
    for (size_t at = 0; at < TILE * TILE && !left; at++) {
        const struct crossing *c = &tile->scratch->crossing[at];
        left = isfinite(c->next.depth) || isfinite(c->opaque.depth);
    }
    return left;
}

void tile_layers(const struct tile *tile)
{
    for (size_t at = 0; at < TILE * TILE; at++)
        begin(tile, at);
    tile_visit(tile, find_first);
    while (any_left(tile)) {
        tile_each(tile, advance);
        tile_visit(tile, sum_layer);
        tile_each(tile, composite);
    }
    tile_each(tile, finish);
}
