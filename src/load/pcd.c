/* PCD of the Point Cloud Library: ascii, binary and binary_compressed. */
#include "load/pcd.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/lzf.h"

/* A file may lack the comment that usually opens it, and even the version. */
bool pcd_probe(const struct file_bytes *bytes)
{
    const struct text_style style = { .eol = '\n', .comments = true };
    const char *begin = (const char *)bytes->data;
    const char *end = begin + (bytes->size < 4096 ? bytes->size : 4096);
    if (bytes->size >= 6 && (memcmp(begin, "# .PCD", 6) == 0 || memcmp(begin, ".PCD", 4) == 0))
        return true;
    const char *at = text_next_row(&style, begin, end);
    struct slice key = text_token(&style, &at, end), next = text_token(&style, &at, end);
    if (slice_is(key, "VERSION"))
        return slice_is(next, ".7") || slice_is(next, "0.7") || slice_is(next, ".6") ||
               slice_is(next, "0.6") || slice_is(next, ".5") || slice_is(next, "0.5");
    return (slice_is(key, "FIELDS") || slice_is(key, "COLUMNS")) && next.length;
}

struct pcd_file {
    const struct stp_env *env;
    const char *path;
    const struct file_bytes *bytes;
    struct pcd_header header;
    struct column *names; /* with `columns` beside them */
    struct record_column *columns;
    unsigned count;
    unsigned first[PCD_MAX_FIELDS]; /* each field's first column */
    unsigned char *unpacked;        /* of binary_compressed */
    double *packed;                 /* of ascii: the numbers of the packed field */
};

static enum scale scale_of(enum pcd_encoding encoding, enum record_type type)
{
    if (type >= RECORD_FLOAT32)
        return SCALE_FLOAT;
    if (type == RECORD_INT8 || type == RECORD_UINT8)
        return encoding == PCD_ASCII ? SCALE_UINT8 : SCALE_BYTE;
    return SCALE_INTEGER;
}

static void add_column(struct pcd_file *file, struct slice name, enum scale scale,
                       struct record_column column)
{
    file->names[file->count] = (struct column){ .name = name, .scale = scale };
    file->columns[file->count++] = column;
}

/* 0xAARRGGBB, whatever type the field is said to have. */
static void add_packed(struct pcd_file *file, const struct pcd_field *field)
{
    static const char *const names[] = { "blue", "green", "red", "alpha" };
    unsigned parts = slice_is(field->name, "rgba") ? 4 : 3;
    for (unsigned i = 0; i < parts; i++)
        add_column(file, (struct slice){ names[i], strlen(names[i]) }, SCALE_BYTE,
                   (struct record_column){ .type = RECORD_UINT32, .shift = 8 * i, .bits = 8 });
}

static void add_columns(struct pcd_file *file)
{
    for (unsigned i = 0; i < file->header.fields; i++) {
        const struct pcd_field *field = &file->header.field[i];
        file->first[i] = file->count;
        if (field->packed)
            add_packed(file, field);
        else if (!field->is_padding)
            add_column(file, field->name, scale_of(file->header.encoding, field->type),
                       (struct record_column){ .type = field->type });
    }
}

/* The columns of field `index` start at `first` and are `stride` bytes apart. */
static void place_field(struct pcd_file *file, unsigned index, const unsigned char *first,
                        size_t stride)
{
    unsigned end = index + 1 < file->header.fields ? file->first[index + 1] : file->count;
    for (unsigned i = file->first[index]; i < end; i++) {
        file->columns[i].first = first;
        file->columns[i].stride = stride;
    }
}

static enum stp_result read_binary(struct pcd_file *file, const struct table *table)
{
    const unsigned char *at = file->bytes->data + file->header.body;
    for (unsigned i = 0; i < file->header.fields; i++) {
        const struct pcd_field *field = &file->header.field[i];
        place_field(file, i, at, file->header.record);
        at += field->size * field->count;
    }
    records_read(file->env, file->columns, table, file->header.count);
    return STP_OK;
}

/* All values of the first field, then all of the next. */
static void read_fields(struct pcd_file *file, const struct table *table, bool has_padding)
{
    const unsigned char *at = file->unpacked;
    for (unsigned i = 0; i < file->header.fields; i++) {
        const struct pcd_field *field = &file->header.field[i];
        size_t stride = field->size * field->count;
        place_field(file, i, at, stride);
        if (!field->is_padding || has_padding)
            at += stride * file->header.count;
    }
    records_read(file->env, file->columns, table, file->header.count);
}

