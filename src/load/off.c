/* Geomview's OFF: x y z, then a normal (N), then a colour (C); faces are not read. */
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "load/readers.h"
#include "load/table.h"

#define MAX_COLUMNS 12 /* x y z, normal, colour of up to four, texture */

struct off_file {
    const struct stp_env *env;
    const char *path;
    const char *begin, *at, *end;
    struct text_style style;
    struct slice keyword;
    size_t count;
};

/* [ST][C][N][4][n]OFF, and NC for CN, which exporters write too. */
static bool is_keyword(struct slice word)
{
    size_t length = word.length;
    if (length < 3 || length > 9 || memcmp(word.text + length - 3, "OFF", 3) != 0)
        return false;
    for (size_t i = 0; i + 3 < length; i++)
        if (!memchr("STCN4n", word.text[i], 6))
            return false;
    return true;
}

static bool has_flag(struct slice keyword, char flag)
{
    return memchr(keyword.text, flag, keyword.length - 3) != NULL;
}

static struct slice read_keyword(const struct file_bytes *bytes, struct text_style *style,
                                 const char **at)
{
    const char *begin = (const char *)bytes->data;
    const char *end = begin + (bytes->size < 4096 ? bytes->size : 4096);
    *style = (struct text_style){ .eol = text_eol(begin, end), .comments = true };
    *at = text_next_row(style, begin, end);
    return text_token(style, at, end);
}

bool off_probe(const struct file_bytes *bytes)
{
    struct text_style style;
    const char *at;
    return bytes->size >= 3 && is_keyword(read_keyword(bytes, &style, &at));
}

static enum stp_result off_error(const struct off_file *file, const char *what)
{
    return log_error(file->env, STP_ERROR_FORMAT, "%s: byte %zu: %s in the OFF header", file->path,
                     (size_t)(file->at - file->begin), what);
}

/* Vertices, faces, edges: three numbers, on the keyword's line or after it; the edges may be
 * missing. Only the first counts here. */
static enum stp_result read_counts(struct off_file *file)
{
    double value;
    const char *at = text_next_row(&file->style, file->at, file->end);
    if (at == file->end || !number_read(&at, file->end, &value))
        return off_error(file, "no count of vertices");
    if (!(value >= 0 && value <= 9007199254740992.0) || value != (double)(uint64_t)value)
        return off_error(file, "an impossible count of vertices");
    file->count = (size_t)value;
    file->at = text_next_line(&file->style, at, file->end);
    if (file->count > (size_t)(file->end - file->at + 1) / 6)
        return off_error(file, "more vertices claimed than the file can hold");
    return STP_OK;
}

static unsigned count_tokens(const struct off_file *file)
{
    unsigned count = 0;
    const char *at = text_next_row(&file->style, file->at, file->end);
    while (count < MAX_COLUMNS && text_token(&file->style, &at, file->end).length)
        count++;
    return count;
}

static struct column named(const char *name)
{
    return (struct column){ .name = { name, strlen(name) }, .scale = SCALE_TEXT };
}

/* The columns that the keyword names; a colour is as long as the first line says. */
static enum stp_result plan_columns(const struct off_file *file, struct table *table)
{
    static const char *const names[] = { "x",  "y",   "z",     "nx",   "ny",
                                         "nz", "red", "green", "blue", "alpha" };
    unsigned tokens = count_tokens(file);
    bool normal = has_flag(file->keyword, 'N'), color = has_flag(file->keyword, 'C');
    unsigned fixed = normal ? 6 : 3;
    table->count = 0;
    for (unsigned i = 0; i < fixed; i++)
        table->column[table->count++] = named(names[i]);
    if (!color)
        return STP_OK;
    bool alpha = tokens >= fixed + 4 && !has_flag(file->keyword, 'T');
    if (tokens < fixed + 3)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte %zu: the first vertex has %u numbers; %.*s needs %u", file->path,
                         (size_t)(file->at - file->begin), tokens, (int)file->keyword.length,
                         file->keyword.text, fixed + 3);
    for (unsigned i = 6; i < (alpha ? 10 : 9); i++)
        table->column[table->count++] = named(names[i]);
    return STP_OK;
}

static enum stp_result read_vertices(const struct off_file *file,
                                     const struct load_options *options, struct cloud *cloud)
{
    struct column columns[MAX_COLUMNS];
    struct table table = { .column = columns };
    enum stp_result result = plan_columns(file, &table);
    if (result != STP_OK)
        return result;
    table_name_roles(&table);
    result = table_plan(file->env, file->path, options, &table);
    if (result == STP_OK)
        result = table_allocate(file->env, file->path, file->count, &table, cloud);
    if (result != STP_OK)
        return result;
    struct row_source source = { .begin = file->begin,
                                 .body = file->at,
                                 .end = file->end,
                                 .style = file->style,
                                 .element = "vertex",
                                 .ragged = true,
                                 .open = true };
    result = table_read_rows(file->env, file->path, &source, &table, file->count);
    if (result == STP_OK)
        result = table_finish(file->env, file->path, options, &table, cloud);
    return result;
}

enum stp_result off_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud)
{
    const char *begin = (const char *)bytes->data;
    struct off_file file = { .env = env, .path = path, .begin = begin, .end = begin + bytes->size };
    struct cloud read = { .up = STP_UP_Y };
    file.keyword = read_keyword(bytes, &file.style, &file.at);
    const char *at = file.at;
    if (has_flag(file.keyword, '4') || has_flag(file.keyword, 'n'))
        return off_error(&file, "vertices of other than three dimensions");
    if (slice_is(text_token(&file.style, &at, file.end), "BINARY"))
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: binary OFF is not read: convert it to PLY or to text OFF", path);
    enum stp_result result = read_counts(&file);
    if (result == STP_OK && file.count)
        result = read_vertices(&file, options, &read);
    if (result != STP_OK) {
        cloud_release(&read);
        return result;
    }
    snprintf(read.format, sizeof read.format, "%.*s", (int)file.keyword.length, file.keyword.text);
    *cloud = read;
    return STP_OK;
}
