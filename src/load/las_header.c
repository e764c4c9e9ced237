#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "load/las.h"

#define HEADER_12 227
#define HEADER_14 375
#define VLR       54
#define EVLR      60

const struct las_format *las_format_of(unsigned format)
{
    static const struct las_format formats[] = {
        { 20, 0, 0, 0 },    { 28, 20, 0, 0 },  { 26, 0, 20, 0 },   { 34, 20, 28, 0 },
        { 57, 20, 0, 0 },   { 63, 20, 28, 0 }, { 30, 22, 0, 0 },   { 36, 22, 30, 0 },
        { 38, 22, 30, 36 }, { 59, 22, 0, 0 },  { 67, 22, 30, 36 },
    };
    return format < sizeof formats / sizeof *formats ? &formats[format] : NULL;
}

struct las_file {
    const struct stp_env *env;
    const char *path;
    const struct file_bytes *bytes;
};

static enum stp_result fault(const struct las_file *file, size_t byte, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static enum stp_result fault(const struct las_file *file, size_t byte, const char *format, ...)
{
    char what[256];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    return log_error(file->env, STP_ERROR_FORMAT, "%s: byte %zu: %s", file->path, byte, what);
}

static enum stp_result check_version(const struct las_file *file, struct las_header *header)
{
    const unsigned char *p = file->bytes->data;
    size_t size = file->bytes->size;
    if (size < HEADER_12)
        return fault(file, size, "the file ends within the LAS header, which has %d bytes",
                     HEADER_12);
    header->minor = p[25];
    if (p[24] != 1 || header->minor > 4)
        return fault(file, 24, "LAS %u.%u is not read; convert it to LAS 1.4", p[24], p[25]);
    unsigned claimed = little16(p + 94), least = header->minor >= 4 ? HEADER_14 : HEADER_12;
    if (claimed < least)
        return fault(file, 94, "a header of %u bytes is claimed; LAS 1.%u has at least %u", claimed,
                     header->minor, least);
    if (claimed > size)
        return fault(file, 94, "a header of %u bytes is claimed; the file has %zu", claimed, size);
    header->vlr_begin = claimed;
    return STP_OK;
}

static enum stp_result read_format(const struct las_file *file, struct las_header *header)
{
    const unsigned char *p = file->bytes->data;
    if (p[104] & 0xc0)
        return fault(file, 104,
                     "LAZ (compressed LAS) is not read: unpack it first, with `pdal translate "
                     "IN.laz OUT.las` (PDAL) or `laszip -i IN.laz -o OUT.las` (LAStools)");
    header->format = p[104];
    const struct las_format *format = las_format_of(header->format);
    if (!format)
        return fault(file, 104, "point format %u is not known: LAS has 0 to 10", header->format);
    header->record = little16(p + 105);
    header->size = format->size;
    if (header->record < header->size)
        return fault(file, 105, "points of %zu bytes are claimed; point format %u has %zu",
                     header->record, header->format, header->size);
    return STP_OK;
}

static enum stp_result read_scales(const struct las_file *file, struct las_header *header)
{
    for (unsigned i = 0; i < 3; i++) {
        size_t scale = 131 + 8 * i, offset = 155 + 8 * i;
        header->scale[i] = little_double(file->bytes->data + scale);
        header->offset[i] = little_double(file->bytes->data + offset);
        if (!isfinite(header->scale[i]) || header->scale[i] == 0)
            return fault(file, scale, "the scale of %c is %g", "xyz"[i], header -> scale[i]);
        if (!isfinite(header->offset[i]))
            return fault(file, offset, "the offset of %c is %g", "xyz"[i], header -> offset[i]);
    }
    return STP_OK;
}

/* 1.4 has a count of 64 bits, and the old one of 32 beside it where it is large enough. */
static void read_count(const struct las_file *file, struct las_header *header)
{
    const unsigned char *p = file->bytes->data;
    uint64_t legacy = little32(p + 107), wide = header->minor >= 4 ? little64(p + 247) : 0;
    header->count = wide ? wide : legacy;
    if (wide && legacy && wide != legacy)
        log_warning(file->env, "%s: byte 107: %llu points, but %llu at byte 247: the latter holds",
                    file->path, (unsigned long long)legacy, (unsigned long long)wide);
}

static enum stp_result check_points(const struct las_file *file, const struct las_header *header)
{
    size_t size = file->bytes->size;
    if (header->count == 0)
        return STP_OK;
    if (header->points < header->vlr_begin)
        return fault(file, 96, "points at byte %zu are claimed, within the header of %zu bytes",
                     header->points, header->vlr_begin);
    if (header->points > size)
        return fault(file, 96, "points at byte %zu are claimed; the file has %zu bytes",
                     header->points, size);
    size_t fit = (size - header->points) / header->record;
    if (header->count <= fit)
        return STP_OK;
    return fault(file, header->points,
                 "%llu points of %zu bytes are claimed, but the file ends in point %zu, at byte "
                 "%zu: it is cut short or damaged",
                 (unsigned long long)header->count, header->record, fit, size);
}

enum stp_result las_header_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, struct las_header *header)
{
    struct las_file file = { env, path, bytes };
    struct las_header read = { 0 };
    enum stp_result result = check_version(&file, &read);
    if (result == STP_OK)
        result = read_format(&file, &read);
    if (result == STP_OK)
        result = read_scales(&file, &read);
    if (result != STP_OK)
        return result;
    read.points = little32(bytes->data + 96);
    read.vlrs = little32(bytes->data + 100);
    if (read.minor >= 4) {
        read.evlr_begin = little64(bytes->data + 235);
        read.evlrs = little32(bytes->data + 243);
    }
    read_count(&file, &read);
    result = check_points(&file, &read);
    if (result == STP_OK)
        *header = read;
    return result;
}

