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
#define TEXELS_A_SIGMA 3.6   /* of a level, in its lobe's standard deviation */
#define CUT            10.0  /* weights below exp(-CUT) are left out: 5e-5 of the lobe */
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

/* --- a coarser map: means weighted by solid angle ------------------------------------------- */

struct shrinking {
    const struct environment_map *in, *out;
};

static double row_angle(uint32_t height, double top, double bottom)
{
    return cos(top * PI / height) - cos(bottom * PI / height);
}

/* Adds weight times the mean of columns [from, to) of row j. */
static void add_mean(const struct environment_map *map, uint32_t j, double from, double to,
                     double weight, double sum[3])
{
    for (uint32_t i = (uint32_t)from; i < to && i < map->width; i++) {
        const float *texel = map->texel[(size_t)j * map->width + i];
        double share = weight * (fmin(i + 1.0, to) - fmax(i, from)) / (to - from);
        for (int k = 0; k < 3; k++)
            sum[k] += share * (double)texel[k];
    }
}

static void shrink_texel(const struct shrinking *s, uint32_t x, uint32_t y)
{
    const struct environment_map *in = s->in, *out = s->out;
    double rows = (double)in->height / out->height, columns = (double)in->width / out->width;
    double total = 0, sum[3] = { 0 }, top = y * rows, bottom = (y + 1) * rows;
    for (uint32_t j = (uint32_t)top; j < bottom && j < in->height; j++) {
        double angle = row_angle(in->height, fmax(j, top), fmin(j + 1.0, bottom));
        total += angle;
        add_mean(in, j, x * columns, (x + 1) * columns, angle, sum);
    }
    for (int k = 0; k < 3; k++)
        out->texel[(size_t)y * out->width + x][k] = (float)(sum[k] / total);
}

static void shrink_rows(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct shrinking *s = context;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < s->out->width; x++)
            shrink_texel(s, x, (uint32_t)y);
}

/* --- the lobe --------------------------------------------------------------------------------- */

struct lobe {
    const struct environment_map *source;
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
    double angle = row_angle(source->height, j, j + 1.0);
    double reach = (1 - CUT / l->kappa - along) / across; /* least cosine of the longitudes */
    if (l->kappa * (1 - along - across) > CUT)
        return 0;
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

/* The map at the level's resolution; or the map itself where that has no more texels. */
static enum stp_result make_source(const struct stp_env *env, const struct environment_map *map,
                                   const struct environment_level *level,
                                   struct environment_map *source)
{
    *source = *map;
    if (!is_shrunk(map, level->width, level->height))
        return STP_OK;
    enum stp_result result = environment_allocate(env, "a level of the environment", level->width,
                                                  level->height, source);
    struct shrinking s = { map, source };
    if (result == STP_OK)
        parallel_for(env, source->height, 4, shrink_rows, &s);
    return result;
}

static enum stp_result fill_rough(const struct stp_env *env, const struct environment_map *map,
                                  const struct environment_level *level, float scale,
                                  float (*texel)[3])
{
    struct environment_map source;
    enum stp_result result = make_source(env, map, level, &source);
    if (result != STP_OK)
        return result;
    size_t floats = (size_t)thread_count(env) * source.width * 3;
    struct lobe lobe = { &source, level, scale, texel, 1 / variance(map, level->roughness),
                         mem_alloc(floats, sizeof(float)) };
    if (lobe.sums)
        parallel_for(env, level->height, 1, fill_rows, &lobe);
    else
        result = log_no_memory(env, floats * sizeof(float), "a row of the environment");
    mem_free(lobe.sums);
    if (source.texel != map->texel)
        environment_map_release(&source);
    return result;
}

/* --- all of a level --------------------------------------------------------------------------- */

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
