#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/ply.h"

#define MAX_LINE_TOKENS 8

struct line {
    struct slice token[MAX_LINE_TOKENS];
    unsigned count;   /* tokens, at most MAX_LINE_TOKENS kept */
    size_t offset;    /* of the line's first byte */
    struct slice all; /* without leading and trailing space */
};

struct scan {
    const struct stp_env *env;
    const char *path;
    const char *begin, *at, *end;
    struct text_style style;
    struct ply_header *header;
    bool formatted; /* the format line has been seen */
};

static enum stp_result header_error(const struct scan *scan, const struct line *line,
                                    const char *what)
{
    char text[64];
    slice_copy(line->all, text, sizeof text);
    return log_error(scan->env, STP_ERROR_FORMAT, "%s: byte %zu: %s in the PLY header: \"%s\"",
                     scan->path, line->offset, what, text);
}

static bool next_line(struct scan *scan, struct line *line)
{
    if (scan->at == scan->end)
        return false;
    const char *stop = text_line_end(&scan->style, scan->at, scan->end);
    if (stop == scan->end)
        return false;
    *line = (struct line){ .offset = (size_t)(scan->at - scan->begin) };
    const char *at = text_skip_space(&scan->style, scan->at, stop);
    line->all = (struct slice){ at, (size_t)(stop - at) };
    while (line->all.length && text_is_space(&scan->style, at[line->all.length - 1]))
        line->all.length--;
    while (line->count < MAX_LINE_TOKENS) {
        struct slice token = text_token(&scan->style, &at, stop);
        if (token.length == 0)
            break;
        line->token[line->count++] = token;
    }
    scan->at = stop + 1;
    return true;
}

