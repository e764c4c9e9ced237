/* Text of a mapped file: slices, lines, and numbers that are right to the last bit in any locale.
 */
#ifndef STP_LOAD_TEXT_H
#define STP_LOAD_TEXT_H

#include <stdbool.h>
#include <stddef.h>

/* Not terminated; points into the file. */
struct slice {
    const char *text;
    size_t length;
};

bool slice_is(struct slice slice, const char *word);         /* exactly */
bool slice_matches(struct slice slice, const char *word);    /* ignoring ASCII case */
void slice_copy(struct slice slice, char *out, size_t size); /* cut to size - 1, printable */

/* Parses one decimal number at *at and steps over it. Accepts a sign, "1.", ".5", exponents with
 * e or d, nan and inf in the spellings of C and of Windows. The nearest double, ties to even; never
 * reads at or past `end`; does not skip space. False: nothing was read, *at is unchanged. */
bool number_read(const char **at, const char *end, double *value);

/* How lines end and what stands between numbers. */
struct text_style {
    char eol;      /* '\n', or '\r' in files of the old Macintosh */
    bool comments; /* lines that begin with # or // are not rows */
    bool lists;    /* comma and semicolon separate too */
};

/* '\r' when the first line ends in a carriage return that no line feed follows. */
char text_eol(const char *begin, const char *end);

static inline bool text_is_space(const struct text_style *style, char c)
{
    return c != style->eol && ((unsigned char)c <= ' ' || (style->lists && (c == ',' || c == ';')));
}

/* Past the separators, not past the end of the line. */
static inline const char *text_skip_space(const struct text_style *style, const char *at,
                                          const char *end)
{
    while (at < end && text_is_space(style, *at))
        at++;
    return at;
}

/* The next token of the line; length 0 at the end of the line. */
struct slice text_token(const struct text_style *style, const char **at, const char *end);

/* The end of the line (at its eol, or at `end`), and the start of the next one. */
const char *text_line_end(const struct text_style *style, const char *at, const char *end);
const char *text_next_line(const struct text_style *style, const char *at, const char *end);

/* The first byte, at or after the line that starts at `at`, of a line that is neither blank nor a
 * comment, past its leading space; `end` when there is none. */
const char *text_next_row(const struct text_style *style, const char *at, const char *end);

#endif
