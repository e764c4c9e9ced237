#include "scene/optics.h"

#include <math.h>

#include "base/log.h"

#define DEFAULT_IOR 1.5f

/* Every number of the struct: its name, where it is, how many, its range once it is set. */
struct field {
    const char *name;
    size_t offset;
    unsigned count;
    float least, most, preset;
};

#define FIELDS 5
static const struct field fields[FIELDS] = {
    { "ior", offsetof(struct stp_optics, ior), 3, 0.05f, 20, DEFAULT_IOR },
    { "reflectance", offsetof(struct stp_optics, reflectance), 3, 0, 1, 0 },
    { "roughness", offsetof(struct stp_optics, roughness), 1, 0, 1, 0 },
    { "absorption", offsetof(struct stp_optics, absorption), 3, 0, 1e30f, 0 },
    { "thickness", offsetof(struct stp_optics, thickness), 1, 0, 1e30f, 1 },
};

static const float *values_of(const struct stp_optics *optics, const struct field *field)
{
    return (const float *)((const char *)optics + field->offset);
}

static float *targets_of(struct stp_optics *optics, const struct field *field)
{
    return (float *)((char *)optics + field->offset);
}

enum stp_result optics_check(const struct stp_env *env, const struct stp_optics *optics)
{
    for (const struct field *f = fields; optics && f < fields + FIELDS; f++)
        for (unsigned i = 0; i < f->count; i++) {
            float v = values_of(optics, f)[i];
            if (!(v <= f->most) || v == -INFINITY || (v > 0 && v < f->least) ||
                (v < 0 && f->least > 0))
                return log_error(env, STP_ERROR_ARGUMENT, "%s is %g; it must be in [%g, %g]",
                                 f->name, (double)v, (double)f->least, (double)f->most);
        }
    return STP_OK;
}

struct stp_optics optics_resolve(const struct stp_optics *optics)
{
    struct stp_optics resolved = { 0 };
    for (const struct field *f = fields; f < fields + FIELDS; f++)
        for (unsigned i = 0; i < f->count; i++) {
            float v = optics ? values_of(optics, f)[i] : 0;
            targets_of(&resolved, f)[i] = v == 0 ? f->preset : fmaxf(v, 0);
        }
    return resolved;
}

struct stp_optics optics_merge(const struct stp_optics *under, const struct stp_optics *over)
{
    struct stp_optics merged = *under;
    for (const struct field *f = fields; over && f < fields + FIELDS; f++)
        for (unsigned i = 0; i < f->count; i++)
            if (values_of(over, f)[i] != 0)
                targets_of(&merged, f)[i] = values_of(over, f)[i];
    return merged;
}

bool optics_matter(const struct stp_optics *optics)
{
    for (int i = 0; i < 3; i++)
        if (optics->ior[i] != 1 || optics->reflectance[i] > 0 || optics->absorption[i] > 0)
            return true;
    return false;
}

/* 0 is a value in a file: it is kept as the negative that means 0. */
static enum stp_result get_field(const struct json_at *at, const cJSON *material,
                                 const struct field *f, float *target)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(material, f->name);
    double read[3];
    if (!item)
        return STP_OK;
    bool array = f->count == 3 && cJSON_IsArray(item);
    enum stp_result result = array ? json_get_numbers(at, material, f->name, 3, read)
                                   : json_get_number(at, material, f->name, &read[0]);
    for (unsigned i = 0; i < f->count && result == STP_OK; i++) {
        double v = array ? read[i] : read[0];
        if (!(v >= (double)f->least && v <= (double)f->most))
            return json_error(at, f->name,
                              f->least > 0  ? "0.05 to 20 is needed"
                              : f->most > 1 ? "numbers from 0 are needed"
                                            : "0 to 1 is needed");
        target[i] = v > 0 ? (float)v : -1;
    }
    return result;
}

enum stp_result optics_from_json(const struct json_at *at, const cJSON *material,
                                 struct stp_optics *optics)
{
    struct stp_optics read = *optics;
    enum stp_result result = STP_OK;
    for (const struct field *f = fields; f < fields + FIELDS && result == STP_OK; f++)
        result = get_field(at, material, f, targets_of(&read, f));
    if (result == STP_OK)
        *optics = read;
    return result;
}