static enum stp_result read_compressed(struct pcd_file *file, const struct table *table)
{
    const struct pcd_header *header = &file->header;
    const unsigned char *data = file->bytes->data + header->body;
    size_t packed = little32(data), size = little32(data + 4), at = 0;
    file->unpacked = mem_alloc(size, 1);
    if (!file->unpacked)
        return log_no_memory(file->env, size, file->path);
    if (!lzf_unpack(data + 8, packed, file->unpacked, size, &at))
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte %zu: damaged compressed data: it does not unpack to %zu bytes",
                         file->path, header->body + 8 + at, size);
    read_fields(file, table, size == header->record * header->count);
    return STP_OK;
}

/* A packed number of a text: the bits of a float, or, as PCL writes it since 1.8, the integer that
 * they are. No colour of alpha 0 or 255 is a float of 1 or more, so the two cannot be mistaken. */
static uint32_t packed_bits(double number)
{
    float value = (float)number;
    uint32_t bits;
    if (isnan(number))
        return 0; /* the bits that it had are lost */
    if (number >= 1 && number <= UINT32_MAX)
        return (uint32_t)number;
    if (number <= -1 && number >= INT32_MIN)
        return (uint32_t)(int32_t)number;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* The numbers of the packed field become integers in place, and those the columns of a record. */
static void read_packed(struct pcd_file *file, const struct table *table)
{
    unsigned char *bits = (unsigned char *)file->packed;
    for (size_t i = 0; i < file->header.count; i++) {
        uint32_t value = packed_bits(file->packed[i]);
        memcpy(bits + i * sizeof value, &value, sizeof value);
    }
    for (unsigned i = 0; i < file->header.fields; i++)
        if (file->header.field[i].packed)
            place_field(file, i, bits, sizeof(uint32_t));
    for (unsigned i = 0; i < file->count; i++)
        if (!file->columns[i].first)
            file->columns[i].type = RECORD_NONE; /* read already */
    records_read(file->env, file->columns, table, file->header.count);
}

/* A column for every number of a line, with the slots of the field that it is the first of. */
static bool make_tokens(struct pcd_file *file, struct table *tokens)
{
    tokens->column = mem_zalloc(file->header.numbers, sizeof *tokens->column);
    if (!tokens->column)
        return false;
    for (unsigned i = 0; i < file->header.fields; i++) {
        const struct pcd_field *field = &file->header.field[i];
        struct column *token = &tokens->column[tokens->count];
        tokens->count += field->count;
        if (field->packed) {
            file->packed = mem_alloc(file->header.count, sizeof *file->packed);
            token->slot[0] = (struct slot){ (char *)file->packed, sizeof *file->packed, true };
            if (!file->packed)
                return false;
        } else if (!field->is_padding) {
            memcpy(token->slot, file->names[file->first[i]].slot, sizeof token->slot);
        }
    }
    return true;
}

static enum stp_result read_ascii(struct pcd_file *file, const struct table *table)
{
    const char *begin = (const char *)file->bytes->data;
    struct row_source source = { .begin = begin,
                                 .body = begin + file->header.body,
                                 .end = begin + file->bytes->size,
                                 .style = { .eol = '\n', .comments = true },
                                 .element = "point" };
    struct table tokens = { 0 };
    enum stp_result result = STP_OK;
    if (!make_tokens(file, &tokens))
        result = log_no_memory(file->env, file->header.count * sizeof *file->packed, file->path);
    if (result == STP_OK)
        result = table_read_rows(file->env, file->path, &source, &tokens, file->header.count);
    if (result == STP_OK && file->packed)
        read_packed(file, table);
    mem_free(tokens.column);
    return result;
}

static enum stp_result too_short(const struct pcd_file *file, size_t size, size_t fit)
{
    return log_error(file->env, STP_ERROR_FORMAT,
                     "%s: byte %zu: %llu points of at least %zu bytes are claimed, but the file "
                     "ends in point %zu, at byte %zu: it is cut short or damaged",
                     file->path, file->header.body, (unsigned long long)file->header.count, size,
                     fit, file->bytes->size);
}

static enum stp_result check_compressed(const struct pcd_file *file)
{
    const struct pcd_header *header = &file->header;
    size_t left = file->bytes->size - header->body;
    if (left < 8)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte %zu: the file ends before the sizes of the compressed data",
                         file->path, header->body);
    const unsigned char *data = file->bytes->data + header->body;
    size_t packed = little32(data), size = little32(data + 4);
    if (packed > left - 8)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte %zu: %zu bytes of compressed data are claimed; %zu are left",
                         file->path, header->body, packed, left - 8);
    if (header->count > UINT32_MAX ||
        (size != header->record * header->count && size != header->dense * header->count))
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte %zu: %zu bytes when unpacked are claimed, which is not what "
                         "%llu points of %zu bytes take",
                         file->path, header->body + 4, size, (unsigned long long)header->count,
                         header->dense);
    if (size > (packed / 3 + 1) * LZF_MOST_OF_THREE)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte %zu: %zu bytes cannot unpack to %zu", file->path, header->body,
                         packed, size);
    return STP_OK;
}

