/* NRRD: "field: value" up to a blank line, then the voxels, or a "data file" that holds them.
 * Encodings raw and gzip. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/log.h"
#include "load/volume.h"

struct nrrd {
    const struct stp_env *env;
    const char *path;
    double rank, sizes[3];
    bool packed, has_spacings, has_bounds, unread;
    bool left_handed; /* the space that directions and origin are in */
    char type[64], encoding[32], data_file[256];
    double skip; /* bytes; -1: the voxels are the last of the file */
    struct voxels voxels;
};

bool nrrd_probe(const struct file_bytes *bytes)
{
    return bytes->size >= 8 && memcmp(bytes->data, "NRRD000", 7) == 0;
}

static bool matches(const char *key, const char *name)
{
    return strcmp(key, name) == 0;
}

/* "(a,b,c) (d,e,f) (g,h,i)": each is an axis's step in the world. */
static bool take_directions(struct voxels *v, const char *text)
{
    double m[9];
    if (!header_numbers(text, 9, m))
        return false;
    for (int axis = 0; axis < 3; axis++) {
        double length = sqrt(m[3 * axis] * m[3 * axis] + m[3 * axis + 1] * m[3 * axis + 1] +
                             m[3 * axis + 2] * m[3 * axis + 2]);
        v->spacing[axis] = length;
        for (int w = 0; w < 3; w++)
            v->direction[axis][w] = length > 0 ? m[3 * axis + w] / length : 0;
    }
    return true;
}

/* LPS and RAS are right-handed, as the world is. */
static bool is_left_handed(const char *space)
{
    return strncasecmp(space, "left-anterior-superior", 22) == 0 ||
           strncasecmp(space, "LAS", 3) == 0 || strncasecmp(space, "3D-left-handed", 14) == 0;
}

/* Axes and origin into the world, by its first axis. */
static void mirror(struct voxels *v)
{
    bool given = false;
    for (int axis = 0; axis < 3; axis++)
        for (int w = 0; w < 3; w++)
            given = given || v->direction[axis][w] != 0;
    for (int axis = 0; axis < 3; axis++) {
        if (!given)
            v->direction[axis][axis] = 1;
        v->direction[axis][0] = -v->direction[axis][0];
    }
    v->origin[0] = -v->origin[0];
}

static bool take(struct nrrd *file, const struct header_line *line)
{
    struct voxels *v = &file->voxels;
    const char *value = line->value;
    if (matches(line->key, "dimension"))
        return header_numbers(value, 1, &file->rank);
    if (matches(line->key, "sizes"))
        return file->rank != 3 || header_numbers(value, 3, file->sizes);
    if (matches(line->key, "spacings"))
        return file->has_spacings = header_numbers(value, 3, v->spacing);
    if (matches(line->key, "axis mins") || matches(line->key, "axis maxs"))
        file->has_bounds = true;
    if (matches(line->key, "space directions"))
        return file->has_spacings = take_directions(v, value);
    if (matches(line->key, "space origin"))
        return v->has_origin = header_numbers(value, 3, v->origin);
    if (matches(line->key, "space")) {
        v->up = STP_UP_Z; /* anatomical spaces name their axes; the third is superior */
        file->left_handed = is_left_handed(value);
    }
    if (matches(line->key, "type"))
        strcpy(file->type, strlen(value) < sizeof file->type ? value : "");
    if (matches(line->key, "endian"))
        v->big_endian = matches(value, "big");
    if (matches(line->key, "encoding"))
        strcpy(file->encoding, strlen(value) < sizeof file->encoding ? value : "?");
    if (matches(line->key, "data file") || matches(line->key, "datafile"))
        memcpy(file->data_file, value, sizeof file->data_file);
    if (matches(line->key, "byte skip"))
        return header_numbers(value, 1, &file->skip);
    if (matches(line->key, "line skip"))
        file->unread = !matches(value, "0");
    return true;
}

