/* Elliptical splats in a prepared PLY (docs/formats.md): read as floats, then made what they are.
 */
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/ply.h"

/* All of the first set, or none; all of the second, or none, and only with the first. */
static const char *const names[] = {
    "tangent_x", "tangent_y", "tangent_z", "radius_u",   "radius_v",    "field_0",
    "field_1",   "field_2",   "field_3",   "clip_0_a",   "clip_0_b",    "clip_0_c",
    "clip_1_a",  "clip_1_b",  "clip_1_c",  "clip_count", "clip_reflex",
};
static const char *const prefixes[] = { "tangent_", "radius_", "field_", "clip_" };
_Static_assert(sizeof names / sizeof *names == PLY_PHONG_VALUES, "names");

#define WITHOUT_CLIPS 9 /* names of the first set */
#define CLIP_COUNT    15
#define CLIP_REFLEX   16

static int find(const struct table *table, const char *name)
{
    for (unsigned i = 0; i < table->count; i++)
        if (!table->column[i].list && slice_is(table->column[i].name, name))
            return (int)i;
    return -1;
}

static bool is_known(struct slice name)
{
    for (unsigned i = 0; i < PLY_PHONG_VALUES; i++)
        if (slice_is(name, names[i]))
            return true;
    return false;
}

static bool is_ours(struct slice name)
{
    for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; i++) {
        size_t length = strlen(prefixes[i]);
        if (name.length > length && memcmp(name.text, prefixes[i], length) == 0)
            return true;
    }
    return false;
}

static enum stp_result refuse(const struct stp_env *env, const char *path, const char *what,
                              const char *name)
{
    return log_error(env, STP_ERROR_FORMAT,
                     "%s: a prepared file %s property \"%s\": ellipses are read whole or not at "
                     "all; prepare the points again",
                     path, what, name);
}

enum stp_result ply_phong_plan(const struct stp_env *env, const char *path,
                               const struct table *table, unsigned *values)
{
    unsigned most = 0;
    bool any = false;
    for (unsigned i = 0; i < table->count; i++) {
        char text[40];
        slice_copy(table->column[i].name, text, sizeof text);
        if (is_ours(table->column[i].name) && !is_known(table->column[i].name))
            return refuse(env, path, "has the unknown", text);
        for (unsigned n = 0; n < PLY_PHONG_VALUES; n++)
            if (slice_is(table->column[i].name, names[n]))
                most = n > most ? n : most, any = true;
    }
    *values = !any ? 0 : most < WITHOUT_CLIPS ? WITHOUT_CLIPS : PLY_PHONG_VALUES;
    for (unsigned n = 0; n < *values; n++)
        if (find(table, names[n]) < 0)
            return refuse(env, path, "lacks the", names[n]);
    if (*values && !table_has(table, ROLE_NX))
        return refuse(env, path, "lacks the", "nx");
    return STP_OK;
}

void ply_phong_slots(struct table *table, unsigned values, float (*raw)[PLY_PHONG_VALUES])
{
    for (unsigned n = 0; n < values; n++)
        table->column[find(table, names[n])].slot[0] =
            (struct slot){ (char *)&raw[0][n], sizeof *raw, false };
}

/* Of a byte: a number that it cannot hold becomes one that no splat has. */
static uint8_t byte_of(float value)
{
    return value >= 0 && value < 255 ? (uint8_t)value : 255;
}

enum stp_result ply_phong_finish(const struct stp_env *env, const char *path, unsigned values,
                                 const float (*raw)[PLY_PHONG_VALUES], struct cloud *cloud)
{
    cloud->phong = mem_zalloc(cloud->count, sizeof *cloud->phong);
    if (!cloud->phong)
        return log_no_memory(env, cloud->count * sizeof *cloud->phong, path);
    for (size_t i = 0; i < cloud->count; i++) {
        struct stp_phong_splat *p = &cloud->phong[i];
        memcpy(p->u, &raw[i][0], sizeof p->u);
        memcpy(p->radius, &raw[i][3], sizeof p->radius);
        memcpy(p->field, &raw[i][5], sizeof p->field);
        if (values <= WITHOUT_CLIPS)
            continue;
        memcpy(p->clip, &raw[i][WITHOUT_CLIPS], sizeof p->clip);
        p->clips = byte_of(raw[i][CLIP_COUNT]);
        p->reflex = raw[i][CLIP_REFLEX] != 0;
    }
    return STP_OK;
}
