/* One file of several objects to a cloud an object. */
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/cloud.h"

/* An array for those of `count` points that the whole has one of; false: out of memory. */
static bool like(const void *whole, size_t count, size_t size, void *array)
{
    void *made = whole ? mem_alloc(count, size) : NULL;
    memcpy(array, &made, sizeof made);
    return made || !whole;
}

static bool allocate_part(const struct cloud *whole, size_t count,
                          const struct cloud_object *object, struct cloud *part)
{
    *part = (struct cloud){ .up = whole->up, .object_count = 1 };
    memcpy(part->format, whole->format, sizeof part->format);
    part->objects = mem_alloc(1, sizeof *part->objects);
    if (part->objects)
        *part->objects = *object;
    if (count == 0)
        return part->objects != NULL;
    return part->objects &&
           like(whole->position, count, sizeof *whole->position, &part->position) &&
           like(whole->normal, count, sizeof *whole->normal, &part->normal) &&
           like(whole->radius, count, sizeof *whole->radius, &part->radius) &&
           like(whole->color, count, sizeof *whole->color, &part->color) &&
           like(whole->opacity, count, sizeof *whole->opacity, &part->opacity) &&
           like(whole->phong, count, sizeof *whole->phong, &part->phong);
}

/* Point i of the whole becomes the part's next. */
static void append(const struct cloud *whole, size_t i, struct cloud *part)
{
    size_t at = part->count++;
    memcpy(part->position[at], whole->position[i], sizeof *part->position);
    if (part->normal)
        memcpy(part->normal[at], whole->normal[i], sizeof *part->normal);
    if (part->radius)
        part->radius[at] = whole->radius[i];
    if (part->color)
        memcpy(part->color[at], whole->color[i], sizeof *part->color);
    if (part->opacity)
        part->opacity[at] = whole->opacity[i];
    if (part->phong)
        part->phong[at] = whole->phong[i];
}

enum stp_result cloud_split(const struct stp_env *env, const struct cloud *cloud,
                            struct cloud **parts)
{
    unsigned objects = cloud->object_count;
    size_t *count = mem_zalloc(objects, sizeof *count);
    struct cloud *made = mem_zalloc(objects, sizeof *made);
    bool good = count && made;
    for (size_t i = 0; good && i < cloud->count; i++)
        count[cloud->object[i]]++;
    for (unsigned i = 0; good && i < objects; i++)
        good = allocate_part(cloud, count[i], &cloud->objects[i], &made[i]);
    mem_free(count);
    if (!good) {
        for (unsigned i = 0; made && i < objects; i++)
            cloud_release(&made[i]);
        mem_free(made);
        return log_no_memory(env, cloud->count * sizeof *cloud->position, "the file's objects");
    }
    for (size_t i = 0; i < cloud->count; i++)
        append(cloud, i, &made[cloud->object[i]]);
    *parts = made;
    return STP_OK;
}
