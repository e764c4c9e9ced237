#include "load/environment.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"

enum stp_result environment_allocate(const struct stp_env *env, const char *path, uint64_t width,
                                     uint64_t height, struct environment_map *map)
{
    if (width < 1 || height < 1 || width > ENVIRONMENT_MOST_SIDE ||
        height > ENVIRONMENT_MOST_SIDE || width * height > ENVIRONMENT_MOST_TEXELS)
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: an environment map of %llu x %llu; 1 x 1 to 16384 x 8192 is read",
                         path, (unsigned long long)width, (unsigned long long)height);
    map->texel = mem_alloc(width * height, sizeof *map->texel);
    if (!map->texel)
        return log_no_memory(env, width * height * sizeof *map->texel, path);
    map->width = (uint32_t)width;
    map->height = (uint32_t)height;
    return STP_OK;
}

void environment_map_release(struct environment_map *map)
{
    mem_free(map->texel);
    *map = (struct environment_map){ 0 };
}

void environment_bound(const struct stp_env *env, const char *path, struct environment_map *map)
{
    size_t count = (size_t)map->width * map->height * 3, bad = 0, over = 0;
    float *value = &map->texel[0][0];
    for (size_t i = 0; i < count; i++) {
        if (!(value[i] >= 0)) {
            bad++;
            value[i] = 0;
        } else if (value[i] > ENVIRONMENT_MOST_VALUE) {
            over++;
            value[i] = ENVIRONMENT_MOST_VALUE;
        }
    }
    if (bad || over)
        log_warning(env,
                    "%s: %zu values that are NaN or negative became 0, %zu above %g became that",
                    path, bad, over, (double)ENVIRONMENT_MOST_VALUE);
}

/* Twice as wide as high, or what is around is stretched. */
static void check_shape(const struct stp_env *env, const char *path,
                        const struct environment_map *map)
{
    if (map->width != 2 * map->height)
        log_warning(env,
                    "%s: %u x %u is not twice as wide as high; it is stretched over the sphere",
                    path, map->width, map->height);
}

enum stp_result environment_read(const struct stp_env *env, const char *path,
                                 struct environment_map *map)
{
    struct file_bytes bytes = { 0 };
    struct environment_map read = { 0 };
    enum stp_result result = file_read(env, path, &bytes);
    if (result != STP_OK)
        return result;
    if (environment_is_hdr(&bytes))
        result = environment_read_hdr(env, path, &bytes, &read);
    else if (environment_is_exr(&bytes))
        result = environment_read_exr(env, path, &bytes, &read);
    else
        result = log_error(env, STP_ERROR_FORMAT,
                           "%s: neither OpenEXR nor Radiance .hdr; an environment map is a "
                           "latitude-longitude picture in one of these",
                           path);
    file_release(&bytes);
    if (result != STP_OK) {
        environment_map_release(&read);
        return result;
    }
    check_shape(env, path, &read);
    environment_bound(env, path, &read);
    *map = read;
    return STP_OK;
}