/* Before anything is allocated: can the points fit into the rest of the file? */
static enum stp_result check_size(const struct pcd_file *file)
{
    const struct pcd_header *header = &file->header;
    size_t left = file->bytes->size - header->body, size = header->record;
    if (header->encoding == PCD_COMPRESSED)
        return check_compressed(file);
    if (header->encoding == PCD_ASCII) {
        size = 2 * (size_t)header->numbers; /* a digit and a separator, which the last may lack */
        left++;
    }
    return header->count <= left / size ? STP_OK : too_short(file, size, left / size);
}

static enum stp_result read_body(struct pcd_file *file, const struct table *table)
{
    static enum stp_result (*const readers[])(
        struct pcd_file *, const struct table *) = { read_ascii, read_binary, read_compressed };
    return readers[file->header.encoding](file, table);
}

/* The picture of a depth camera: organised, and all of it before the lens. Its y points down. */
static bool is_depth_picture(const struct pcd_header *header, const struct cloud *cloud)
{
    size_t finite = 0;
    for (size_t i = 0; i < cloud->count; i++) {
        double z = cloud->position[i][2];
        if (z <= 0)
            return false;
        finite += isfinite(z) != 0;
    }
    return header->height > 1 && finite;
}

static enum stp_result read_points(struct pcd_file *file, const struct load_options *options,
                                   struct cloud *cloud)
{
    struct table table = { .column = file->names, .count = file->count };
    table_name_roles(&table);
    if (!table_has(&table, ROLE_X) || !table_has(&table, ROLE_Y))
        return log_error(file->env, STP_ERROR_FORMAT, "%s: byte %zu: the PCD has no field %s",
                         file->path, file->header.body, table_has(&table, ROLE_X) ? "y" : "x");
    if (!table_has(&table, ROLE_Z))
        log_warning(file->env, "%s: the PCD has no field z: taken as 0", file->path);
    enum stp_result result = table_plan(file->env, file->path, options, &table);
    if (result == STP_OK)
        result = check_size(file);
    if (result == STP_OK)
        result = table_allocate(file->env, file->path, file->header.count, &table, cloud);
    if (result == STP_OK)
        result = read_body(file, &table);
    if (result == STP_OK)
        result = table_finish(file->env, file->path, options, &table, cloud);
    if (result == STP_OK)
        cloud->up = is_depth_picture(&file->header, cloud) ? STP_UP_NEG_Y : STP_UP_Y;
    return result;
}

static enum stp_result read_columns(struct pcd_file *file, const struct load_options *options,
                                    struct cloud *cloud)
{
    size_t room = file->header.fields + 3; /* a packed field is up to four columns */
    file->names = mem_alloc(room, sizeof *file->names);
    file->columns = mem_alloc(room, sizeof *file->columns);
    enum stp_result result;
    if (file->names && file->columns) {
        add_columns(file);
        result = read_points(file, options, cloud);
    } else {
        result = log_no_memory(file->env, room * sizeof *file->columns, file->path);
    }
    mem_free(file->names);
    mem_free(file->columns);
    mem_free(file->unpacked);
    mem_free(file->packed);
    return result;
}

enum stp_result pcd_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud)
{
    static const char *const names[] = { "PCD ascii", "PCD binary", "PCD binary_compressed" };
    struct pcd_file file = { .env = env, .path = path, .bytes = bytes };
    struct cloud read = { .up = STP_UP_Y };
    enum stp_result result = pcd_header_read(env, path, bytes, &file.header);
    if (result == STP_OK && file.header.count)
        result = read_columns(&file, options, &read);
    if (result != STP_OK) {
        cloud_release(&read);
        return result;
    }
    snprintf(read.format, sizeof read.format, "%s", names[file.header.encoding]);
    *cloud = read;
    return STP_OK;
}