/* Fields up to the blank line; *data gets where the voxels begin. */
static enum stp_result read_fields(struct nrrd *file, const struct file_bytes *bytes, size_t *data)
{
    const char *text = (const char *)bytes->data, *end = text + bytes->size;
    struct header_line line;
    const char *at = text;
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        const char *next = stop ? stop + 1 : end;
        if (!stop || stop == at || (stop == at + 1 && *at == '\r')) {
            *data = (size_t)(next - text);
            return STP_OK;
        }
        struct header one = { at, at, next, ':' };
        if (header_next(&one, &line) && !take(file, &line))
            return log_error(file->env, STP_ERROR_FORMAT,
                             "%s: byte %zu: %s: %s is not what a volume has", file->path,
                             (size_t)(at - text), line.key, line.value);
        at = next;
    }
    *data = bytes->size;
    return STP_OK;
}

static enum stp_result check(struct nrrd *file)
{
    struct voxels *v = &file->voxels;
    file->packed = strcasecmp(file->encoding, "gzip") == 0 || strcasecmp(file->encoding, "gz") == 0;
    if (file->rank != 3)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: %g dimensions; a volume of scalars has three", file->path,
                         file->rank);
    if (!file->packed && strcasecmp(file->encoding, "raw") != 0)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: encoding %s is not read; write it as raw or gzip", file->path,
                         file->encoding);
    if (file->packed && file->skip < 0)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte skip: -1 goes with encoding raw only, not with gzip",
                         file->path);
    if (file->unread || strchr(file->data_file, '%') || strncmp(file->data_file, "LIST", 4) == 0)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: skipped lines and voxels in several files are not read; write one "
                         "NRRD",
                         file->path);
    bool big = v->big_endian;
    if (!voxel_type_read(file->type, &v->type, &big))
        return log_error(file->env, STP_ERROR_FORMAT, "%s: type \"%s\" is no scalar that is read",
                         file->path, file->type);
    if (file->has_bounds && !file->has_spacings)
        log_warning(file->env,
                    "%s: axis mins and maxs are not read, spacings are 1; --volume-spacing says "
                    "otherwise",
                    file->path);
    if (file->left_handed)
        mirror(v);
    for (int i = 0; i < 3; i++)
        v->dims[i] =
            file->sizes[i] >= 1 && file->sizes[i] <= 4294967295.0 ? (uint64_t)file->sizes[i] : 0;
    return voxels_check(file->env, file->path, v);
}

static enum stp_result read_voxels(const struct nrrd *file, const struct file_bytes *bytes,
                                   size_t data, struct grid *grid)
{
    const struct voxel_bytes from = { bytes, data, file->packed, file->skip };
    return grid_from_bytes(file->env, file->path, &from, &file->voxels, grid);
}

static struct nrrd begun(const struct stp_env *env, const char *path)
{
    return (struct nrrd){ .env = env,
                          .path = path,
                          .encoding = "raw",
                          .voxels = { .spacing = { 1, 1, 1 }, .up = STP_UP_Y, .format = "NRRD" } };
}

/* A header that goes on beyond the head is left to the reader; of what the reader will refuse by
 * its header, nothing more. */
size_t nrrd_stated(const struct file_bytes *head)
{
    const struct stp_env quiet = { .log = log_nothing };
    struct nrrd file = begun(&quiet, "");
    size_t data = 0;
    if (read_fields(&file, head, &data) != STP_OK)
        return 0;
    if (data == head->size)
        return FILE_ALL;
    if (check(&file) != STP_OK || file.data_file[0])
        return data;
    return file.packed ? FILE_ALL : voxels_end(&file.voxels, data, file.skip);
}

enum stp_result nrrd_read(const struct stp_env *env, const char *path,
                          const struct file_bytes *bytes, struct grid *grid)
{
    struct nrrd file = begun(env, path);
    struct file_bytes detached = { 0 };
    size_t data = 0;
    enum stp_result result = read_fields(&file, bytes, &data);
    if (result == STP_OK)
        result = check(&file);
    if (result != STP_OK)
        return result;
    if (!file.data_file[0])
        return read_voxels(&file, bytes, data, grid);
    size_t most = voxels_end(&file.voxels, 0, file.skip);
    result = header_data_file(env, path, file.data_file, most, &detached);
    if (result != STP_OK)
        return result;
    if (detached.inflated)
        file.packed = false;
    result = read_voxels(&file, &detached, 0, grid);
    file_release(&detached);
    return result;
}
