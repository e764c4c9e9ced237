#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "load/pcd.h"

static const struct text_style style = { .eol = '\n', .comments = true };

/* What the lines said, before it is put together. 0: the line was not there. */
struct lines {
    bool version, fields, size, type, count, width, height, points, data;
};

struct parse {
    const struct stp_env *env;
    const char *path;
    const char *begin, *at, *end;
    struct pcd_header *header;
    struct lines seen;
    char types[PCD_MAX_FIELDS];
    uint64_t width, points;
};

static enum stp_result fault(const struct parse *parse, const char *what, struct slice token)
{
    char text[40];
    slice_copy(token, text, sizeof text);
    return log_error(parse->env, STP_ERROR_FORMAT, "%s: byte %zu: %s \"%s\" in the PCD header",
                     parse->path, (size_t)(parse->at - parse->begin), what, text);
}

static bool read_whole(struct slice token, uint64_t most, uint64_t *value)
{
    *value = 0;
    for (size_t i = 0; i < token.length; i++) {
        unsigned digit = (unsigned)(unsigned char)token.text[i] - '0';
        if (digit > 9 || *value > (most - digit) / 10)
            return false;
        *value = *value * 10 + digit;
    }
    return token.length > 0;
}

static enum stp_result read_number(struct parse *parse, const char *line, uint64_t *value)
{
    struct slice token = text_token(&style, &line, parse->end);
    return read_whole(token, UINT64_MAX, value) ? STP_OK : fault(parse, "not a count:", token);
}

static enum stp_result read_fields(struct parse *parse, const char *line)
{
    struct slice token;
    parse->header->fields = 0;
    while ((token = text_token(&style, &line, parse->end)).length) {
        if (parse->header->fields == PCD_MAX_FIELDS)
            return fault(parse, "more than 256 fields: one too many is", token);
        parse->header->field[parse->header->fields++] =
            (struct pcd_field){ .name = token, .count = 1, .is_padding = slice_is(token, "_") };
    }
    return STP_OK;
}

/* SIZE, TYPE or COUNT: one entry a field. */
static enum stp_result read_entries(struct parse *parse, const char *line, char what)
{
    struct slice token;
    for (unsigned i = 0; i < parse->header->fields; i++) {
        uint64_t value = 0;
        token = text_token(&style, &line, parse->end);
        bool ok = what == 'T' ? token.length == 1 : read_whole(token, PCD_MAX_NUMBERS, &value);
        if (!ok || (what == 'C' && value == 0))
            return fault(parse, "not a size, type or count of a field:", token);
        if (what == 'T')
            parse->types[i] = *token.text;
        else if (what == 'S')
            parse->header->field[i].size = value;
        else
            parse->header->field[i].count = value;
    }
    token = text_token(&style, &line, parse->end);
    return token.length ? fault(parse, "more entries than fields:", token) : STP_OK;
}

static enum stp_result read_data(struct parse *parse, const char *line)
{
    static const char *const names[] = { "ascii", "binary", "binary_compressed" };
    struct slice token = text_token(&style, &line, parse->end);
    for (unsigned i = 0; i < 3; i++)
        if (slice_matches(token, names[i])) {
            parse->header->encoding = (enum pcd_encoding)i;
            return STP_OK;
        }
    return fault(parse, "an unknown kind of DATA:", token);
}

static enum stp_result read_line(struct parse *parse, struct slice key, const char *line)
{
    struct lines *seen = &parse->seen;
    bool entries = slice_is(key, "SIZE") || slice_is(key, "TYPE") || slice_is(key, "COUNT");
    if (entries && !seen->fields)
        return fault(parse, "FIELDS must come before", key);
    if (slice_is(key, "VERSION") || slice_is(key, "VIEWPOINT"))
        return STP_OK;
    if (slice_is(key, "FIELDS") || slice_is(key, "COLUMNS"))
        return seen->fields ? fault(parse, "a second line", key)
                            : (seen->fields = true, read_fields(parse, line));
    if (slice_is(key, "SIZE"))
        return seen->size = true, read_entries(parse, line, 'S');
    if (slice_is(key, "TYPE"))
        return seen->type = true, read_entries(parse, line, 'T');
    if (slice_is(key, "COUNT"))
        return seen->count = true, read_entries(parse, line, 'C');
    if (slice_is(key, "WIDTH"))
        return seen->width = true, read_number(parse, line, &parse->width);
    if (slice_is(key, "HEIGHT"))
        return seen->height = true, read_number(parse, line, &parse->header->height);
    if (slice_is(key, "POINTS"))
        return seen->points = true, read_number(parse, line, &parse->points);
    if (slice_is(key, "DATA"))
        return seen->data = true, read_data(parse, line);
    return fault(parse, "an unknown line", key);
}

