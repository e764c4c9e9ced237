#include "load/text.h"

#include <string.h>

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

bool slice_is(struct slice slice, const char *word)
{
    return strlen(word) == slice.length && memcmp(slice.text, word, slice.length) == 0;
}

bool slice_matches(struct slice slice, const char *word)
{
    if (strlen(word) != slice.length)
        return false;
    for (size_t i = 0; i < slice.length; i++)
        if (lower(slice.text[i]) != lower(word[i]))
            return false;
    return true;
}

void slice_copy(struct slice slice, char *out, size_t size)
{
    size_t length = slice.length < size ? slice.length : size - 1;
    for (size_t i = 0; i < length; i++)
        out[i] = slice.text[i] >= ' ' && slice.text[i] <= '~' ? slice.text[i] : '?';
    out[length] = 0;
}

char text_eol(const char *begin, const char *end)
{
    for (const char *at = begin; at < end; at++) {
        if (*at == '\n')
            return '\n';
        if (*at == '\r')
            return at + 1 < end && at[1] == '\n' ? '\n' : '\r';
    }
    return '\n';
}

struct slice text_token(const struct text_style *style, const char **at, const char *end)
{
    const char *begin = text_skip_space(style, *at, end), *stop = begin;
    while (stop < end && *stop != style->eol && !text_is_space(style, *stop))
        stop++;
    *at = stop;
    return (struct slice){ begin, (size_t)(stop - begin) };
}

const char *text_line_end(const struct text_style *style, const char *at, const char *end)
{
    const char *eol = at < end ? memchr(at, style->eol, (size_t)(end - at)) : NULL;
    return eol ? eol : end;
}

const char *text_next_line(const struct text_style *style, const char *at, const char *end)
{
    const char *eol = text_line_end(style, at, end);
    return eol < end ? eol + 1 : end;
}

static bool is_comment(const char *at, const char *end)
{
    return *at == '#' || (*at == '/' && at + 1 < end && at[1] == '/');
}

const char *text_next_row(const struct text_style *style, const char *at, const char *end)
{
    while (at < end) {
        const char *first = text_skip_space(style, at, end);
        if (first == end)
            return end;
        if (*first != style->eol && !(style->comments && is_comment(first, end)))
            return first;
        at = text_next_line(style, first, end);
    }
    return end;
}
