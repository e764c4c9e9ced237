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
    struct vec3 light = surface_shade(tile->view, &s);
    light = v3(light.x * c->tint.x, light.y * c->tint.y, light.z * c->tint.z);
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
    if (surface_is_glass(tile->view, &c->first))
        tile_hit(
            tile, at, &c->first,
            surface_glass(tile->view, &c->first, c->color, v3_scale(c->tint, c->transmittance)), 1);
    else
        tile_hit(tile, at, &c->first, c->color, 1 - c->transmittance);
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
