/* Tiles: the fragments of every sample, found twice: for the nearest, then for the sums. Where the
 * view is transparent, once more for every layer. */
#ifndef STP_REFERENCE_TILE_H
#define STP_REFERENCE_TILE_H

#include "reference/bins.h"
#include "reference/planes.h"
#include "scene/deep.h"

/* A pixel's ray through its layers. */
struct crossing {
    struct nearest next, opaque; /* of the layer after those done; of the opaque splats */
    struct nearest nearest;      /* of the layer being summed */
    struct sums sums;
    struct surface first; /* the nearest layer; .layers counts those done */
    struct vec3 color;    /* premultiplied, of the layers done */
    double transmittance; /* of them */
    struct vec3 tint;     /* what their absorption leaves */
    struct glass glass;   /* with deep layers: of the first, where that is glass */
    size_t last;          /* with deep layers: where that of the layer done last is */
};

/* A fragment of a Gaussian, lit. */
struct gaussian {
    double depth, alpha;
    struct vec3 color;
    uint32_t id;
};

/* With view->gaussians: all of a tile's rays, one ray after the other. */
struct gaussians {
    struct gaussian *fragment;
    size_t capacity, first[TILE * TILE + 1], next[TILE * TILE];
    bool fill; /* else they are only counted */
};

/* One thread's; of a tile's pixels, row by row. */
struct scratch {
    double px[TILE * TILE], py[TILE * TILE]; /* the sample's position and ray */
    struct ray ray[TILE * TILE];
    struct nearest nearest[TILE * TILE];
    struct sums sums[TILE * TILE];
    struct crossing crossing[TILE * TILE];
    struct pixel pixel[TILE * TILE];
    struct deep_list deep; /* with view->deep: the layers of all tiles so far */
    struct gaussians gaussians;
    bool no_memory; /* for one of them */
};

struct tile {
    const struct view *view;
    const uint32_t *splat;
    size_t count;
    uint32_t x0, x1, y0, y1; /* pixels [x0, x1) x [y0, y1) */
    struct scratch *scratch;
};

/* Every fragment of the current sample of every pixel, in canonical order of the splats; `at` is
 * the pixel's place in the scratch. */
typedef void (*visit_fn)(const struct tile *tile, size_t at, uint32_t id, const struct disc *disc,
                         const struct fragment *fragment);
void tile_visit(const struct tile *tile, visit_fn visit);
/* Calls for every pixel of the tile. */
void tile_each(const struct tile *tile, void (*each)(const struct tile *tile, size_t at));

/* Of the whole picture, rows from the top. */
size_t tile_pixel(const struct tile *tile, size_t at);

/* The surface that the current sample of a pixel hit, shaded: joins the pixel's other samples. */
void tile_hit(const struct tile *tile, size_t at, const struct surface *surface, struct vec3 color,
              double alpha);

/* layers.c: the current sample of every pixel, as layers. */
void tile_layers(const struct tile *tile);

void tile_render(const struct view *view, const struct bins *bins, size_t tile,
                 struct scratch *scratch, const struct planes *planes);

#endif
