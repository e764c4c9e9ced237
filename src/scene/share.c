/* A share of a prepared scene, for one of several processes. */
#include <stipple/machines.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

/* Moves elements [first, first + count) to the front and gives the rest back. Where that fails the
 * array only stays as large as it was. */
static void *keep(void *array, size_t size, size_t first, size_t count)
{
    if (!array)
        return NULL;
    memmove(array, (char *)array + first * size, count * size);
    void *smaller = mem_realloc(array, count, size);
    return smaller ? smaller : array;
}

static void keep_splats(struct splats *s, size_t first, size_t count)
{
    s->position = keep(s->position, sizeof *s->position, first, count);
    s->normal = keep(s->normal, sizeof *s->normal, first, count);
    s->radius = keep(s->radius, sizeof *s->radius, first, count);
    s->color = keep(s->color, sizeof *s->color, first, count);
    s->opacity = keep(s->opacity, sizeof *s->opacity, first, count);
    s->phong = keep(s->phong, sizeof *s->phong, first, count);
    s->object = keep(s->object, sizeof *s->object, first, count);
    s->input = keep(s->input, sizeof *s->input, first, count);
    s->group = keep(s->group, sizeof *s->group, first, count);
    s->count = count;
}

enum stp_result stp_scene_share(const struct stp_env *env, struct stp_scene *scene, unsigned rank,
                                unsigned count)
{
    size_t splats = scene->splats.count;
    if (scene->stream)
        return scene_check_whole(env, scene, "sharing");
    if (!scene->prepared || scene->share.count || scene->volume)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "only a prepared, whole scene of surfaces can be shared");
    if (rank >= count || count > splats)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "share %u of %u of %zu splats: every process needs one", rank, count,
                         splats);
    size_t first = (size_t)((unsigned __int128)splats * rank / count);
    size_t end = (size_t)((unsigned __int128)splats * (rank + 1) / count);
    keep_splats(&scene->splats, first, end - first);
    scene->share = (struct scene_share){ rank, count, first };
    scene->version.content = scene_change(scene);
    return STP_OK;
}