/* A chain of records: 54 bytes and a length of 16 bits, or 60 bytes and one of 64. Each is at
 * least as long as its header, so that the file's length bounds the walk. */
static struct las_extras find_in_chain(const struct las_file *file, uint64_t at, uint32_t count,
                                       size_t header)
{
    const unsigned char *data = file->bytes->data;
    uint64_t size = file->bytes->size;
    for (uint32_t i = 0; i < count; i++) {
        const unsigned char *p = data + (at <= size ? at : size);
        uint64_t left = at <= size ? size - at : 0, length = 0;
        if (left >= header)
            length = header == VLR ? little16(p + 20) : little64(p + 20);
        if (left < header || length > left - header) {
            log_warning(file->env,
                        "%s: byte %llu: variable length record %u of %u leaves the file: the "
                        "records from here on are left out",
                        file->path, (unsigned long long)at, i, count);
            break;
        }
        if (memcmp(p + 2, "LASF_Spec", 10) == 0 && little16(p + 18) == 4)
            return (struct las_extras){ p + header, (size_t)(length / 192) };
        at += header + length;
    }
    return (struct las_extras){ 0 };
}

struct las_extras las_extras_find(const struct stp_env *env, const char *path,
                                  const struct file_bytes *bytes, const struct las_header *header)
{
    struct las_file file = { env, path, bytes };
    struct las_extras extras = { 0 };
    if (header->record == header->size)
        return extras;
    extras = find_in_chain(&file, header->vlr_begin, header->vlrs, VLR);
    if (!extras.count && header->evlrs)
        extras = find_in_chain(&file, header->evlr_begin, header->evlrs, EVLR);
    return extras;
}

/* Of data types 1 to 10; 11 to 20 are pairs and 21 to 30 triples of them, which 1.4 did away with.
 */
static enum record_type extra_type(unsigned type)
{
    static const unsigned char types[] = {
        RECORD_UINT8, RECORD_INT8,   RECORD_UINT16, RECORD_INT16,   RECORD_UINT32,
        RECORD_INT32, RECORD_UINT64, RECORD_INT64,  RECORD_FLOAT32, RECORD_FLOAT64,
    };
    return type == 0 || type > 30 ? RECORD_NONE : (enum record_type)types[(type - 1) % 10];
}

/* The value that means none is stored as the widest of its kind. */
static double missing_value(const unsigned char *p, enum record_type type)
{
    if (type >= RECORD_FLOAT32)
        return little_double(p);
    bool is_signed = type % 2 == RECORD_INT8 % 2;
    return is_signed ? (double)(int64_t)little64(p) : (double)little64(p);
}

bool las_extra_read(const struct las_extras *extras, size_t index, size_t *at,
                    struct las_extra *extra)
{
    const unsigned char *p = extras->records + 192 * index;
    const char *name = (const char *)p + 4;
    unsigned type = p[2], options = p[3];
    struct record_column column = { .type = extra_type(type) };
    size_t size = record_type_size(column.type) * (type ? (type - 1) / 10 + 1 : 0);
    *extra = (struct las_extra){ .name = { name, strnlen(name, 32) }, .at = *at };
    extra->bytes = type == 0 ? options : size;
    if (type > 30)
        extra->bytes = SIZE_MAX - *at; /* of unknown length: nothing after it can be found */
    *at += extra->bytes;
    if (type == 0 || type > 10 || extra->name.length == 0)
        return false;
    column.has_missing = options & 1;
    column.missing = missing_value(p + 40, column.type);
    double scale = options & 8 ? little_double(p + 112) : 1;
    if (options & 24 && scale != 0) {
        column.scale = scale;
        column.offset = options & 16 ? little_double(p + 136) : 0;
    }
    extra->column = column;
    return true;
}
