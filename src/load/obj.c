/* Wavefront OBJ: vertices, and their normals where the file ties them to vertices. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/readers.h"
#include "load/table.h"

#define PROBE_BYTES 65536

struct obj_file {
    const struct stp_env *env;
    const char *path;
    const char *begin, *end;
    struct text_style style;
    size_t vertices, normals, colored;
    bool faces_name_normals; /* some f line has v//vn or v/vt/vn */
    double (*sum)[3];        /* of the normals at each vertex, through the faces */
};

static const char *const directives[] = { "v", "vn", "vt", "vp",     "f",      "o",     "g",
                                          "s", "l",  "p",  "mtllib", "usemtl", "cstype" };

static bool is_directive(struct slice word)
{
    for (size_t i = 0; i < sizeof directives / sizeof *directives; i++)
        if (slice_is(word, directives[i]))
            return true;
    return false;
}

bool obj_probe(const struct file_bytes *bytes)
{
    const char *begin = (const char *)bytes->data;
    const char *end = begin + (bytes->size < PROBE_BYTES ? bytes->size : PROBE_BYTES);
    if (bytes->size == 0)
        return false;
    struct text_style style = { .eol = text_eol(begin, end), .comments = true };
    const char *at = text_next_row(&style, begin, end);
    return is_directive(text_token(&style, &at, end));
}

/* The next line of interest: its first word, and *at after it. */
static struct slice next_row(const struct obj_file *file, const char **at)
{
    *at = text_next_row(&file->style, *at, file->end);
    return text_token(&file->style, at, file->end);
}

static enum stp_result obj_error(const struct obj_file *file, const char *at, const char *what)
{
    return log_error(file->env, STP_ERROR_FORMAT, "%s: byte %zu: %s", file->path,
                     (size_t)(at - file->begin), what);
}

/* Numbers to the end of the line, at most `size`; a word that is none ends them, with *clean
 * false. */
static unsigned read_numbers(const struct obj_file *file, const char *at, double *value,
                             unsigned size, bool *clean)
{
    unsigned count = 0;
    *clean = true;
    while (count < size) {
        struct slice word = text_token(&file->style, &at, file->end);
        const char *digit = word.text;
        if (word.length == 0 || *word.text == '#')
            break;
        *clean = number_read(&digit, word.text + word.length, &value[count]) &&
                 digit == word.text + word.length;
        if (!*clean)
            break;
        count++;
    }
    return count;
}

/* v, v/vt, v//vn or v/vt/vn, as signed indices from 1; 0 where there is none. */
static void read_corner(struct slice word, long long *vertex, long long *normal)
{
    long long part[3] = { 0 };
    const char *at = word.text, *end = word.text + word.length;
    for (int i = 0; i < 3 && at < end; i++) {
        bool negative = *at == '-';
        at += negative;
        for (; at < end && *at >= '0' && *at <= '9'; at++)
            if (part[i] < 1ll << 48)
                part[i] = part[i] * 10 + (*at - '0');
        if (negative)
            part[i] = -part[i];
        if (at < end && *at++ != '/')
            break;
    }
    *vertex = part[0];
    *normal = part[2];
}

static void count_row(struct obj_file *file, struct slice word, const char *at)
{
    double value[8];
    bool clean;
    long long vertex, normal;
    if (slice_is(word, "v")) {
        file->vertices++;
        file->colored += read_numbers(file, at, value, 8, &clean) >= 6;
    } else if (slice_is(word, "vn")) {
        file->normals++;
    } else if (slice_is(word, "f") && !file->faces_name_normals) {
        read_corner(text_token(&file->style, &at, file->end), &vertex, &normal);
        file->faces_name_normals = normal != 0;
    }
}

static void count_rows(struct obj_file *file)
{
    const char *at = file->begin;
    for (;;) {
        struct slice word = next_row(file, &at);
        if (word.length == 0)
            return;
        count_row(file, word, at);
        at = text_next_line(&file->style, at, file->end);
    }
}

/* x y z [w], then r g b. Seven numbers are x y z w r g b. */
static enum stp_result store_vertex(const struct obj_file *file, const char *at, size_t row,
                                    const struct table *table)
{
    double value[8];
    bool clean;
    unsigned count = read_numbers(file, at, value, 8, &clean);
    if (!clean || count < 3)
        return obj_error(file, at, "a vertex (v) without three numbers");
    for (unsigned i = 0; i < table->count; i++) {
        unsigned from = i < 3 ? i : count >= 7 ? i + 1 : i;
        slot_store(&table->column[i].slot[0], row, value[from]);
        slot_store(&table->column[i].slot[1], row, value[from]);
    }
    return STP_OK;
}

static enum stp_result store_normal(const struct obj_file *file, const char *at, size_t row,
                                    float (*normal)[3])
{
    double value[3];
    bool clean;
    if (read_numbers(file, at, value, 3, &clean) < 3)
        return obj_error(file, at, "a normal (vn) without three numbers");
    for (int c = 0; c < 3; c++)
        normal[row][c] = (float)value[c];
    return STP_OK;
}

