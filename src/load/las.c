/* LAS 1.0 to 1.4, point formats 0 to 10 (ASPRS). z is up. Waveforms are stepped over. */
#include "load/las.h"

#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

bool las_probe(const struct file_bytes *bytes)
{
    return bytes->size >= 4 && memcmp(bytes->data, "LASF", 4) == 0;
}

struct las_file {
    const struct stp_env *env;
    const char *path;
    const struct file_bytes *bytes;
    struct las_header header;
    const unsigned char *records;
    struct column *names; /* with `columns` beside them */
    struct record_column *columns;
    unsigned count;
};

static void add_column(struct las_file *file, struct slice name, enum scale scale,
                       const struct record_column *column)
{
    file->names[file->count] = (struct column){ .name = name, .scale = scale };
    file->columns[file->count++] = *column;
}

/* A number at a fixed offset of every point. */
static struct record_column *add(struct las_file *file, const char *name, size_t at,
                                 enum record_type type)
{
    const struct record_column column = { .first = file->records + at,
                                          .stride = file->header.record,
                                          .type = type };
    add_column(file, (struct slice){ name, strlen(name) }, SCALE_INTEGER, &column);
    return &file->columns[file->count - 1];
}

static void add_part(struct las_file *file, const char *name, size_t at, unsigned shift,
                     unsigned bits)
{
    struct record_column *column = add(file, name, at, RECORD_UINT8);
    column->shift = shift;
    column->bits = bits;
}

static void add_place(struct las_file *file)
{
    static const char *const names[] = { "x", "y", "z" };
    for (unsigned i = 0; i < 3; i++) {
        struct record_column *column = add(file, names[i], 4 * i, RECORD_INT32);
        column->scale = file->header.scale[i];
        column->offset = file->header.offset[i];
    }
    add(file, "intensity", 12, RECORD_UINT16);
}

/* Formats 0 to 5. */
static void add_old_flags(struct las_file *file)
{
    add_part(file, "return_number", 14, 0, 3);
    add_part(file, "number_of_returns", 14, 3, 3);
    add_part(file, "scan_direction", 14, 6, 1);
    add_part(file, "edge_of_flight_line", 14, 7, 1);
    add_part(file, "classification", 15, 0, 5);
    add_part(file, "synthetic", 15, 5, 1);
    add_part(file, "key_point", 15, 6, 1);
    add(file, "scan_angle", 16, RECORD_INT8);
    add(file, "user_data", 17, RECORD_UINT8);
    add(file, "point_source_id", 18, RECORD_UINT16);
}

/* Formats 6 to 10. */
static void add_new_flags(struct las_file *file)
{
    add_part(file, "return_number", 14, 0, 4);
    add_part(file, "number_of_returns", 14, 4, 4);
    add_part(file, "synthetic", 15, 0, 1);
    add_part(file, "key_point", 15, 1, 1);
    add_part(file, "overlap", 15, 3, 1);
    add_part(file, "scanner_channel", 15, 4, 2);
    add_part(file, "scan_direction", 15, 6, 1);
    add_part(file, "edge_of_flight_line", 15, 7, 1);
    add(file, "classification", 16, RECORD_UINT8);
    add(file, "user_data", 17, RECORD_UINT8);
    add(file, "scan_angle", 18, RECORD_INT16)->scale = 0.006;
    add(file, "point_source_id", 20, RECORD_UINT16);
}

/* Seconds since an epoch: as floats, differences between neighbours would be lost. */
static void add_time(struct las_file *file, size_t at)
{
    struct record_column *column = add(file, "gps_time", at, RECORD_FLOAT64);
    double first = record_value(column, 0);
    if (first - first == 0) { /* finite */
        column->scale = 1;
        column->offset = -first;
    }
}

/* Writers that have no colours take a format with them all the same, and leave them 0. */
static bool has_colors(const struct las_file *file, size_t at)
{
    static const unsigned char black[6];
    const unsigned char *p = file->records + at;
    for (uint64_t i = 0; i < file->header.count; i++, p += file->header.record)
        if (memcmp(p, black, sizeof black) != 0)
            return true;
    log_info(file->env, "%s: all colours are 0: taken as not set", file->path);
    return false;
}

