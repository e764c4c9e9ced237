#include "reference/environment.h"

#include "scene/axes.h"

#define PI    3.14159265358979323846
#define FAINT 30.0 /* a weight of exp(-30) adds nothing */

/* World direction to longitude (from the map's centre, to the right) and polar angle. */
static void angles_of(const struct view *view, struct vec3 d, double *longitude, double *polar)
{
    struct scene_axes axes = scene_axes(view->scene->facts.up);
    struct vec3 world = eye_direction_to_world(&view->eye, d);
    double right = v3_dot(world, axes.right), up = v3_dot(world, axes.up);
    double ahead = -v3_dot(world, axes.viewer);
    *longitude = atan2(right, ahead) + view->scene->environment.params.rotation;
    *polar = acos(fmin(fmax(up, -1), 1));
}

static struct vec3 texel(const struct environment_map *map, int64_t x, int64_t y)
{
    int64_t width = map->width;
    return v3_loadf(map->texel[y * width + ((x % width) + width) % width]);
}

static struct vec3 mean_of_row(const struct environment_map *map, int64_t y)
{
    struct vec3 sum = v3(0, 0, 0);
    for (uint32_t x = 0; x < map->width; x++)
        sum = v3_add(sum, texel(map, x, y));
    return v3_scale(sum, 1.0 / map->width);
}

static struct vec3 lerp(struct vec3 a, struct vec3 b, double t)
{
    return v3_add(v3_scale(a, 1 - t), v3_scale(b, t));
}

/* Along a row of texel centres. */
static struct vec3 along(const struct environment_map *map, double x, int64_t y)
{
    int64_t left = (int64_t)floor(x);
    return lerp(texel(map, left, y), texel(map, left + 1, y), x - (double)left);
}

/* Between rows of centres; beyond the first and the last towards the pole's mean, half a row off.
 */
static struct vec3 sharp(const struct environment_map *map, double longitude, double polar)
{
    int64_t last = (int64_t)map->height - 1;
    double x = (longitude / (2 * PI) + 0.5) * map->width - 0.5;
    double y = polar / PI * map->height - 0.5;
    if (y < 0)
        return lerp(along(map, x, 0), mean_of_row(map, 0), -2 * y);
    if (y >= (double)last)
        return lerp(along(map, x, last), mean_of_row(map, last), 2 * (y - (double)last));
    int64_t row = (int64_t)floor(y);
    return lerp(along(map, x, row), along(map, x, row + 1), y - (double)row);
}

static struct vec3 lobe(const struct environment_map *map, double longitude, double polar,
                        double roughness)
{
    double width = map->width, height = map->height, texel_size = fmax(PI / height, 2 * PI / width);
    double kappa = 1 / (2 * pow(roughness, 4) + texel_size * texel_size / 4), total = 0;
    struct vec3 sum = v3(0, 0, 0);
    for (uint32_t j = 0; j < map->height; j++) {
        double row = (j + 0.5) * PI / height;
        double angle = cos(j * PI / height) - cos((j + 1.0) * PI / height);
        if (kappa * (1 - cos(row - polar)) > FAINT)
            continue;
        for (uint32_t i = 0; i < map->width; i++) {
            double apart = (i + 0.5) / width * 2 * PI - PI - longitude;
            double cosine = cos(row) * cos(polar) + sin(row) * sin(polar) * cos(apart);
            double weight = angle * exp(kappa * (cosine - 1));
            total += weight;
            sum = v3_add(sum, v3_scale(texel(map, i, j), weight));
        }
    }
    return v3_scale(sum, 1 / total);
}

static struct vec3 level_row(const struct scene_environment *e, size_t first, uint32_t width,
                             double x)
{
    int64_t left = (int64_t)floor(x), w = width;
    struct vec3 a = v3_loadf(e->texel[first + (size_t)(((left % w) + w) % w)]);
    struct vec3 b = v3_loadf(e->texel[first + (size_t)((((left + 1) % w) + w) % w)]);
    return lerp(a, b, x - (double)left);
}

/* Rows 0 and height + 1 are the poles, half a texel beyond the rows beside them. */
static struct vec3 level_light(const struct scene_environment *e, unsigned i, double longitude,
                               double polar)
{
    const struct environment_level *level = &e->level[i];
    double height = level->height, x = (longitude / (2 * PI) + 0.5) * level->width - 0.5;
    double y = polar / PI * height + 0.5;
    y = y < 1 ? 2 * y - 1 : y > height ? 2 * y - height : y;
    double row = fmin(fmax(floor(y), 0), height);
    size_t at = level->first + (size_t)row * level->width;
    return lerp(level_row(e, at, level->width, x), level_row(e, at + level->width, level->width, x),
                y - row);
}

/* Between the levels of the roughnesses below and above. */
static struct vec3 leveled(const struct scene_environment *e, double longitude, double polar,
                           double roughness)
{
    unsigned i = 0;
    while (i + 1 < e->level_count && (double)e->level[i + 1].roughness <= roughness)
        i++;
    struct vec3 light = level_light(e, i, longitude, polar);
    double low = (double)e->level[i].roughness;
    if (i + 1 == e->level_count || !(roughness > low))
        return light;
    double high = (double)e->level[i + 1].roughness;
    return lerp(light, level_light(e, i + 1, longitude, polar), (roughness - low) / (high - low));
}

struct vec3 environment_light(const struct view *view, struct vec3 d, double roughness)
{
    const struct scene_environment *e = &view->scene->environment;
    double longitude, polar, intensity = e->params.intensity > 0 ? (double)e->params.intensity : 1;
    angles_of(view, d, &longitude, &polar);
    if (view->leveled && roughness > 0)
        return leveled(e, longitude, polar, roughness);
    struct vec3 light = roughness > 0 ? lobe(&e->map, longitude, polar, roughness)
                                      : sharp(&e->map, longitude, polar);
    return v3_scale(light, intensity);
}
