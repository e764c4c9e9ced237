#include "report/plot.h"

#include <math.h>

double axis_at(const struct axis *axis, double value)
{
    double share = log(value / axis->low) / log(axis->high / axis->low);
    return axis->from + share * (axis->to - axis->from);
}

/* value = mantissa * 10^decade, for every one of the mantissas. */
static unsigned collect(const struct axis *axis, const double *mantissas, unsigned count,
                        double ticks[AXIS_MAX_TICKS])
{
    unsigned found = 0;
    int last = (int)ceil(log10(axis->high));
    for (int decade = (int)floor(log10(axis->low)); decade <= last; decade++) {
        for (unsigned i = 0; i < count; i++) {
            double value = mantissas[i] * pow(10, decade);
            bool inside = value >= axis->low * (1 - 1e-9) && value <= axis->high * (1 + 1e-9);
            if (inside && found < AXIS_MAX_TICKS)
                ticks[found++] = value;
        }
    }
    return found;
}

unsigned axis_decades(const struct axis *axis, double ticks[AXIS_MAX_TICKS])
{
    return collect(axis, (const double[]){ 1 }, 1, ticks);
}

unsigned axis_ticks(const struct axis *axis, double ticks[AXIS_MAX_TICKS])
{
    static const double coarse[] = { 1, 2, 5 };
    static const double fine[] = { 1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9 };
    unsigned count = axis_decades(axis, ticks);
    if (count < 5)
        count = collect(axis, coarse, 3, ticks);
    if (count < 5)
        count = collect(axis, fine, 11, ticks);
    return count;
}

void svg_text(FILE *out, const char *text)
{
    for (; *text; text++) {
        switch (*text) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        default:
            fputc((unsigned char)*text < 32 ? ' ' : *text, out);
        }
    }
}
