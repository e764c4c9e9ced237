/* Files of voxels alone: what they are is said by the caller or by a .json beside them. */
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "base/json.h"
#include "base/log.h"
#include "base/memory.h"
#include "load/volume.h"

struct type_name {
    const char *name;
    enum record_type type;
};

/* Longer names first: a name may be the start of another. */
static const struct type_name type_names[] = {
    { "unsigned long long int", RECORD_UINT64 },
    { "unsigned long long", RECORD_UINT64 },
    { "unsigned short int", RECORD_UINT16 },
    { "signed short int", RECORD_INT16 },
    { "long long int", RECORD_INT64 },
    { "unsigned short", RECORD_UINT16 },
    { "unsigned char", RECORD_UINT8 },
    { "MET_ULONG_LONG", RECORD_UINT64 },
    { "MET_LONG_LONG", RECORD_INT64 },
    { "unsigned int", RECORD_UINT32 },
    { "signed short", RECORD_INT16 },
    { "signed char", RECORD_INT8 },
    { "signed int", RECORD_INT32 },
    { "MET_DOUBLE", RECORD_FLOAT64 },
    { "MET_USHORT", RECORD_UINT16 },
    { "long long", RECORD_INT64 },
    { "short int", RECORD_INT16 },
    { "MET_SHORT", RECORD_INT16 },
    { "MET_FLOAT", RECORD_FLOAT32 },
    { "MET_UCHAR", RECORD_UINT8 },
    { "MET_CHAR", RECORD_INT8 },
    { "MET_UINT", RECORD_UINT32 },
    { "MET_INT", RECORD_INT32 },
    { "float32", RECORD_FLOAT32 },
    { "float64", RECORD_FLOAT64 },
    { "uint16", RECORD_UINT16 },
    { "uint32", RECORD_UINT32 },
    { "uint64", RECORD_UINT64 },
    { "double", RECORD_FLOAT64 },
    { "ushort", RECORD_UINT16 },
    { "uint8", RECORD_UINT8 },
    { "uchar", RECORD_UINT8 },
    { "int16", RECORD_INT16 },
    { "int32", RECORD_INT32 },
    { "int64", RECORD_INT64 },
    { "short", RECORD_INT16 },
    { "float", RECORD_FLOAT32 },
    { "int8", RECORD_INT8 },
    { "uint", RECORD_UINT32 },
    { "int", RECORD_INT32 },
    { "u16", RECORD_UINT16 },
    { "i16", RECORD_INT16 },
    { "f32", RECORD_FLOAT32 },
    { "f64", RECORD_FLOAT64 },
    { "u8", RECORD_UINT8 },
};

bool voxel_type_read(const char *text, enum record_type *type, bool *big_endian)
{
    for (size_t i = 0; i < sizeof type_names / sizeof *type_names; i++) {
        size_t length = strlen(type_names[i].name);
        if (strncasecmp(text, type_names[i].name, length) != 0)
            continue;
        if (strncmp(text + length, "_t", 2) == 0) /* as C has it */
            length += 2;
        if (text[length] != 0 && text[length] != ' ')
            return false;
        *type = type_names[i].type;
        *big_endian |= strstr(text + length, "big-endian") || strstr(text + length, " BE");
        return true;
    }
    return false;
}

static enum stp_result get_up(const struct json_at *at, const cJSON *object, enum stp_up *up)
{
    static const char *const names[] = { "auto", "x", "y", "z", "-y" };
    const char *name = NULL;
    enum stp_result result = json_get_string(at, object, "up", &name);
    for (unsigned i = 0; result == STP_OK && name && i < 5; i++)
        if (strcmp(names[i], name) == 0)
            *up = (enum stp_up)i;
    return result;
}