/* v lines into the table's slots, vn lines into `normal` unless it is NULL. */
static enum stp_result store_rows(const struct obj_file *file, const struct table *table,
                                  float (*normal)[3])
{
    const char *at = file->begin;
    size_t vertex = 0, normals = 0;
    enum stp_result result = STP_OK;
    while (result == STP_OK) {
        struct slice word = next_row(file, &at);
        if (word.length == 0)
            return STP_OK;
        if (slice_is(word, "v"))
            result = store_vertex(file, at, vertex++, table);
        else if (normal && slice_is(word, "vn"))
            result = store_normal(file, at, normals++, normal);
        at = text_next_line(&file->style, at, file->end);
    }
    return result;
}

/* From 1, or from the last one backwards; SIZE_MAX when it names nothing. */
static size_t resolve(long long index, size_t seen, size_t count)
{
    if (index < 0)
        return (unsigned long long)-index <= seen ? seen - (size_t)-index : SIZE_MAX;
    return index > 0 && (unsigned long long)index <= count ? (size_t)index - 1 : SIZE_MAX;
}

static void add_face(struct obj_file *file, const char *at, size_t vertices, size_t normals,
                     const float (*normal)[3])
{
    for (;;) {
        long long v = 0, n = 0;
        struct slice word = text_token(&file->style, &at, file->end);
        if (word.length == 0 || *word.text == '#')
            return;
        read_corner(word, &v, &n);
        size_t vertex = resolve(v, vertices, file->vertices);
        size_t from = resolve(n, normals, file->normals);
        for (int c = 0; c < 3 && vertex != SIZE_MAX && from != SIZE_MAX; c++)
            file->sum[vertex][c] += normal[from][c];
    }
}

static void add_faces(struct obj_file *file, const float (*normal)[3])
{
    const char *at = file->begin;
    size_t vertices = 0, normals = 0;
    for (;;) {
        struct slice word = next_row(file, &at);
        if (word.length == 0)
            return;
        vertices += slice_is(word, "v");
        normals += slice_is(word, "vn");
        if (slice_is(word, "f"))
            add_face(file, at, vertices, normals, normal);
        at = text_next_line(&file->style, at, file->end);
    }
}

/* The mean direction of the normals at each vertex; (0, 0, 0) where no face names one. */
static enum stp_result normals_through_faces(struct obj_file *file, const float (*normal)[3],
                                             struct cloud *cloud)
{
    file->sum = mem_zalloc(file->vertices, sizeof *file->sum);
    cloud->normal = mem_alloc(file->vertices, sizeof *cloud->normal);
    if (!file->sum || !cloud->normal) {
        mem_free(file->sum);
        return log_no_memory(file->env, file->vertices * sizeof *file->sum, file->path);
    }
    add_faces(file, normal);
    for (size_t i = 0; i < file->vertices; i++) {
        double *s = file->sum[i], length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
        for (int c = 0; c < 3; c++)
            cloud->normal[i][c] = (float)(length > 0 ? s[c] / length : 0);
    }
    mem_free(file->sum);
    file->sum = NULL;
    return STP_OK;
}

static enum stp_result read_rows(struct obj_file *file, const struct table *table,
                                 struct cloud *cloud)
{
    bool paired = !file->faces_name_normals && file->normals == file->vertices;
    float(*normal)[3] = NULL;
    if (file->normals && (paired || file->faces_name_normals)) {
        normal = mem_alloc(file->normals, sizeof *normal);
        if (!normal)
            return log_no_memory(file->env, file->normals * sizeof *normal, file->path);
    }
    enum stp_result result = store_rows(file, table, normal);
    if (result == STP_OK && paired) {
        cloud->normal = normal;
        return STP_OK;
    }
    if (result == STP_OK && normal)
        result = normals_through_faces(file, (const float(*)[3])normal, cloud);
    mem_free(normal);
    return result;
}

static enum stp_result read_cloud(struct obj_file *file, const struct load_options *options,
                                  struct cloud *cloud)
{
    static const char *const names[] = { "x", "y", "z", "red", "green", "blue" };
    struct column columns[6];
    struct table table = { .column = columns, .count = 3 };
    if (file->colored == file->vertices)
        table.count = 6;
    else if (file->colored)
        log_warning(file->env, "%s: %zu of %zu vertices have colours: they are left out",
                    file->path, file->colored, file->vertices);
    for (unsigned i = 0; i < table.count; i++)
        columns[i] = (struct column){ .name = { names[i], strlen(names[i]) }, .scale = SCALE_TEXT };
    table_name_roles(&table);
    enum stp_result result = table_plan(file->env, file->path, options, &table);
    if (result == STP_OK)
        result = table_allocate(file->env, file->path, file->vertices, &table, cloud);
    if (result == STP_OK)
        result = read_rows(file, &table, cloud);
    if (result == STP_OK)
        result = table_finish(file->env, file->path, options, &table, cloud);
    return result;
}

enum stp_result obj_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud)
{
    const char *begin = (const char *)bytes->data;
    struct obj_file file = { .env = env, .path = path, .begin = begin, .end = begin + bytes->size };
    struct cloud read = { .up = STP_UP_Y };
    enum stp_result result = STP_OK;
    file.style = (struct text_style){ .eol = text_eol(file.begin, file.end), .comments = true };
    count_rows(&file);
    if (file.vertices)
        result = read_cloud(&file, options, &read);
    if (result != STP_OK) {
        cloud_release(&read);
        return result;
    }
    snprintf(read.format, sizeof read.format, "OBJ");
    *cloud = read;
    return STP_OK;
}
