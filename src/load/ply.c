/* PLY: ascii and binary of both byte orders (Turk 1994, and what exporters made of it). */
#include "load/ply.h"

#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

bool ply_probe(const struct file_bytes *bytes)
{
    return bytes->size >= 3 && memcmp(bytes->data, "ply", 3) == 0 &&
           (bytes->size == 3 || bytes->data[3] <= ' ');
}

struct ply_file {
    const struct stp_env *env;
    const char *path;
    const struct file_bytes *bytes;
    struct ply_header header;
    const struct ply_element *vertex; /* NULL: there is none */
    size_t offset;                    /* of the first vertex */
};

const struct ply_element *ply_find_element(const struct ply_header *header, const char *name)
{
    for (unsigned i = 0; i < header->element_count; i++)
        if (slice_is(header->element[i].name, name))
            return &header->element[i];
    return NULL;
}

static bool has_property(const struct ply_header *header, const struct ply_element *element,
                         const char *name)
{
    for (unsigned i = 0; i < element->properties; i++)
        if (slice_is(header->property[element->first + i].name, name))
            return true;
    return false;
}

/* Trained Gaussians, plain or packed: their opacity and scale are logits and logarithms of volumes,
 * and drawing them as points would show something else. */
bool ply_is_gaussian(const struct ply_header *header, const struct ply_element *vertex)
{
    bool packed = has_property(header, vertex, "packed_rotation") &&
                  has_property(header, vertex, "packed_scale");
    return packed ||
           (has_property(header, vertex, "f_dc_0") &&
            (has_property(header, vertex, "scale_0") || has_property(header, vertex, "rot_0")));
}

static enum scale scale_of(const struct ply_header *header, enum ply_type type)
{
    if (header->prepared)
        return SCALE_LINEAR;
    if (type == PLY_INT8 || type == PLY_UINT8)
        return header->encoding == PLY_ASCII ? SCALE_UINT8 : SCALE_BYTE;
    return type >= PLY_FLOAT32 ? SCALE_FLOAT : SCALE_INTEGER;
}

void ply_fill_columns(const struct ply_header *header, const struct ply_element *vertex,
                      struct table *table)
{
    for (unsigned i = 0; i < table->count; i++) {
        const struct ply_property *property = &header->property[vertex->first + i];
        table->column[i] = (struct column){ .name = property->name,
                                            .scale = scale_of(header, property->type),
                                            .list = property->length != PLY_NONE };
    }
}

/* Before anything is allocated: can the vertices fit into the rest of the file? */
static enum stp_result check_size(const struct ply_file *file)
{
    bool has_list;
    uint64_t count = file->vertex->count, left = file->bytes->size - file->offset;
    size_t size = ply_element_size(&file->header, file->vertex, &has_list);
    if (file->header.encoding == PLY_ASCII) {
        size = 0; /* a digit and a separator for each scalar; the last separator may be missing */
        for (unsigned i = 0; i < file->vertex->properties; i++)
            size += file->header.property[file->vertex->first + i].length ? 0 : 2;
        left++;
    }
    if (count <= left / size)
        return STP_OK;
    return log_error(file->env, STP_ERROR_FORMAT,
                     "%s: byte %zu: element \"vertex\" claims %llu vertices of at least %zu bytes, "
                     "but the file ends in vertex %llu, at byte %zu: it is cut short or damaged%s",
                     file->path, file->offset, (unsigned long long)count, size,
                     (unsigned long long)(left / size), file->bytes->size,
                     file->header.encoding == PLY_ASCII ? "" : " (or was copied in text mode)");
}

/* Everything before the vertices, which need not come first. */
static enum stp_result skip_elements(struct ply_file *file)
{
    file->offset = file->header.body;
    const char *begin = (const char *)file->bytes->data, *end = begin + file->bytes->size;
    struct text_style style = { .eol = file->header.eol };
    for (const struct ply_element *e = file->header.element; e < file->vertex; e++) {
        if (file->header.encoding != PLY_ASCII) {
            enum stp_result result = ply_binary_skip(file->env, file->path, file->bytes,
                                                     &file->header, e, &file->offset);
            if (result != STP_OK)
                return result;
            continue;
        }
        const char *at = begin + file->offset;
        for (uint64_t i = 0; i < e->count && e->properties && at < end; i++)
            at = text_next_line(&style, text_next_row(&style, at, end), end);
        file->offset = (size_t)(at - begin);
    }
    return STP_OK;
}

static enum stp_result read_body(const struct ply_file *file, const struct table *table)
{
    const char *begin = (const char *)file->bytes->data;
    if (file->header.encoding != PLY_ASCII)
        return ply_binary_read(file->env, file->path, file->bytes, &file->header, file->vertex,
                               file->offset, table);
    struct row_source source = { .begin = begin,
                                 .body = begin + file->offset,
                                 .end = begin + file->bytes->size,
                                 .style = { .eol = file->header.eol },
                                 .element = "vertex",
                                 .ragged = true };
    return table_read_rows(file->env, file->path, &source, table, file->vertex->count);
}

/* Bytes left over after all elements: the file was not written as its header says. */
static void warn_trailing(const struct ply_file *file)
{
    bool has_list;
    size_t size = ply_element_size(&file->header, file->vertex, &has_list);
    if (file->header.encoding == PLY_ASCII || has_list ||
        file->vertex + 1 < file->header.element + file->header.element_count)
        return;
    size_t end = file->offset + file->vertex->count * size;
    if (end < file->bytes->size)
        log_warning(file->env,
                    "%s: %zu bytes follow the last vertex: the header may lie, or the file was "
                    "copied in text mode",
                    file->path, file->bytes->size - end);
}

