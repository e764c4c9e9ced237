/* A level is the map under a von Mises-Fisher lobe: L(d) = sum L_t w_t / sum w_t over the texels,
 * w_t = solid angle of t times exp(kappa (d.t - 1)), kappa = 1 / (2 r^4 + texel^2 / 4). The weights
 * depend on the difference of longitudes alone, so a row of the level is a few convolutions of the
 * map's rows: each is added up as shifted copies of whole rows. */
#include "prepare/environment.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#define PI             3.14159265358979323846
#define TEXELS_A_SIGMA 3.6  /* of a level, in its lobe's standard deviation */
#define CUT            10.0 /* weights below exp(-CUT) are left out: 5e-5 of the lobe */
#define LEAST_HEIGHT   48
#define MOST_HEIGHT    1024

/* Whether a level takes its light from a coarser copy of the map. */
static bool is_shrunk(const struct environment_map *map, uint32_t width, uint32_t height)
{
    return height < map->height && width < map->width;
}

/* Of the lobe: 1 / kappa. A texel's own width is in it, so that no lobe falls between texels. */
static double variance(const struct environment_map *map, float roughness)
{
    double r = roughness, texel = fmax(PI / map->height, 2 * PI / map->width);
    return 2 * r * r * r * r + texel * texel / 4;
}

void environment_level_size(const struct environment_map *map, float roughness, uint32_t *width,
                            uint32_t *height)
{
    double wanted = ceil(TEXELS_A_SIGMA * PI / sqrt(variance(map, roughness)));
    *height = (uint32_t)fmin(fmax(wanted, LEAST_HEIGHT), MOST_HEIGHT);
    *width = 2 * *height;
    if (!is_shrunk(map, *width, *height)) /* whole shifts: a multiple of the map's columns */
        *width = (*width + map->width - 1) / map->width * map->width;
}

/* A coarser map: tents weighted by solid angle. */
struct shrinking {
    const struct environment_map *in, *out;
};

static double row_angle(uint32_t height, double top, double bottom)
{
    return cos(top * PI / height) - cos(bottom * PI / height);
}

/* The share of coarse texel `at` in what lies at `place`, in coarse texels: a tent, so that a small
 * sun keeps its place. */
static double tent(double place, uint32_t at)
{
    return fmax(0, 1 - fabs(place - (at + 0.5)));
}

/* What a coarse row gets of a row of the map: solid angle. What is nearer to a pole than the first
 * row's centre is that row's. */
static double row_share(uint32_t height, uint32_t j, uint32_t coarse_height, uint32_t y)
{
    double place = (j + 0.5) * coarse_height / height;
    return row_angle(height, j, j + 1.0) * tent(fmin(fmax(place, 0.5), coarse_height - 0.5), y);
}

/* The rows [*first, end) that have a share in coarse row y; returns end. */
static uint32_t rows_of(uint32_t height, uint32_t coarse_height, uint32_t y, uint32_t *first)
{
    double ratio = (double)height / coarse_height;
    *first = (uint32_t)fmax(0, floor((y - 0.5) * ratio));
    return (uint32_t)fmin(ceil((y + 1.5) * ratio), height);
}

/* Of all texels of a coarse row, times the number of coarse columns. */
static double coarse_angle(uint32_t height, uint32_t coarse_height, uint32_t y)
{
    uint32_t j, end = rows_of(height, coarse_height, y, &j);
    double sum = 0;
    for (; j < end; j++)
        sum += row_share(height, j, coarse_height, y);
    return sum;
}

/* Adds what coarse column x gets of row j. */
static void add_columns(const struct environment_map *in, uint32_t j, uint32_t x, double ratio,
                        double weight, double sum[3])
{
    int64_t first = (int64_t)floor((x - 0.5) * ratio), last = (int64_t)ceil((x + 1.5) * ratio);
    for (int64_t i = first; i < last; i++) {
        double share = weight * tent(((double)i + 0.5) / ratio, x) / ratio;
        int64_t column = i < 0 ? i + in->width : i < in->width ? i : i - in->width;
        const float *texel = in->texel[(size_t)j * in->width + (size_t)column];
        for (int k = 0; k < 3; k++)
            sum[k] += share * (double)texel[k];
    }
}

/* Light is kept, not the mean of what happens to lie under a tent: where rows and columns beat with
 * those of the map, the lobe evens it out. */
static void shrink_texel(const struct shrinking *s, uint32_t x, uint32_t y)
{
    const struct environment_map *in = s->in, *out = s->out;
    double sum[3] = { 0 }, angle = coarse_angle(in->height, out->height, y);
    uint32_t j, end = rows_of(in->height, out->height, y, &j);
    for (; j < end; j++)
        add_columns(in, j, x, (double)in->width / out->width,
                    row_share(in->height, j, out->height, y), sum);
    for (int k = 0; k < 3; k++)
        out->texel[(size_t)y * out->width + x][k] = (float)(sum[k] / angle);
}

static void shrink_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct shrinking *s = context;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < s->out->width; x++)
            shrink_texel(s, x, (uint32_t)y);
}

struct lobe {
    const struct environment_map *map, *source;
    const struct environment_level *level;
    float scale, (*texel)[3];
    double kappa;
    float *sums; /* three a column of the source, one set a worker */
};

/* out[i] += weight * row[i + shift], the row being a circle. */
static void add_shifted(float *restrict out, const float *restrict row, size_t length, size_t shift,
                        float weight)
{
    size_t first = length - shift;
    for (size_t i = 0; i < first; i++)
        out[i] += weight * row[shift + i];
    for (size_t i = 0; i < shift; i++)
        out[first + i] += weight * row[i];
}

