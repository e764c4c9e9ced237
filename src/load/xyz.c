/* Plain text points: numbers in columns, whose meaning comes from a line of names or is guessed. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "load/readers.h"
#include "load/table.h"

#define MAX_COLUMNS   64
#define PROBE_BYTES   4096
#define SAMPLE_PLACES 32
#define SAMPLE_ROWS   32 /* at each place */

struct xyz_file {
    const struct stp_env *env;
    const char *path;
    const char *begin, *body, *end;
    struct text_style style;
    unsigned columns; /* numbers in the first row; 0: there are no rows */
    unsigned names;   /* words in the line of names; 0: there is none */
    struct slice name[MAX_COLUMNS];
    double claimed; /* the count in the first line; -1: there is none */
    bool ptx;       /* two lines of one count each */
};

/* Words of a line, and how many of them are numbers from the first one on. */
static unsigned read_words(const struct xyz_file *file, const char *at, struct slice *word,
                           unsigned *numbers)
{
    unsigned count = 0;
    *numbers = 0;
    while (count < MAX_COLUMNS) {
        struct slice token = text_token(&file->style, &at, file->end);
        double value;
        const char *digit = token.text;
        if (token.length == 0 || *token.text == '#')
            break;
        if (*numbers == count && number_read(&digit, token.text + token.length, &value) &&
            digit == token.text + token.length)
            ++*numbers;
        word[count++] = token;
    }
    return count;
}

/* The comment on the line above the first row: many programs write the names there. */
static void read_comment_names(struct xyz_file *file, const char *row)
{
    const char *at = file->begin, *comment = NULL;
    while ((at = text_skip_space(&file->style, at, row)) < row) {
        if (*at == '#' || *at == '/')
            comment = at;
        at = text_next_line(&file->style, at, row);
    }
    unsigned numbers;
    while (comment && comment < row && (*comment == '#' || *comment == '/'))
        comment++;
    if (comment)
        file->names = read_words(file, comment, file->name, &numbers);
}

/* What the first lines say: a count, a line of names, the number of columns. False: no points. */
static bool find_layout(struct xyz_file *file)
{
    struct slice word[MAX_COLUMNS];
    unsigned numbers, words;
    const char *at = text_next_row(&file->style, file->begin, file->end);
    file->claimed = -1;
    if (at < file->end)
        read_comment_names(file, at);
    words = read_words(file, at, word, &numbers);
    if (words == 1 && numbers == 1) {
        number_read(&(const char *){ at }, file->end, &file->claimed);
        at = text_next_row(&file->style, text_next_line(&file->style, at, file->end), file->end);
        words = read_words(file, at, word, &numbers);
        file->ptx = words == 1 && numbers == 1;
    }
    if (words && numbers == 0) {
        memcpy(file->name, word, words * sizeof *word);
        file->names = words;
        at = text_next_row(&file->style, text_next_line(&file->style, at, file->end), file->end);
        words = read_words(file, at, word, &numbers);
    }
    file->body = at;
    file->columns = numbers;
    return file->ptx || at == file->end || (numbers == words && numbers >= 3);
}

static struct xyz_file open_file(const struct stp_env *env, const char *path,
                                 const struct file_bytes *bytes)
{
    const char *begin = (const char *)bytes->data, *end = begin + bytes->size;
    return (struct xyz_file){
        .env = env,
        .path = path,
        .begin = begin,
        .end = end,
        .style = { .eol = text_eol(begin, end), .comments = true, .lists = true },
    };
}

bool xyz_probe(const struct file_bytes *bytes)
{
    size_t first = bytes->size < PROBE_BYTES ? bytes->size : PROBE_BYTES;
    if (bytes->size == 0 || memchr(bytes->data, 0, first))
        return false;
    struct xyz_file file = open_file(NULL, "", bytes);
    return find_layout(&file);
}

/* What a sample of the rows says of each column, and of the triple that begins there. */
struct sample {
    size_t rows;
    double min[MAX_COLUMNS], max[MAX_COLUMNS];
    bool whole[MAX_COLUMNS];
    bool unit[MAX_COLUMNS]; /* of length 1, or 0 */
};

