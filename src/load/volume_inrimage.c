/* INRIMAGE-4: lines KEY=value in a header of a multiple of 256 bytes, then the voxels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "load/volume.h"

#define BLOCK       256
#define MOST_HEADER 65536

bool inrimage_probe(const struct file_bytes *bytes)
{
    return bytes->size >= BLOCK && memcmp(bytes->data, "#INRIMAGE-4#{", 13) == 0;
}

struct inrimage {
    char type[32];
    double bits, dims[3], vectors;
    struct voxels voxels;
};

static enum stp_result take(const struct stp_env *env, const char *path,
                            const struct header_line *line, struct inrimage *file)
{
    static const char *const dims[] = { "XDIM", "YDIM", "ZDIM" };
    static const char *const spacing[] = { "VX", "VY", "VZ" };
    struct voxels *v = &file->voxels;
    bool good = true;
    for (int i = 0; i < 3; i++) {
        if (strcmp(line->key, dims[i]) == 0)
            good = header_numbers(line->value, 1, &file->dims[i]);
        if (strcmp(line->key, spacing[i]) == 0)
            good = header_numbers(line->value, 1, &v->spacing[i]);
    }
    if (strcmp(line->key, "VDIM") == 0)
        good = header_numbers(line->value, 1, &file->vectors);
    if (strcmp(line->key, "TYPE") == 0)
        memcpy(file->type, line->value, sizeof file->type - 1);
    if (strcmp(line->key, "PIXSIZE") == 0)
        file->bits = strtod(line->value, NULL);
    if (strcmp(line->key, "CPU") == 0)
        v->big_endian = strcmp(line->value, "sun") == 0 || strcmp(line->value, "sgi") == 0;
    return good ? STP_OK
                : log_error(env, STP_ERROR_FORMAT, "%s: %s=%s is no number", path, line->key,
                            line->value);
}

static enum record_type type_of(const struct inrimage *file)
{
    static const struct {
        const char *name;
        double bits;
        enum record_type type;
    } types[] = {
        { "float", 32, RECORD_FLOAT32 },         { "float", 64, RECORD_FLOAT64 },
        { "unsigned fixed", 8, RECORD_UINT8 },   { "unsigned fixed", 16, RECORD_UINT16 },
        { "unsigned fixed", 32, RECORD_UINT32 }, { "signed fixed", 8, RECORD_INT8 },
        { "signed fixed", 16, RECORD_INT16 },    { "signed fixed", 32, RECORD_INT32 },
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcmp(types[i].name, file->type) == 0 && types[i].bits == file->bits)
            return types[i].type;
    return RECORD_NONE;
}

/* The end of the header: after "##}\n", at a multiple of 256. 0: there is none. */
static size_t header_end(const struct file_bytes *bytes)
{
    for (size_t end = BLOCK; end <= bytes->size && end <= MOST_HEADER; end += BLOCK)
        if (memcmp(bytes->data + end - 4, "##}\n", 4) == 0)
            return end;
    return 0;
}

enum stp_result inrimage_read(const struct stp_env *env, const char *path,
                              const struct file_bytes *bytes, struct grid *grid)
{
    struct inrimage file = {
        .vectors = 1, .voxels = { .spacing = { 1, 1, 1 }, .up = STP_UP_Y, .format = "INRIMAGE" }
    };
    struct header_line line;
    size_t end = header_end(bytes);
    if (end == 0)
        return log_error(env, STP_ERROR_FORMAT, "%s: the INRIMAGE header does not end", path);
    const char *text = (const char *)bytes->data;
    struct header header = { text, text, text + end, '=' };
    while (header_next(&header, &line)) {
        enum stp_result result = take(env, path, &line, &file);
        if (result != STP_OK)
            return result;
    }
    struct voxels *v = &file.voxels;
    for (int i = 0; i < 3; i++)
        v->dims[i] = file.dims[i] >= 1 && file.dims[i] <= 4294967295.0 ? (uint64_t)file.dims[i] : 0;
    v->type = type_of(&file);
    if (file.vectors != 1 || v->type == RECORD_NONE)
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: voxels of %g numbers, \"%s\" of %g bits, are no scalars that are "
                         "read",
                         path, file.vectors, file.type, file.bits);
    return grid_from_voxels(env, path, bytes, end, v, grid);
}