/* What only prepared files have: read as floats, beside the cloud. */
struct extras {
    unsigned phong_values; /* 0: no ellipses */
    float (*phong)[PLY_PHONG_VALUES];
    int object_column; /* -1: one object */
    float *object;
};

static enum stp_result plan_extras(const struct ply_file *file, const struct table *table,
                                   struct extras *extras)
{
    if (!file->header.prepared)
        return STP_OK;
    enum stp_result result = ply_phong_plan(file->env, file->path, table, &extras->phong_values);
    return result == STP_OK ? ply_objects_plan(file->env, file->path, &file->header, table,
                                               &extras->object_column)
                            : result;
}

static enum stp_result allocate_extras(const struct ply_file *file, size_t count,
                                       struct table *table, struct extras *extras)
{
    bool objects = extras->object_column >= 0;
    if (extras->phong_values)
        extras->phong = mem_alloc(count, sizeof *extras->phong);
    if (objects)
        extras->object = mem_alloc(count, sizeof *extras->object);
    if ((extras->phong_values && !extras->phong) || (objects && !extras->object))
        return log_no_memory(file->env, count * sizeof *extras->phong, file->path);
    if (extras->phong)
        ply_phong_slots(table, extras->phong_values, extras->phong);
    if (extras->object)
        table->column[extras->object_column].slot[0] =
            (struct slot){ (char *)extras->object, sizeof *extras->object, false };
    return STP_OK;
}

static enum stp_result finish_extras(const struct ply_file *file, const struct extras *extras,
                                     struct cloud *cloud)
{
    enum stp_result result = STP_OK;
    if (extras->phong)
        result = ply_phong_finish(file->env, file->path, extras->phong_values,
                                  (const float(*)[PLY_PHONG_VALUES])extras->phong, cloud);
    if (result == STP_OK && extras->object)
        result = ply_objects_finish(file->env, file->path, &file->header, extras->object, cloud);
    return result;
}

/* The body into a cloud that is allocated. */
static enum stp_result read_cloud(const struct ply_file *file, const struct load_options *options,
                                  struct extras *extras, struct table *table, struct cloud *cloud)
{
    enum stp_result result = allocate_extras(file, cloud->count, table, extras);
    if (result == STP_OK)
        result = read_body(file, table);
    if (result == STP_OK)
        result = table_finish(file->env, file->path, options, table, cloud);
    if (result == STP_OK)
        result = finish_extras(file, extras, cloud);
    mem_free(extras->phong);
    mem_free(extras->object);
    return result;
}

static enum stp_result read_vertices(const struct ply_file *file,
                                     const struct load_options *options, struct table *table,
                                     struct cloud *cloud)
{
    ply_fill_columns(&file->header, file->vertex, table);
    table_name_roles(table);
    if (!table_has(table, ROLE_X) || !table_has(table, ROLE_Y))
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte %zu: element \"vertex\" has no scalar property %s", file->path,
                         file->header.body, table_has(table, ROLE_X) ? "y" : "x");
    if (!table_has(table, ROLE_Z))
        log_warning(file->env, "%s: element \"vertex\" has no property z: taken as 0", file->path);
    struct extras extras = { .object_column = -1 };
    enum stp_result result = table_plan(file->env, file->path, options, table);
    if (result == STP_OK)
        result = plan_extras(file, table, &extras);
    if (result == STP_OK)
        result = check_size(file);
    if (result == STP_OK)
        result = table_allocate(file->env, file->path, file->vertex->count, table, cloud);
    if (result != STP_OK)
        return result;
    warn_trailing(file);
    return read_cloud(file, options, &extras, table, cloud);
}

static enum stp_result read_points(struct ply_file *file, const struct load_options *options,
                                   struct cloud *cloud)
{
    file->vertex = ply_find_element(&file->header, "vertex");
    if (!file->vertex || file->vertex->count == 0)
        return STP_OK;
    if (ply_is_gaussian(&file->header, file->vertex))
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: a 3D Gaussian splatting PLY (f_dc_*, scale_*, rot_*, opacity): "
                         "trained Gaussians are not surface points; use a renderer made for them, "
                         "or export the point cloud they were trained from",
                         file->path);
    enum stp_result result = skip_elements(file);
    if (result != STP_OK)
        return result;
    struct table table = { .count = file->vertex->properties };
    table.column = mem_alloc(table.count, sizeof *table.column);
    if (!table.column)
        return log_no_memory(file->env, table.count * sizeof *table.column, file->path);
    result = read_vertices(file, options, &table, cloud);
    mem_free(table.column);
    return result;
}

enum stp_result ply_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud)
{
    static const char *const names[] = { "PLY ascii", "PLY binary little-endian",
                                         "PLY binary big-endian" };
    struct ply_file file = { .env = env, .path = path, .bytes = bytes };
    struct cloud read = { .up = STP_UP_Y };
    enum stp_result result = ply_header_read(env, path, bytes, &file.header);
    if (result != STP_OK)
        return result;
    result = read_points(&file, options, &read);
    snprintf(read.format, sizeof read.format, "%s", names[file.header.encoding]);
    read.object_count = file.header.object_count;
    read.objects = file.header.objects;
    file.header.objects = NULL;
    ply_header_release(&file.header);
    if (result == STP_OK)
        *cloud = read;
    else
        cloud_release(&read);
    return result;
}