static void sample_row(const struct xyz_file *file, const char *at, struct sample *sample)
{
    double value[MAX_COLUMNS];
    unsigned count = 0;
    for (; count < file->columns; count++) {
        at = text_skip_space(&file->style, at, file->end);
        if (!number_read(&at, file->end, &value[count]))
            return;
    }
    sample->rows++;
    for (unsigned i = 0; i < count; i++) {
        sample->min[i] = fmin(sample->min[i], value[i]);
        sample->max[i] = fmax(sample->max[i], value[i]);
        sample->whole[i] = sample->whole[i] && value[i] == trunc(value[i]);
        if (i + 2 >= count)
            continue;
        double length =
            sqrt(value[i] * value[i] + value[i + 1] * value[i + 1] + value[i + 2] * value[i + 2]);
        sample->unit[i] = sample->unit[i] && (fabs(length - 1) < 0.01 || length == 0);
    }
}

static void take_sample(const struct xyz_file *file, struct sample *sample)
{
    size_t size = (size_t)(file->end - file->body);
    sample->rows = 0;
    for (unsigned i = 0; i < file->columns; i++) {
        sample->min[i] = INFINITY;
        sample->max[i] = -INFINITY;
        sample->whole[i] = sample->unit[i] = true;
    }
    for (size_t place = 0; place < SAMPLE_PLACES; place++) {
        const char *at = file->body + size / SAMPLE_PLACES * place;
        if (place)
            at = text_next_line(&file->style, at, file->end);
        for (int row = 0; row < SAMPLE_ROWS; row++) {
            at = text_next_row(&file->style, at, file->end);
            if (at == file->end)
                break;
            sample_row(file, at, sample);
            at = text_next_line(&file->style, at, file->end);
        }
    }
}

/* A triple that is all whole numbers of 16 bits, or all within 0..1. */
static bool is_color(const struct sample *s, unsigned column)
{
    bool whole = true, fraction = true;
    for (unsigned i = column; i < column + 3; i++) {
        whole = whole && s->whole[i] && s->min[i] >= 0 && s->max[i] <= 65535;
        fraction = fraction && s->min[i] >= 0 && s->max[i] <= 1;
    }
    return whole || fraction;
}

/* All three normals of a column of zeros are not one. */
static bool is_normal(const struct sample *s, unsigned column)
{
    bool nonzero = false;
    for (unsigned i = column; i < column + 3; i++)
        nonzero = nonzero || s->min[i] < 0 || s->max[i] > 0;
    return s->unit[column] && nonzero;
}

static void set_triple(struct table *table, unsigned column, enum role role)
{
    static const char *const names[] = {
        "", "x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"
    };
    for (unsigned i = 0; i < 3; i++) {
        const char *name = names[role + i];
        table->column[column + i].role = role + i;
        table->column[column + i].name = (struct slice){ name, strlen(name) };
    }
}

/* x y z, then from left to right: three of unit length are a normal, three that fit are a colour,
 * the first other column is an intensity. A PTS file (a count in its first line) has its intensity
 * before the colour. */
static void guess_columns(const struct xyz_file *file, struct table *table)
{
    struct sample sample;
    bool normal = false, color = false, intensity = false;
    take_sample(file, &sample);
    set_triple(table, 0, ROLE_X);
    for (unsigned c = 3; c < table->count && c < MAX_COLUMNS;) {
        unsigned left = table->count - c;
        bool pts = file->claimed >= 0 && left == 4 && !intensity && is_color(&sample, c + 1);
        if (!normal && left >= 3 && is_normal(&sample, c)) {
            set_triple(table, c, ROLE_NX);
            normal = true;
            c += 3;
        } else if (!color && left >= 3 && !pts && is_color(&sample, c)) {
            set_triple(table, c, ROLE_RED);
            color = true;
            c += 3;
        } else {
            table->column[c++].name =
                intensity ? (struct slice){ "scalar", 6 } : (struct slice){ "intensity", 9 };
            intensity = true;
        }
    }
}