/* Adds row j of the source, seen from polar angle `theta` and `phase` of a column past the column's
 * left edge; returns the sum of the weights. */
static double add_row(const struct lobe *l, double theta, double phase, uint32_t j, float *sums)
{
    const struct environment_map *source = l->source;
    double from = (j + 0.5) * PI / source->height, step = 2 * PI / source->width, total = 0;
    double along = cos(theta) * cos(from), across = sin(theta) * sin(from);
    double reach = (1 - CUT / l->kappa - along) / across; /* least cosine of the longitudes */
    if (l->kappa * (1 - along - across) > CUT)
        return 0;
    double angle = source == l->map ? row_angle(source->height, j, j + 1.0)
                                    : coarse_angle(l->map->height, source->height, j);
    int64_t half = source->width / 2, last = source->width - half - 1, most = half;
    if (reach > -1)
        most = (int64_t)(acos(fmin(reach, 1)) / step) + 1;
    for (int64_t k = most < half ? -most : -half; k <= (most < last ? most : last); k++) {
        double cosine = along + across * cos((k + 0.5 - phase) * step);
        double weight = angle * exp(l->kappa * (cosine - 1));
        size_t shift = (size_t)(k < 0 ? k + source->width : k);
        add_shifted(sums, source->texel[(size_t)j * source->width], 3 * (size_t)source->width,
                    3 * shift, (float)weight);
        total += (double)(float)weight;
    }
    return total;
}

static void fill_row(const struct lobe *l, uint32_t y, float *sums)
{
    const struct environment_level *level = l->level;
    uint32_t columns = l->source->width, phases = level->width / columns;
    float(*out)[3] = l->texel + (size_t)(y + 1) * level->width;
    double theta = (y + 0.5) * PI / level->height;
    for (uint32_t p = 0; p < phases; p++) {
        double total = 0;
        memset(sums, 0, (size_t)columns * 3 * sizeof *sums);
        for (uint32_t j = 0; j < l->source->height; j++)
            total += add_row(l, theta, (p + 0.5) / phases, j, sums);
        for (uint32_t i = 0; i < columns; i++)
            for (int k = 0; k < 3; k++)
                out[(size_t)i * phases + p][k] = (float)(sums[3 * i + k] * (l->scale / total));
    }
}

static void fill_rows(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct lobe *l = context;
    for (size_t y = begin; y < end; y++)
        fill_row(l, (uint32_t)y, l->sums + (size_t)worker * l->source->width * 3);
}

static enum stp_result shrink(const struct stp_env *env, const struct environment_map *map,
                              const struct environment_level *level, struct environment_map *shrunk)
{
    struct shrinking s = { map, shrunk };
    enum stp_result result = environment_allocate(env, "a level of the environment", level->width,
                                                  level->height, shrunk);
    if (result == STP_OK)
        parallel_for(env, shrunk->height, 4, shrink_rows, &s);
    return result;
}

static enum stp_result fill_rough(const struct stp_env *env, const struct environment_map *map,
                                  const struct environment_level *level, float scale,
                                  float (*texel)[3])
{
    struct environment_map shrunk = *map;
    const struct environment_map *source = map;
    enum stp_result result = STP_OK;
    if (is_shrunk(map, level->width, level->height)) {
        result = shrink(env, map, level, &shrunk);
        source = &shrunk;
    }
    if (result != STP_OK)
        return result;
    size_t floats = (size_t)thread_count(env) * source->width * 3;
    /* The tents of a coarser copy have spread the light by this much already. */
    double spread = PI / source->height, done = source == map ? 0 : spread * spread / 6;
    double kappa = 1 / (variance(map, level->roughness) - done);
    struct lobe lobe = {
        map, source, level, scale, texel, kappa, mem_alloc(floats, sizeof(float))
    };
    if (lobe.sums)
        parallel_for(env, level->height, 1, fill_rows, &lobe);
    else
        result = log_no_memory(env, floats * sizeof(float), "a row of the environment");
    mem_free(lobe.sums);
    if (source != map)
        environment_map_release(&shrunk);
    return result;
}

/* The pole's row beside `row`: its mean, everywhere. */
static void fill_pole(const float (*row)[3], float (*pole)[3], uint32_t width)
{
    double sum[3] = { 0 };
    for (uint32_t i = 0; i < width; i++)
        for (int k = 0; k < 3; k++)
            sum[k] += (double)row[i][k];
    for (uint32_t i = 0; i < width; i++)
        for (int k = 0; k < 3; k++)
            pole[i][k] = (float)(sum[k] / width);
}

enum stp_result environment_fill(const struct stp_env *env, const struct environment_map *map,
                                 const struct environment_level *level, float scale,
                                 float (*texel)[3])
{
    uint32_t width = level->width, height = level->height;
    if (level->roughness > 0) {
        enum stp_result result = fill_rough(env, map, level, scale, texel);
        if (result != STP_OK)
            return result;
    } else {
        for (size_t i = 0; i < (size_t)width * height; i++)
            for (int k = 0; k < 3; k++)
                texel[width + i][k] = map->texel[i][k] * scale;
    }
    fill_pole((const float(*)[3])texel + width, texel, width);
    fill_pole((const float(*)[3])texel + (size_t)height * width,
              texel + (size_t)(height + 1) * width, width);
    return STP_OK;
}