static void add_extras(struct las_file *file, const struct las_extras *extras)
{
    size_t at = file->header.size;
    for (size_t i = 0; i < extras->count && at < file->header.record; i++) {
        struct las_extra extra;
        bool is_number = las_extra_read(extras, i, &at, &extra);
        if (at > file->header.record) {
            log_warning(file->env,
                        "%s: extra bytes number %zu reach beyond the %zu bytes of a point: they "
                        "and those after them are left out",
                        file->path, i, file->header.record);
            return;
        }
        if (!is_number)
            continue;
        bool is_integer = extra.column.type < RECORD_FLOAT32 && extra.column.scale == 0;
        extra.column.first = file->records + extra.at;
        extra.column.stride = file->header.record;
        add_column(file, extra.name, is_integer ? SCALE_INTEGER : SCALE_FLOAT, &extra.column);
    }
}

static void add_columns(struct las_file *file, const struct las_extras *extras)
{
    const struct las_format *format = las_format_of(file->header.format);
    add_place(file);
    if (file->header.format < 6)
        add_old_flags(file);
    else
        add_new_flags(file);
    if (format->gps_time)
        add_time(file, format->gps_time);
    if (format->color && has_colors(file, format->color)) {
        add(file, "red", format->color, RECORD_UINT16);
        add(file, "green", format->color + 2, RECORD_UINT16);
        add(file, "blue", format->color + 4, RECORD_UINT16);
    }
    if (format->infrared)
        add(file, "infrared", format->infrared, RECORD_UINT16);
    add_extras(file, extras);
}

static bool is_withheld(const struct las_file *file, size_t row)
{
    unsigned flags = file->records[row * file->header.record + 15];
    return flags & (file->header.format < 6 ? 0x80 : 0x04);
}

static void move_floats(float *values, size_t width, size_t to, size_t from)
{
    if (values)
        memmove(values + to * width, values + from * width, width * sizeof *values);
}

/* The standard: points that are withheld should not be included in processing. */
static void drop_withheld(const struct las_file *file, struct cloud *cloud)
{
    size_t kept = 0, count = cloud->count;
    for (size_t i = 0; i < count; i++) {
        if (is_withheld(file, i))
            continue;
        if (kept < i) {
            memcpy(cloud->position[kept], cloud->position[i], sizeof *cloud->position);
            move_floats((float *)cloud->normal, 3, kept, i);
            move_floats(cloud->radius, 1, kept, i);
            move_floats((float *)cloud->color, 3, kept, i);
            move_floats(cloud->opacity, 1, kept, i);
            for (unsigned f = 0; f < cloud->field_count; f++)
                move_floats(cloud->fields[f].value, 1, kept, i);
        }
        kept++;
    }
    cloud->count = kept;
    if (kept < count)
        log_info(file->env, "%s: %zu points are marked as withheld: left out", file->path,
                 count - kept);
}

static enum stp_result read_columns(struct las_file *file, const struct load_options *options,
                                    struct cloud *cloud)
{
    struct table table = { .column = file->names, .count = file->count };
    table_name_roles(&table);
    enum stp_result result = table_plan(file->env, file->path, options, &table);
    if (result == STP_OK)
        result = table_allocate(file->env, file->path, file->header.count, &table, cloud);
    if (result != STP_OK)
        return result;
    records_read(file->env, file->columns, &table, file->header.count);
    drop_withheld(file, cloud);
    if (cloud->count == 0)
        cloud_release(cloud);
    else
        result = table_finish(file->env, file->path, options, &table, cloud);
    cloud->up = STP_UP_Z;
    return result;
}

static enum stp_result read_points(struct las_file *file, const struct load_options *options,
                                   struct cloud *cloud)
{
    struct las_extras extras = las_extras_find(file->env, file->path, file->bytes, &file->header);
    /* An extra number has at least a byte: what cannot lie within a point needs no room. */
    size_t extra = file->header.record - file->header.size;
    size_t room = 32 + (extras.count < extra ? extras.count : extra);
    file->records = file->bytes->data + file->header.points;
    file->names = mem_alloc(room, sizeof *file->names);
    file->columns = mem_alloc(room, sizeof *file->columns);
    enum stp_result result;
    if (file->names && file->columns) {
        add_columns(file, &extras);
        result = read_columns(file, options, cloud);
    } else {
        result = log_no_memory(file->env, room * sizeof *file->names, file->path);
    }
    mem_free(file->names);
    mem_free(file->columns);
    return result;
}

enum stp_result las_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud)
{
    struct las_file file = { .env = env, .path = path, .bytes = bytes };
    struct cloud read = { .up = STP_UP_Z };
    enum stp_result result = las_header_read(env, path, bytes, &file.header);
    if (result == STP_OK && file.header.count)
        result = read_points(&file, options, &read);
    if (result != STP_OK) {
        cloud_release(&read);
        return result;
    }
    snprintf(read.format, sizeof read.format, "LAS 1.%u, point format %u", file.header.minor,
             file.header.format);
    *cloud = read;
    return STP_OK;
}
