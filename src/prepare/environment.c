#include "prepare/environment.h"

#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/environment.h"
#include "scene/optics.h"

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The roughnesses that levels are made for, ascending, the first 0; evenly spaced ones where the
 * materials have more than there is room for. */
static unsigned choose_roughnesses(float *value, size_t count, float out[ENVIRONMENT_LEVELS])
{
    size_t distinct = 0;
    qsort(value, count, sizeof *value, by_value);
    for (size_t i = 0; i < count; i++)
        if (value[i] > 0 && (distinct == 0 || value[i] != value[distinct - 1]))
            value[distinct++] = value[i];
    out[0] = 0;
    if (distinct < ENVIRONMENT_LEVELS) {
        memcpy(out + 1, value, distinct * sizeof *out);
        return 1 + (unsigned)distinct;
    }
    float low = value[0], high = value[distinct - 1];
    for (int i = 0; i < ENVIRONMENT_LEVELS - 1; i++)
        out[1 + i] = low + (high - low) * (float)i / (ENVIRONMENT_LEVELS - 2);
    return ENVIRONMENT_LEVELS;
}

static void lay_out(struct scene_environment *e)
{
    e->texel_count = 0;
    for (unsigned i = 0; i < e->level_count; i++) {
        struct environment_level *level = &e->level[i];
        level->width = e->map.width;
        level->height = e->map.height;
        if (i)
            environment_level_size(&e->map, level->roughness, &level->width, &level->height);
        level->first = e->texel_count;
        e->texel_count += ((size_t)level->height + 2) * level->width;
    }
}

static enum stp_result choose_levels(const struct stp_env *env, const struct stp_scene *scene,
                                     struct scene_environment *e)
{
    float chosen[ENVIRONMENT_LEVELS], *all = mem_alloc(scene->object_count + 1, sizeof *all);
    if (!all)
        return log_no_memory(env, scene->object_count * sizeof *all, "roughnesses");
    size_t count = 0;
    for (unsigned i = 0; i < scene->object_count; i++)
        if (optics_matter(&scene->objects[i].optics))
            all[count++] = scene->objects[i].optics.roughness;
    e->level_count = choose_roughnesses(all, count, chosen);
    mem_free(all);
    for (unsigned i = 0; i < e->level_count; i++)
        e->level[i].roughness = chosen[i];
    lay_out(e);
    return STP_OK;
}

enum stp_result environment_build(const struct stp_env *env, const struct stp_scene *scene,
                                  struct scene_environment *environment)
{
    struct scene_environment made = { .map = environment->map, .params = environment->params };
    if (!made.map.width)
        return STP_OK;
    enum stp_result result = choose_levels(env, scene, &made);
    if (result != STP_OK)
        return result;
    made.texel = mem_alloc(made.texel_count, sizeof *made.texel);
    if (!made.texel)
        return log_no_memory(env, made.texel_count * sizeof *made.texel, "an environment");
    float scale = made.params.intensity > 0 ? made.params.intensity : 1;
    for (unsigned i = 0; i < made.level_count && result == STP_OK; i++)
        result = environment_fill(env, &made.map, &made.level[i], scale,
                                  made.texel + made.level[i].first);
    if (result == STP_OK)
        *environment = made;
    else
        mem_free(made.texel);
    return result;
}

float environment_level_at(const struct scene_environment *e, float roughness)
{
    unsigned i = 0;
    while (i + 1 < e->level_count && e->level[i + 1].roughness <= roughness)
        i++;
    if (i + 1 == e->level_count)
        return (float)i;
    float low = e->level[i].roughness, high = e->level[i + 1].roughness;
    return (float)i + (roughness - low) / (high - low);
}

void environment_facts(const struct stp_scene *scene, struct stp_facts *facts)
{
    const struct scene_environment *e = &scene->environment;
    facts->environment_levels = e->level_count;
    facts->environment_texels = e->texel_count;
    facts->reflects = facts->disperses = facts->mirrors = facts->between_levels = facts->absorbs =
        false;
    for (unsigned i = 0; i < scene->object_count && e->level_count; i++) {
        const struct stp_optics *o = &scene->objects[i].optics;
        float level = environment_level_at(e, o->roughness);
        if (!optics_matter(o))
            continue;
        facts->reflects = true;
        facts->disperses |= o->ior[0] != o->ior[1] || o->ior[1] != o->ior[2];
        facts->mirrors |= o->reflectance[0] > 0 || o->reflectance[1] > 0 || o->reflectance[2] > 0;
        facts->absorbs |= o->absorption[0] > 0 || o->absorption[1] > 0 || o->absorption[2] > 0;
        facts->between_levels |= level != (float)(unsigned)level;
    }
}

/* Takes over `made`; its map is released on failure. */
static enum stp_result install(const struct stp_env *env, struct stp_scene *scene,
                               struct scene_environment *made)
{
    enum stp_result result = scene->prepared ? environment_build(env, scene, made) : STP_OK;
    if (result != STP_OK) {
        environment_release(made);
        return result;
    }
    environment_release(&scene->environment);
    scene->environment = *made;
    environment_facts(scene, &scene->facts);
    scene->version.content = scene_change(scene);
    return STP_OK;
}

static enum stp_result check(const struct stp_env *env, const struct stp_scene *scene,
                             const struct stp_environment_params *params)
{
    if (!scene)
        return log_error(env, STP_ERROR_ARGUMENT, "an environment needs a scene");
    return environment_check_params(env, params);
}

enum stp_result stp_scene_load_environment(const struct stp_env *env, struct stp_scene *scene,
                                           const char *path,
                                           const struct stp_environment_params *params)
{
    struct scene_environment made = { 0 };
    enum stp_result result = check(env, scene, params);
    if (result != STP_OK)
        return result;
    if (params)
        made.params = *params;
    result = environment_read(env, path, &made.map);
    return result == STP_OK ? install(env, scene, &made) : result;
}

enum stp_result stp_scene_set_environment(const struct stp_env *env, struct stp_scene *scene,
                                          uint32_t width, uint32_t height, const float (*texel)[3],
                                          const struct stp_environment_params *params)
{
    static const char what[] = "the environment";
    struct scene_environment made = { 0 };
    enum stp_result result = check(env, scene, params);
    if (result != STP_OK)
        return result;
    if (params)
        made.params = *params;
    if (texel) {
        result = environment_allocate(env, what, width, height, &made.map);
        if (result != STP_OK)
            return result;
        memcpy(made.map.texel, texel, (size_t)width * height * sizeof *texel);
        environment_bound(env, what, &made.map);
    }
    return install(env, scene, &made);
}
