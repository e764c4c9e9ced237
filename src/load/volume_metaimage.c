/* MetaImage (.mha, .mhd): "Key = value" up to ElementDataFile, then the voxels, or the file named
 * there. Compressed data are zlib's. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "load/volume.h"

struct metaimage {
    const struct stp_env *env;
    const char *path;
    double rank, dims[3], channels, skip;
    bool packed, ended, text;
    char type[64], data_file[256];
    struct voxels voxels;
};

bool metaimage_probe(const struct file_bytes *bytes)
{
    static const char *const starts[] = { "ObjectType", "NDims", "Comment" };
    for (int i = 0; i < 3; i++) {
        size_t length = strlen(starts[i]), at = length;
        if (bytes->size <= length || memcmp(bytes->data, starts[i], length) != 0)
            continue;
        while (at < bytes->size && bytes->data[at] == ' ')
            at++;
        return at < bytes->size && bytes->data[at] == '=';
    }
    return false;
}

static bool is_true(const char *value)
{
    return value[0] == 'T' || value[0] == 't' || value[0] == '1';
}

/* Row i is the direction of axis i. */
static bool take_matrix(struct voxels *v, const char *value)
{
    double m[9];
    if (!header_numbers(value, 9, m))
        return false;
    memcpy(v->direction, m, sizeof m);
    v->up = STP_UP_Z;
    return true;
}

static bool take(struct metaimage *file, const struct header_line *line)
{
    struct voxels *v = &file->voxels;
    const char *key = line->key, *value = line->value;
    if (strcmp(key, "NDims") == 0)
        return header_numbers(value, 1, &file->rank);
    if (strcmp(key, "DimSize") == 0)
        return file->rank != 3 || header_numbers(value, 3, file->dims);
    if (strcmp(key, "ElementSpacing") == 0 || strcmp(key, "ElementSize") == 0)
        return header_numbers(value, 3, v->spacing);
    if (strcmp(key, "TransformMatrix") == 0 || strcmp(key, "Rotation") == 0)
        return take_matrix(v, value);
    if (strcmp(key, "Offset") == 0 || strcmp(key, "Position") == 0 || strcmp(key, "Origin") == 0)
        return v->has_origin = header_numbers(value, 3, v->origin);
    if (strcmp(key, "ElementNumberOfChannels") == 0)
        return header_numbers(value, 1, &file->channels);
    if (strcmp(key, "HeaderSize") == 0)
        return header_numbers(value, 1, &file->skip);
    if (strcmp(key, "ElementByteOrderMSB") == 0 || strcmp(key, "BinaryDataByteOrderMSB") == 0)
        v->big_endian = is_true(value);
    if (strcmp(key, "BinaryData") == 0)
        file->text = !is_true(value);
    if (strcmp(key, "CompressedData") == 0)
        file->packed = is_true(value);
    if (strcmp(key, "ElementType") == 0)
        strcpy(file->type, strlen(value) < sizeof file->type ? value : "");
    if (strcmp(key, "ElementDataFile") == 0) {
        memcpy(file->data_file, value, sizeof file->data_file);
        file->ended = true;
    }
    return true;
}

static enum stp_result read_keys(struct metaimage *file, const struct file_bytes *bytes,
                                 size_t *data)
{
    const char *text = (const char *)bytes->data;
    struct header header = { text, text, text + bytes->size, '=' };
    struct header_line line;
    while (!file->ended && header_next(&header, &line))
        if (!take(file, &line))
            return log_error(file->env, STP_ERROR_FORMAT, "%s: %s = %s is not what a volume has",
                             file->path, line.key, line.value);
    *data = (size_t)(header.at - text);
    return STP_OK;
}

static enum stp_result check(struct metaimage *file)
{
    struct voxels *v = &file->voxels;
    bool big = v->big_endian;
    if (file->rank != 3 || file->channels != 1)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: %g dimensions of %g channels; a volume has three of one", file->path,
                         file->rank, file->channels);
    if (file->text)
        return log_error(
            file->env, STP_ERROR_FORMAT,
            "%s: BinaryData = False: voxels as text are not read; write them as binary",
            file->path);
    if (!file->ended || strncmp(file->data_file, "LIST", 4) == 0 || strchr(file->data_file, '%'))
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: ElementDataFile must be LOCAL or one file", file->path);
    if (!voxel_type_read(file->type, &v->type, &big))
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: ElementType \"%s\" is no scalar that is read", file->path,
                         file->type);
    for (int i = 0; i < 3; i++)
        v->dims[i] =
            file->dims[i] >= 1 && file->dims[i] <= 4294967295.0 ? (uint64_t)file->dims[i] : 0;
    return voxels_check(file->env, file->path, v);
}

static enum stp_result read_voxels(const struct metaimage *file, const struct file_bytes *bytes,
                                   size_t data, struct grid *grid)
{
    bool packed = file->packed && !bytes->inflated;
    const struct voxel_bytes from = { bytes, data, packed, packed ? 0 : file->skip };
    return grid_from_bytes(file->env, file->path, &from, &file->voxels, grid);
}

enum stp_result metaimage_read(const struct stp_env *env, const char *path,
                               const struct file_bytes *bytes, struct grid *grid)
{
    struct metaimage file = { .env = env,
                              .path = path,
                              .channels = 1,
                              .voxels = {
                                  .spacing = { 1, 1, 1 }, .up = STP_UP_Y, .format = "MetaImage" } };
    struct file_bytes detached = { 0 };
    size_t data = 0;
    enum stp_result result = read_keys(&file, bytes, &data);
    if (result == STP_OK)
        result = check(&file);
    if (result != STP_OK)
        return result;
    if (strcmp(file.data_file, "LOCAL") == 0 || strcmp(file.data_file, "Local") == 0)
        return read_voxels(&file, bytes, data, grid);
    size_t most = voxels_end(&file.voxels, 0, file.skip);
    result = header_data_file(env, path, file.data_file, most, &detached);
    if (result != STP_OK)
        return result;
    result = read_voxels(&file, &detached, 0, grid);
    file_release(&detached);
    return result;
}