/* One object: dims, dtype and the rest. */
static enum stp_result take_entry(const struct json_at *at, const cJSON *object,
                                  struct raw_volume *raw)
{
    double dims[3] = { 0 };
    const char *type = NULL;
    struct voxels *v = &raw->voxels;
    enum stp_result result =
        json_check_object(at, object, "dims dtype type spacing origin up note name comment");
    if (result == STP_OK)
        result = json_get_numbers(at, object, "dims", 3, dims);
    if (result == STP_OK)
        result = json_get_numbers(at, object, "spacing", 3, v->spacing);
    if (result == STP_OK && json_has(object, "origin")) {
        result = json_get_numbers(at, object, "origin", 3, v->origin);
        v->has_origin = true;
    }
    const char *key = json_has(object, "type") ? "type" : "dtype";
    if (result == STP_OK)
        result = json_get_string(at, object, key, &type);
    if (result == STP_OK)
        result = get_up(at, object, &v->up);
    if (result != STP_OK)
        return result;
    for (int i = 0; i < 3; i++) {
        if (!(dims[i] >= 1 && dims[i] <= 4294967295.0) || dims[i] != (double)(uint64_t)dims[i])
            return json_error(at, "dims", "three whole numbers from 1 are needed");
        v->dims[i] = (uint64_t)dims[i];
    }
    if (!type || !voxel_type_read(type, &v->type, &v->big_endian))
        return json_error(at, key, "a type is needed: uint8, uint16, int16, float32, ...");
    raw->known = true;
    return STP_OK;
}

static enum stp_result take_file(const struct stp_env *env, const char *json_path, const char *name,
                                 struct raw_volume *raw)
{
    cJSON *json = NULL;
    enum stp_result result = json_read(env, json_path, &json);
    if (result != STP_OK)
        return result;
    struct json_at root = json_root(env, json_path);
    const cJSON *entry = cJSON_GetObjectItemCaseSensitive(json, name);
    if (entry) {
        struct json_at at = json_below(&root, name, -1);
        result = take_entry(&at, entry, raw);
    } else if (json_has(json, "dims")) {
        result = take_entry(&root, json, raw);
    }
    cJSON_Delete(json);
    return result;
}

/* The candidate's path into `out`, of `size` bytes. */
static void candidate(const char *path, int which, char *out, size_t size)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    size_t stem = dot && dot != base ? (size_t)(dot - path) : strlen(path);
    if (which == 0)
        snprintf(out, size, "%s.json", path);
    else if (which == 1)
        snprintf(out, size, "%.*s.json", (int)stem, path);
    else
        snprintf(out, size, "%.*svolumes.json", (int)(base - path), path);
}

static enum stp_result search(const struct stp_env *env, const char *path, struct raw_volume *raw)
{
    const char *slash = strrchr(path, '/');
    size_t size = strlen(path) + 16;
    char *beside = mem_alloc(size, 1);
    if (!beside)
        return log_no_memory(env, size, path);
    enum stp_result result = STP_OK;
    for (int which = 0; which < 3 && result == STP_OK && !raw->known; which++) {
        candidate(path, which, beside, size);
        if (strcmp(beside, path) != 0 && access(beside, R_OK) == 0)
            result = take_file(env, beside, slash ? slash + 1 : path, raw);
    }
    mem_free(beside);
    return result;
}

static void override(const struct stp_volume_params *params, struct raw_volume *raw)
{
    static const enum record_type types[] = { RECORD_NONE, RECORD_UINT8, RECORD_UINT16,
                                              RECORD_INT16, RECORD_FLOAT32 };
    struct voxels *v = &raw->voxels;
    for (int i = 0; i < 3 && params->dims[0]; i++)
        v->dims[i] = params->dims[i];
    for (int i = 0; i < 3 && params->spacing[0] > 0; i++)
        v->spacing[i] = params->spacing[i];
    if (params->type != STP_VOXEL_AUTO) {
        v->type = types[params->type];
        v->big_endian = false;
    }
    raw->known = raw->known || params->dims[0] > 0;
    if (raw->known && v->type == RECORD_NONE)
        v->type = RECORD_UINT8;
}

enum stp_result raw_volume_find(const struct stp_env *env, const char *path,
                                const struct stp_volume_params *params, struct raw_volume *raw)
{
    static const struct stp_volume_params none;
    struct raw_volume found = {
        .voxels = { .spacing = { 1, 1, 1 }, .up = STP_UP_Y, .format = "raw voxels" }
    };
    params = params ? params : &none;
    /* Dims of the caller's are the whole description: what stands beside it is another file's. */
    enum stp_result result = params->dims[0] ? STP_OK : search(env, path, &found);
    if (result != STP_OK)
        return result;
    override(params, &found);
    if (found.voxels.up == STP_UP_AUTO)
        found.voxels.up = STP_UP_Y;
    *raw = found;
    return STP_OK;
}
