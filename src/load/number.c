/* Decimal to double. Up to 2^53 with a power of ten up to 22, both factors are exact and one
 * rounding is the right one (Clinger 1990); everything else goes through strtod on digits alone,
 * which has no decimal point and so does not depend on the locale. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/text.h"

#define EXACT_POWER 22
#define FAST_DIGITS 19
#define KEPT_DIGITS                                                                                \
    800 /* more than the 767 that can decide a rounding; the rest is a sticky digit */
#define EXPONENT_BOUND 100000

struct decimal {
    const char *digits, *stop; /* of the mantissa, dot included */
    uint64_t mantissa;         /* of the first FAST_DIGITS significant digits */
    int significant;           /* digits in it */
    bool cut;                  /* there were more */
    long exponent;             /* value = mantissa * 10^(exponent + scale) unless cut */
    long scale;                /* the exponent as written */
    long fraction;             /* digits after the dot */
};

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static const char *read_mantissa(const char *at, const char *end, struct decimal *d)
{
    bool dot = false, any = false;
    d->digits = at;
    for (; at < end; at++) {
        if (*at == '.' && !dot) {
            dot = true;
            continue;
        }
        if (!is_digit(*at))
            break;
        any = true;
        d->fraction += dot;
        if (d->significant < FAST_DIGITS) {
            d->mantissa = d->mantissa * 10 + (uint64_t)(*at - '0');
            d->significant += d->mantissa != 0;
            d->exponent -= dot;
        } else {
            d->cut = true;
            d->exponent += !dot;
        }
    }
    d->stop = at;
    return any ? at : NULL;
}

static const char *read_exponent(const char *at, const char *end, struct decimal *d)
{
    if (at == end || (*at != 'e' && *at != 'E' && *at != 'd' && *at != 'D'))
        return at;
    const char *digits = at + 1;
    bool negative = digits < end && *digits == '-';
    if (digits < end && (*digits == '-' || *digits == '+'))
        digits++;
    if (digits == end || !is_digit(*digits))
        return at;
    long value = 0;
    for (; digits < end && is_digit(*digits); digits++)
        if (value < EXPONENT_BOUND)
            value = value * 10 + (*digits - '0');
    d->scale = negative ? -value : value;
    return digits;
}

static double slow_value(const struct decimal *d)
{
    char text[KEPT_DIGITS + 32];
    size_t length = 0;
    bool sticky = false;
    long exponent = d->scale - d->fraction;
    for (const char *at = d->digits; at < d->stop; at++) {
        if (*at == '.' || (length == 0 && *at == '0'))
            continue;
        if (length < KEPT_DIGITS) {
            text[length++] = *at;
        } else {
            sticky |= *at != '0';
            exponent++;
        }
    }
    if (sticky) {
        text[length++] = '1';
        exponent--;
    }
    snprintf(text + length, sizeof text - length, "e%ld", exponent);
    return strtod(text, NULL);
}

static double decimal_value(const struct decimal *d)
{
    static const double power[EXACT_POWER + 1] = { 1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };
    long exponent = d->exponent + d->scale;
    if (d->mantissa == 0)
        return 0;
    if (!d->cut && d->mantissa <= (uint64_t)1 << 53) {
        if (exponent >= 0 && exponent <= EXACT_POWER)
            return (double)d->mantissa * power[exponent];
        if (exponent < 0 && exponent >= -EXACT_POWER)
            return (double)d->mantissa / power[-exponent];
    }
    return slow_value(d);
}

/* The rest of a word: letters, digits and the brackets of nan(ind). */
static const char *word_end(const char *at, const char *end)
{
    while (at < end && (is_digit(*at) || *at == '_' || ((*at | 32) >= 'a' && (*at | 32) <= 'z') ||
                        *at == '(' || *at == ')' || *at == '#'))
        at++;
    return at;
}

static const char *read_word(const char *at, const char *end, double *value)
{
    struct slice word = { at, end - at < 3 ? 0 : 3 };
    if (slice_matches(word, "nan"))
        *value = NAN;
    else if (slice_matches(word, "inf"))
        *value = INFINITY;
    else
        return NULL;
    return word_end(at, end);
}

/* 1.#INF, 1.#QNAN, 1.#IND: what the C library of Windows printed. */
static const char *read_windows(const char *at, const char *end, double *value)
{
    if (end - at < 4 || at[0] != '1' || at[1] != '.' || at[2] != '#')
        return NULL;
    *value = end - at >= 6 && slice_matches((struct slice){ at + 3, 3 }, "inf") ? INFINITY : NAN;
    return word_end(at + 2, end);
}

bool number_read(const char **at, const char *end, double *value)
{
    const char *begin = *at;
    bool negative = begin < end && *begin == '-';
    if (begin < end && (*begin == '-' || *begin == '+'))
        begin++;
    struct decimal d = { 0 };
    double magnitude = 0;
    const char *stop = read_mantissa(begin, end, &d);
    if (stop && stop < end && *stop == '#')
        stop = read_windows(begin, end, &magnitude);
    else if (stop) {
        stop = read_exponent(stop, end, &d);
        magnitude = decimal_value(&d);
    } else
        stop = read_word(begin, end, &magnitude);
    if (!stop)
        return false;
    *at = stop;
    *value = negative ? -magnitude : magnitude;
    return true;
}
