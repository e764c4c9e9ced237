/* The probe table of volumes, and what their readers share. */
#include "load/volume.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/text.h"

static const struct volume_reader readers[] = {
    { nifti_probe, nifti_stated, nifti_read },
    { nrrd_probe, nrrd_stated, nrrd_read },
    { metaimage_probe, NULL, metaimage_read },
    { inrimage_probe, NULL, inrimage_read },
};

const struct volume_reader *volume_reader_find(const struct file_bytes *bytes)
{
    for (size_t i = 0; i < sizeof readers / sizeof *readers; i++)
        if (readers[i].probe(bytes))
            return &readers[i];
    return NULL;
}

size_t volume_stated(const struct file_bytes *head)
{
    const struct volume_reader *reader = volume_reader_find(head);
    return reader && reader->stated ? reader->stated(head) : FILE_ALL;
}

static enum stp_result read_raw(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, const struct raw_volume *raw,
                                struct grid *grid)
{
    const struct voxels *v = &raw->voxels;
    enum stp_result result = voxels_check(env, path, v);
    if (result != STP_OK)
        return result;
    size_t wanted = (size_t)(v->dims[0] * v->dims[1] * v->dims[2]) * record_type_size(v->type);
    if (bytes->size != wanted)
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: %llu x %llu x %llu voxels of %zu bytes are %zu bytes; the file has "
                         "%zu: give its dims and type (--volume-dims, --volume-type)",
                         path, (unsigned long long)v->dims[0], (unsigned long long)v->dims[1],
                         (unsigned long long)v->dims[2], record_type_size(v->type), wanted,
                         bytes->size);
    return grid_from_voxels(env, path, bytes, 0, v, grid);
}

enum stp_result volume_from_bytes(const struct stp_env *env, const char *path,
                                  const struct file_bytes *bytes, const struct raw_volume *raw,
                                  const struct stp_volume_params *params, struct grid *grid)
{
    const struct volume_reader *reader = volume_reader_find(bytes);
    struct grid read = { 0 };
    if (!reader && !(raw && raw->known))
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: byte 0: not a volume that is read (NIfTI, NRRD, MetaImage, "
                         "INRIMAGE); describe a raw file with --volume-dims, --volume-type and "
                         "--volume-spacing, or with a .json beside it",
                         path);
    enum stp_result result =
        reader ? reader->read(env, path, bytes, &read) : read_raw(env, path, bytes, raw, &read);
    if (result != STP_OK)
        return result;
    if (reader && params && params->spacing[0] > 0)
        memcpy(read.spacing, params->spacing, sizeof read.spacing);
    if (bytes->inflated)
        strncat(read.format, ", gzip", sizeof read.format - strlen(read.format) - 1);
    *grid = read;
    return STP_OK;
}

static void trim(const char *from, const char *to, char *out, size_t size)
{
    while (from < to && (unsigned char)*from <= ' ')
        from++;
    while (to > from && (unsigned char)to[-1] <= ' ')
        to--;
    size_t length = (size_t)(to - from) < size - 1 ? (size_t)(to - from) : size - 1;
    memcpy(out, from, length);
    out[length] = 0;
}

bool header_next(struct header *header, struct header_line *line)
{
    while (header->at < header->end) {
        const char *start = header->at;
        const char *stop = memchr(start, '\n', (size_t)(header->end - start));
        stop = stop ? stop : header->end;
        header->at = stop < header->end ? stop + 1 : stop;
        const char *cut = memchr(start, header->separator, (size_t)(stop - start));
        if (!cut || *start == '#')
            continue;
        trim(start, cut, line->key, sizeof line->key);
        trim(cut + 1, stop, line->value, sizeof line->value);
        return true;
    }
    return false;
}

static bool is_between(char c)
{
    return (unsigned char)c <= ' ' || c == ',' || c == '(' || c == ')';
}

bool header_numbers(const char *text, unsigned count, double *values)
{
    const char *at = text, *end = text + strlen(text);
    for (unsigned i = 0; i <= count; i++) {
        while (at < end && is_between(*at))
            at++;
        if (i == count)
            return at == end;
        if (!number_read(&at, end, &values[i]))
            return false;
    }
    return false;
}

enum stp_result header_data_file(const struct stp_env *env, const char *path, const char *name,
                                 size_t most, struct file_bytes *bytes)
{
    const struct file_use use = { .most = most };
    const char *slash = strrchr(path, '/');
    size_t folder = name[0] == '/' || !slash ? 0 : (size_t)(slash + 1 - path);
    char *joined = mem_alloc(folder + strlen(name) + 1, 1);
    if (!joined)
        return log_no_memory(env, folder + strlen(name) + 1, path);
    memcpy(joined, path, folder);
    strcpy(joined + folder, name);
    enum stp_result result = file_read_for(env, joined, &use, bytes);
    mem_free(joined);
    return result;
}
