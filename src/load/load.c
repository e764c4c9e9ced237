#include "load/load.h"

#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "load/readers.h"

struct reader {
    bool (*probe)(const struct file_bytes *bytes);
    reader_fn read;
};

/* Asked in this order; plain text comes last, because it has no signature. */
static const struct reader readers[] = {
    { ply_probe, ply_read }, { las_probe, las_read }, { pcd_probe, pcd_read },
    { off_probe, off_read }, { obj_probe, obj_read }, { xyz_probe, xyz_read },
};

static enum stp_result refuse(const struct stp_env *env, const char *path,
                              const struct file_bytes *bytes)
{
    struct known_format known;
    if (bytes->size == 0)
        return log_error(env, STP_ERROR_FORMAT, "%s: the file is empty", path);
    if (known_format_find(bytes, &known))
        return log_error(env, STP_ERROR_FORMAT, "%s: %s is not read: %s", path, known.name,
                         known.advice);
    return log_error(
        env, STP_ERROR_FORMAT,
        "%s: byte 0: not a point file that is read (PLY, LAS, PCD, text, OFF, OBJ), nor a volume "
        "(NIfTI, NRRD, MetaImage, INRIMAGE), nor gzip of any: convert it to one of these; of a raw "
        "volume, give --volume-dims and --volume-type",
        path);
}

/* Editors and spreadsheets begin texts with the mark of UTF-8, which is no part of them. */
static struct file_bytes past_mark(const struct file_bytes *bytes)
{
    struct file_bytes past = *bytes;
    if (bytes->size >= 3 && memcmp(bytes->data, "\xef\xbb\xbf", 3) == 0) {
        past.data += 3;
        past.size -= 3;
    }
    return past;
}

static const struct reader *find_reader(const struct file_bytes *bytes)
{
    struct known_format known;
    for (size_t i = 0; i < sizeof readers / sizeof *readers; i++)
        if (readers[i].probe(bytes) &&
            (readers[i].probe != xyz_probe || !known_format_find(bytes, &known)))
            return &readers[i];
    return NULL;
}

bool load_recognises(const struct file_bytes *bytes)
{
    const struct file_bytes past = past_mark(bytes);
    return find_reader(&past) != NULL;
}

enum stp_result load_from_bytes(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, const struct load_options *options,
                                struct cloud *cloud)
{
    static const struct load_options defaults;
    const struct file_bytes past = past_mark(bytes);
    const struct reader *reader = find_reader(&past);
    struct cloud read = { 0 };
    if (!reader)
        return refuse(env, path, &past);
    enum stp_result result = reader->read(env, path, &past, options ? options : &defaults, &read);
    if (result != STP_OK)
        return result;
    if (bytes->inflated)
        strncat(read.format, ", gzip", sizeof read.format - strlen(read.format) - 1);
    *cloud = read;
    return STP_OK;
}