static struct slice unquoted(struct slice word)
{
    if (word.length >= 2 && *word.text == '"' && word.text[word.length - 1] == '"')
        return (struct slice){ word.text + 1, word.length - 2 };
    return word;
}

static void plan_columns(const struct xyz_file *file, struct table *table)
{
    table->count = file->columns;
    for (unsigned i = 0; i < table->count; i++)
        table->column[i] = (struct column){ .name = unquoted(file->name[i]), .scale = SCALE_TEXT };
    if (file->names == file->columns)
        table_name_roles(table);
    if (table_has(table, ROLE_X) && table_has(table, ROLE_Y) && table_has(table, ROLE_Z))
        return;
    for (unsigned i = 0; i < table->count; i++)
        table->column[i] = (struct column){ .scale = SCALE_TEXT };
    guess_columns(file, table);
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Semicolons, spaces or tabs between numbers, one comma at most within each: Europe's
 * spreadsheets. */
static bool has_decimal_commas(const struct xyz_file *file)
{
    const char *line = file->body, *end = text_line_end(&file->style, line, file->end);
    unsigned numbers = 1, commas = 0, most = 0;
    for (const char *c = line + 1; c + 1 < end; c++) {
        bool between = (*c == ';' || *c == ' ' || *c == '\t') && is_digit(c[-1]);
        if (*c == '.' || (*c == ',' && !(is_digit(c[-1]) && is_digit(c[1]))))
            return false;
        numbers += between;
        commas = between ? 0 : commas + (*c == ',');
        most = commas > most ? commas : most;
    }
    return numbers > 1 && most == 1;
}

static enum stp_result check_count(const struct xyz_file *file, size_t rows)
{
    if (file->claimed > (double)rows)
        return log_error(
            file->env, STP_ERROR_FORMAT,
            "%s: byte %zu: the first line claims %.0f points, the file ends after %zu: "
            "it is cut short",
            file->path, (size_t)(file->end - file->begin), file->claimed, rows);
    if (file->claimed >= 0 && file->claimed < (double)rows)
        log_warning(file->env, "%s: the first line says %.0f points, all %zu lines are read",
                    file->path, file->claimed, rows);
    return STP_OK;
}

static enum stp_result read_rows(const struct xyz_file *file, const struct load_options *options,
                                 struct cloud *cloud)
{
    struct column columns[MAX_COLUMNS];
    struct table table = { .column = columns };
    struct row_source source = { .begin = file->begin,
                                 .body = file->body,
                                 .end = file->end,
                                 .style = file->style,
                                 .element = "point",
                                 .open = true };
    size_t rows = table_count_rows(file->env, &source);
    enum stp_result result = check_count(file, rows);
    if (result != STP_OK)
        return result;
    plan_columns(file, &table);
    result = table_plan(file->env, file->path, options, &table);
    if (result == STP_OK)
        result = table_allocate(file->env, file->path, rows, &table, cloud);
    if (result == STP_OK)
        result = table_read_rows(file->env, file->path, &source, &table, rows);
    if (result == STP_OK)
        result = table_finish(file->env, file->path, options, &table, cloud);
    return result;
}

enum stp_result xyz_read(const struct stp_env *env, const char *path,
                         const struct file_bytes *bytes, const struct load_options *options,
                         struct cloud *cloud)
{
    struct xyz_file file = open_file(env, path, bytes);
    struct cloud read = { .up = STP_UP_Y };
    enum stp_result result = STP_OK;
    find_layout(&file);
    if (file.ptx)
        return log_error(env, STP_ERROR_FORMAT, "%s: PTX is not read: convert it to PLY", path);
    if (file.columns && has_decimal_commas(&file))
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: byte %zu: decimal commas are not read: write decimal points", path,
                         (size_t)(file.body - file.begin));
    if (file.columns)
        result = read_rows(&file, options, &read);
    else
        result = check_count(&file, 0);
    if (result != STP_OK) {
        cloud_release(&read);
        return result;
    }
    snprintf(read.format, sizeof read.format, "text");
    *cloud = read;
    return STP_OK;
}
