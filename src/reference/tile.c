#include "reference/tile.h"

#include "reference/gaussians.h"
#include "scene/samples.h"

static size_t index_of(const struct tile *tile, uint32_t x, uint32_t y)
{
    return (size_t)(y - tile->y0) * TILE + (x - tile->x0);
}

size_t tile_pixel(const struct tile *tile, size_t at)
{
    return (tile->y0 + at / TILE) * (size_t)tile->view->width + tile->x0 + at % TILE;
}

static void visit_disc(const struct tile *tile, uint32_t id, const struct disc *disc,
                       visit_fn visit)
{
    const struct scratch *scratch = tile->scratch;
    struct fragment fragment;
    uint32_t x0, x1, y0, y1;
    if (!cells_touched(disc->x_min, disc->x_max, 1, tile->x0, tile->x1, &x0, &x1) ||
        !cells_touched(disc->y_min, disc->y_max, 1, tile->y0, tile->y1, &y0, &y1))
        return;
    for (uint32_t y = y0; y <= y1; y++)
        for (uint32_t x = x0; x <= x1; x++) {
            size_t at = index_of(tile, x, y);
            if (disc_hit(disc, &tile->view->eye, &scratch->ray[at], scratch->px[at],
                         scratch->py[at], &fragment))
                visit(tile, at, id, disc, &fragment);
        }
}

void tile_visit(const struct tile *tile, visit_fn visit)
{
    struct disc disc;
    for (size_t i = 0; i < tile->count; i++)
        if (disc_setup(tile->view, tile->splat[i], &disc))
            visit_disc(tile, tile->splat[i], &disc, visit);
}

static void find_nearest(const struct tile *tile, size_t at, uint32_t id, const struct disc *disc,
                         const struct fragment *fragment)
{
    nearest_take(&tile->scratch->nearest[at], id, disc, fragment);
}

static void sum_visible(const struct tile *tile, size_t at, uint32_t id, const struct disc *disc,
                        const struct fragment *fragment)
{
    const struct nearest *nearest = &tile->scratch->nearest[at];
    if (tile->view->shade == STP_SHADE_FLAT && id != nearest->id)
        return;
    if (fragment->depth <= nearest->depth + splat_epsilon(tile->view, nearest->id))
        sums_add(tile->view, &tile->scratch->sums[at], id, disc, fragment, &tile->scratch->ray[at]);
}

static void begin_sample(const struct tile *tile, uint32_t sample)
{
    struct scratch *s = tile->scratch;
    for (uint32_t y = tile->y0; y < tile->y1; y++)
        for (uint32_t x = tile->x0; x < tile->x1; x++) {
            size_t at = index_of(tile, x, y);
            sample_position(tile->view->grid, x, y, sample, &s->px[at], &s->py[at]);
            s->ray[at] = eye_ray(&tile->view->eye, s->px[at], s->py[at]);
            s->nearest[at] = (struct nearest){ .depth = INFINITY };
            s->sums[at] = (struct sums){ 0 };
        }
}

void tile_each(const struct tile *tile, void (*each)(const struct tile *tile, size_t at))
{
    for (uint32_t y = tile->y0; y < tile->y1; y++)
        for (uint32_t x = tile->x0; x < tile->x1; x++)
            each(tile, index_of(tile, x, y));
}

void tile_hit(const struct tile *tile, size_t at, const struct surface *surface, struct vec3 color,
              double alpha)
{
    struct pixel *pixel = &tile->scratch->pixel[at];
    pixel->color = v3_add(pixel->color, color);
    pixel->alpha += alpha;
    if (pixel->hits++ == 0 || surface->depth < pixel->nearest.depth)
        pixel->nearest = *surface;
}

static void end_sample(const struct tile *tile, size_t at)
{
    struct scratch *s = tile->scratch;
    if (s->sums[at].count == 0)
        return;
    struct surface surface =
        surface_resolve(tile->view, &s->nearest[at], &s->sums[at], &s->ray[at]);
    tile_hit(tile, at, &surface, surface_color(tile->view, &surface, &s->sums[at]), 1);
}

static void opaque_sample(const struct tile *tile)
{
    tile_visit(tile, find_nearest);
    tile_visit(tile, sum_visible);
    tile_each(tile, end_sample);
}

void tile_render(const struct view *view, const struct bins *bins, size_t index,
                 struct scratch *scratch, const struct planes *planes)
{
    uint32_t x0 = (uint32_t)(index % bins->across) * TILE;
    uint32_t y0 = (uint32_t)(index / bins->across) * TILE;
    struct tile tile = { .view = view,
                         .splat = bins->splat + bins->first[index],
                         .count = bins->first[index + 1] - bins->first[index],
                         .x0 = x0,
                         .x1 = view->width - x0 < TILE ? view->width : x0 + TILE,
                         .y0 = y0,
                         .y1 = view->height - y0 < TILE ? view->height : y0 + TILE,
                         .scratch = scratch };
    for (size_t i = 0; i < TILE * TILE; i++)
        scratch->pixel[i] = (struct pixel){ 0 };
    for (uint32_t sample = 0; tile.count && sample < view->grid * view->grid; sample++) {
        begin_sample(&tile, sample);
        if (view->gaussians)
            tile_gaussians(&tile);
        else if (view->transparent)
            tile_layers(&tile);
        else
            opaque_sample(&tile);
    }
    for (uint32_t y = tile.y0; y < tile.y1; y++)
        for (uint32_t x = tile.x0; x < tile.x1; x++)
            planes_write(planes, view, (size_t)y * view->width + x,
                         &scratch->pixel[index_of(&tile, x, y)]);
}