static enum ply_type type_named(struct slice name)
{
    static const struct {
        const char *name;
        enum ply_type type;
    } types[] = {
        { "char", PLY_INT8 },       { "int8", PLY_INT8 },       { "uchar", PLY_UINT8 },
        { "uint8", PLY_UINT8 },     { "short", PLY_INT16 },     { "int16", PLY_INT16 },
        { "ushort", PLY_UINT16 },   { "uint16", PLY_UINT16 },   { "int", PLY_INT32 },
        { "int32", PLY_INT32 },     { "uint", PLY_UINT32 },     { "uint32", PLY_UINT32 },
        { "float", PLY_FLOAT32 },   { "float32", PLY_FLOAT32 }, { "double", PLY_FLOAT64 },
        { "float64", PLY_FLOAT64 },
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (slice_is(name, types[i].name))
            return types[i].type;
    return PLY_NONE;
}

static enum stp_result read_format(struct scan *scan, const struct line *line)
{
    if (scan->formatted || line->count < 3)
        return header_error(scan, line, "a format line that is incomplete or repeated");
    if (!slice_is(line->token[2], "1.0"))
        return header_error(scan, line, "an unknown version");
    if (slice_is(line->token[1], "ascii"))
        scan->header->encoding = PLY_ASCII;
    else if (slice_is(line->token[1], "binary_little_endian"))
        scan->header->encoding = PLY_LITTLE;
    else if (slice_is(line->token[1], "binary_big_endian"))
        scan->header->encoding = PLY_BIG;
    else
        return header_error(scan, line, "an unknown format");
    scan->formatted = true;
    return STP_OK;
}

/* Decimal digits only: no sign, no overflow. */
static bool read_count(struct slice text, uint64_t *count)
{
    uint64_t value = 0;
    for (size_t i = 0; i < text.length; i++) {
        char c = text.text[i];
        if (c < '0' || c > '9' || value > (UINT64_MAX - 9) / 10)
            return false;
        value = value * 10 + (uint64_t)(c - '0');
    }
    *count = value;
    return text.length > 0;
}

static enum stp_result read_element(struct scan *scan, const struct line *line)
{
    struct ply_header *header = scan->header;
    struct ply_element element = { .first = header->property_count };
    if (line->count < 3 || !read_count(line->token[2], &element.count))
        return header_error(scan, line, "an element without a valid count");
    if (header->element_count == PLY_MAX_ELEMENTS)
        return header_error(scan, line, "too many elements");
    element.name = line->token[1];
    header->element[header->element_count++] = element;
    return STP_OK;
}

/* Of coordinates: fields of any number may share a name, and are not read. */
static bool stands_before(const struct ply_header *header, struct slice name)
{
    const struct ply_element *element = &header->element[header->element_count - 1];
    bool coordinate = slice_is(name, "x") || slice_is(name, "y") || slice_is(name, "z");
    for (unsigned i = 0; coordinate && i < element->properties; i++) {
        struct slice other = header->property[element->first + i].name;
        if (other.length == 1 && *other.text == *name.text)
            return true;
    }
    return false;
}

static enum stp_result read_property(struct scan *scan, const struct line *line)
{
    struct ply_header *header = scan->header;
    bool list = line->count > 1 && slice_is(line->token[1], "list");
    unsigned type = list ? 3 : 1;
    struct ply_property property = { 0 };
    if (header->element_count == 0)
        return header_error(scan, line, "a property before any element");
    if (header->property_count == PLY_MAX_PROPERTIES)
        return header_error(scan, line, "too many properties");
    if (line->count < type + 2)
        return header_error(scan, line, "an incomplete property");
    property.type = type_named(line->token[type]);
    property.name = line->token[type + 1];
    property.length = list ? type_named(line->token[2]) : PLY_NONE;
    if (property.type == PLY_NONE || (list && property.length == PLY_NONE))
        return header_error(scan, line, "an unknown type");
    if (stands_before(header, property.name))
        return header_error(scan, line, "a coordinate that the element has already");
    if (property.length >= PLY_FLOAT32)
        return header_error(scan, line, "a list whose length is not an integer");
    header->property[header->property_count++] = property;
    header->element[header->element_count - 1].properties++;
    return STP_OK;
}

/* Comments mean something in a prepared file only. */
static enum stp_result read_comment(struct scan *scan, const struct line *line)
{
    if (slice_is(line->all, "comment stipple prepared 1"))
        scan->header->prepared = true;
    if (!scan->header->prepared || line->count < 3 || !slice_is(line->token[1], "stipple") ||
        !slice_is(line->token[2], "object"))
        return STP_OK;
    return ply_objects_note(scan->env, scan->path, line->token + 3, line->count - 3, scan->header);
}

static enum stp_result read_line(struct scan *scan, const struct line *line)
{
    if (line->count == 0 || slice_is(line->token[0], "obj_info"))
        return STP_OK;
    if (slice_is(line->token[0], "comment"))
        return read_comment(scan, line);
    if (slice_is(line->token[0], "format"))
        return read_format(scan, line);
    if (slice_is(line->token[0], "element"))
        return read_element(scan, line);
    if (slice_is(line->token[0], "property"))
        return read_property(scan, line);
    return header_error(scan, line, "an unknown keyword");
}

static enum stp_result read_lines(struct scan *scan)
{
    struct line line;
    next_line(scan, &line); /* "ply", by the probe */
    while (next_line(scan, &line)) {
        if (line.count && slice_is(line.token[0], "end_header")) {
            scan->header->body = (size_t)(scan->at - scan->begin);
            return scan->formatted ? STP_OK : header_error(scan, &line, "no format line");
        }
        enum stp_result result = read_line(scan, &line);
        if (result != STP_OK)
            return result;
    }
    return log_error(
        scan->env, STP_ERROR_FORMAT,
        "%s: byte %zu: the PLY header has no end_header line: the file is cut short or "
        "damaged",
        scan->path, (size_t)(scan->at - scan->begin));
}

enum stp_result ply_header_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, struct ply_header *header)
{
    const char *begin = (const char *)bytes->data;
    size_t size = bytes->size < PLY_MAX_HEADER ? bytes->size : PLY_MAX_HEADER;
    struct scan scan = {
        .env = env, .path = path, .begin = begin, .at = begin, .end = begin + size, .header = header
    };
    *header = (struct ply_header){ 0 };
    header->eol = scan.style.eol = text_eol(begin, begin + size);
    header->property = mem_alloc(PLY_MAX_PROPERTIES, sizeof *header->property);
    if (!header->property)
        return log_no_memory(env, PLY_MAX_PROPERTIES * sizeof *header->property, path);
    enum stp_result result = read_lines(&scan);
    if (result != STP_OK)
        ply_header_release(header);
    return result;
}

void ply_header_release(struct ply_header *header)
{
    mem_free(header->property);
    mem_free(header->objects);
    header->property = NULL;
    header->objects = NULL;
    header->object_count = 0;
}

size_t ply_type_size(enum ply_type type)
{
    static const size_t size[] = { 0, 1, 1, 2, 2, 4, 4, 4, 8 };
    return size[type];
}

size_t ply_element_size(const struct ply_header *header, const struct ply_element *element,
                        bool *has_list)
{
    size_t size = 0;
    *has_list = false;
    for (unsigned i = 0; i < element->properties; i++) {
        const struct ply_property *property = &header->property[element->first + i];
        *has_list |= property->length != PLY_NONE;
        size += ply_type_size(property->length ? property->length : property->type);
    }
    return size;
}