static enum stp_result read_lines(struct parse *parse)
{
    enum stp_result result = STP_OK;
    while (result == STP_OK && !parse->seen.data) {
        parse->at = text_next_row(&style, parse->at, parse->end);
        const char *line = parse->at;
        if (line == parse->end)
            return log_error(parse->env, STP_ERROR_FORMAT,
                             "%s: byte %zu: the PCD header ends without a DATA line", parse->path,
                             (size_t)(line - parse->begin));
        struct slice key = text_token(&style, &line, parse->end);
        result = read_line(parse, key, line);
        if (result == STP_OK)
            parse->at = text_next_line(&style, parse->at, parse->end);
    }
    return result;
}

static enum record_type type_of(char type, size_t size)
{
    static const struct {
        char type;
        unsigned char size;
        enum record_type is;
    } types[] = {
        { 'I', 1, RECORD_INT8 },    { 'U', 1, RECORD_UINT8 },  { 'I', 2, RECORD_INT16 },
        { 'U', 2, RECORD_UINT16 },  { 'I', 4, RECORD_INT32 },  { 'U', 4, RECORD_UINT32 },
        { 'I', 8, RECORD_INT64 },   { 'U', 8, RECORD_UINT64 }, { 'F', 4, RECORD_FLOAT32 },
        { 'F', 8, RECORD_FLOAT64 },
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].type == type && types[i].size == size)
            return types[i].is;
    return RECORD_NONE;
}

static enum stp_result join_fields(struct parse *parse)
{
    struct pcd_header *header = parse->header;
    bool packed = false; /* only the first of its kind is taken apart */
    for (unsigned i = 0; i < header->fields; i++) {
        struct pcd_field *field = &header->field[i];
        field->type = type_of(parse->types[i], field->size);
        if (field->type == RECORD_NONE && !field->is_padding)
            return fault(parse, "SIZE and TYPE do not go together, of field", field->name);
        field->packed = !packed &&
                        (slice_is(field->name, "rgb") || slice_is(field->name, "rgba")) &&
                        field->size == 4 && field->count == 1;
        packed |= field->packed;
        size_t bytes = field->size * field->count;
        header->numbers += (unsigned)field->count;
        header->record += bytes;
        header->dense += field->is_padding ? 0 : bytes;
        if (header->numbers > PCD_MAX_NUMBERS)
            return fault(parse, "more than 4096 numbers a point, with field", field->name);
    }
    return STP_OK;
}

/* POINTS is newer than WIDTH and HEIGHT; where they differ, PCL's own reader takes POINTS. */
static enum stp_result join_count(struct parse *parse)
{
    struct pcd_header *header = parse->header;
    const struct lines *seen = &parse->seen;
    uint64_t product;
    if (!seen->height)
        header->height = 1;
    bool overflow = __builtin_mul_overflow(parse->width, header->height, &product);
    header->count = seen->points ? parse->points : product;
    if (!seen->points && (!seen->width || overflow))
        return fault(parse, "no count of points before", (struct slice){ "DATA", 4 });
    if (seen->points && seen->width && (overflow || product != parse->points))
        log_warning(parse->env, "%s: POINTS is not WIDTH times HEIGHT: POINTS holds", parse->path);
    return STP_OK;
}

enum stp_result pcd_header_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, struct pcd_header *header)
{
    const char *begin = (const char *)bytes->data;
    size_t size = bytes->size < PCD_MAX_HEADER ? bytes->size : PCD_MAX_HEADER;
    struct parse parse = {
        .env = env, .path = path, .begin = begin, .at = begin, .end = begin + size, .header = header
    };
    *header = (struct pcd_header){ 0 };
    enum stp_result result = read_lines(&parse);
    if (result != STP_OK)
        return result;
    header->body = (size_t)(parse.at - begin);
    if (!parse.seen.fields || !parse.seen.size || !parse.seen.type || !header->fields)
        return fault(&parse, "no FIELDS, SIZE and TYPE before", (struct slice){ "DATA", 4 });
    result = join_fields(&parse);
    return result == STP_OK ? join_count(&parse) : result;
}
