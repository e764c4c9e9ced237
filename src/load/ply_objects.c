/* Objects of a prepared PLY (docs/formats.md): what its comments say of each, and whose a vertex
 * is.
 */
#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/ply.h"

#define MOST_OBJECTS 65535 /* a vertex names its own in 16 bits */

/* "I epsilon E", and " normals estimated" where they were. */
static bool parse(const struct slice *token, unsigned tokens, unsigned index,
                  struct cloud_object *object)
{
    double value;
    bool more = tokens == 5 && slice_is(token[3], "normals") && slice_is(token[4], "estimated");
    if ((tokens != 3 && !more) || !slice_is(token[1], "epsilon"))
        return false;
    const char *at = token[0].text, *end = at + token[0].length;
    if (!number_read(&at, end, &value) || at != end || value != index)
        return false;
    at = token[2].text, end = at + token[2].length;
    if (!number_read(&at, end, &value) || at != end || !(value >= 0 && value < INFINITY))
        return false;
    *object = (struct cloud_object){ .epsilon = value, .estimated = more };
    return true;
}

/* Room for one more, twice as much whenever it is full. */
static bool grow(struct ply_header *header)
{
    unsigned n = header->object_count;
    if (n & (n - 1))
        return true;
    struct cloud_object *objects =
        mem_realloc(header->objects, n ? 2 * (size_t)n : 1, sizeof *objects);
    if (objects)
        header->objects = objects;
    return objects != NULL;
}

enum stp_result ply_objects_note(const struct stp_env *env, const char *path,
                                 const struct slice *token, unsigned tokens,
                                 struct ply_header *header)
{
    struct cloud_object object;
    if (header->object_count == MOST_OBJECTS ||
        !parse(token, tokens, header->object_count, &object))
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: the header says of object %u what is no \"I epsilon E\": the file is "
                         "damaged; prepare the points again",
                         path, header->object_count);
    if (!grow(header))
        return log_no_memory(env, header->object_count * sizeof *header->objects, path);
    header->objects[header->object_count++] = object;
    return STP_OK;
}

enum stp_result ply_objects_plan(const struct stp_env *env, const char *path,
                                 const struct ply_header *header, const struct table *table,
                                 int *column)
{
    *column = -1;
    if (header->object_count < 2)
        return STP_OK;
    for (unsigned i = 0; i < table->count && *column < 0; i++)
        if (!table->column[i].list && slice_is(table->column[i].name, "object"))
            *column = (int)i;
    if (*column >= 0)
        return STP_OK;
    return log_error(env, STP_ERROR_FORMAT,
                     "%s: a prepared file of %u objects lacks the property \"object\": prepare the "
                     "points again",
                     path, header->object_count);
}

enum stp_result ply_objects_finish(const struct stp_env *env, const char *path,
                                   const struct ply_header *header, const float *raw,
                                   struct cloud *cloud)
{
    cloud->object = mem_alloc(cloud->count, sizeof *cloud->object);
    if (!cloud->object)
        return log_no_memory(env, cloud->count * sizeof *cloud->object, path);
    for (size_t i = 0; i < cloud->count; i++) {
        if (!(raw[i] >= 0 && raw[i] < (float)header->object_count && raw[i] == floorf(raw[i])))
            return log_error(env, STP_ERROR_FORMAT,
                             "%s: vertex %zu is of object %g, but the header knows %u: the file is "
                             "damaged; prepare the points again",
                             path, i, (double)raw[i], header->object_count);
        cloud->object[i] = (uint16_t)raw[i];
    }
    return STP_OK;
}
