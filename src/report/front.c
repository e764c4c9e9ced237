/* Who beats whom: the Pareto front of milliseconds and error, and the rows of equal error or time.
 */
#include "report/report.h"

#include <stdlib.h>
#include <string.h>

double report_error(const struct report_row *row)
{
    double error = row->error.covered.mean_absolute;
    return error > REPORT_ERROR_FLOOR ? error : REPORT_ERROR_FLOOR;
}

/* Of equals the earlier row wins. */
static bool beats(const struct report_row *a, const struct report_row *b)
{
    double ea = report_error(a), eb = report_error(b), ta = a->ms.median, tb = b->ms.median;
    if (ta > tb || ea > eb)
        return false;
    return ta < tb || ea < eb || a < b;
}

bool report_contends(const struct report_row *row)
{
    return !row->is_reference && row->epsilon_scale == 1;
}

void report_find_front(struct report *report)
{
    for (unsigned i = 0; i < report->row_count; i++) {
        struct report_row *row = &report->row[i];
        row->on_front = report_contends(row);
        for (unsigned k = 0; row->on_front && k < report->row_count; k++)
            if (k != i && report_contends(&report->row[k]) && beats(&report->row[k], row))
                row->on_front = false;
    }
}

bool report_outclassed(const struct report *report, const struct report_row *row)
{
    for (unsigned k = 0; k < report->row_count && !row->is_baseline; k++) {
        const struct report_row *other = &report->row[k];
        if (report_contends(other) && report_error(other) <= report_error(row) &&
            REPORT_OUTCLASSED * other->ms.median < row->ms.median)
            return true;
    }
    return false;
}

static int by_time(const void *a, const void *b)
{
    const struct report_row *x = *(const struct report_row *const *)a;
    const struct report_row *y = *(const struct report_row *const *)b;
    return (x->ms.median > y->ms.median) - (x->ms.median < y->ms.median);
}

unsigned report_front(const struct report *report, const struct report_row **front)
{
    unsigned count = 0;
    for (unsigned i = 0; i < report->row_count; i++)
        if (report->row[i].on_front)
            front[count++] = &report->row[i];
    qsort(front, count, sizeof *front, by_time);
    return count;
}

const char *report_kind(const struct report_row *row)
{
    return row->transparency ? row->transparency : row->merge ? row->merge : row->method;
}

static bool contends(const struct report_row *row, const char *kind)
{
    return report_contends(row) && (!kind || strcmp(report_kind(row), kind) == 0);
}

const struct report_row *report_fastest(const struct report *report, const char *kind,
                                        double most_error)
{
    const struct report_row *best = NULL;
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *row = &report->row[i];
        if (contends(row, kind) && report_error(row) <= most_error &&
            (!best || row->ms.median < best->ms.median))
            best = row;
    }
    return best;
}

const struct report_row *report_baseline(const struct report *report)
{
    const struct report_row *best = NULL;
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *row = &report->row[i];
        if (row->is_baseline && (!best || row->ms.median < best->ms.median))
            best = row;
    }
    return best;
}

const struct report_row *report_most_exact(const struct report *report, const char *kind,
                                           double most_ms)
{
    const struct report_row *best = NULL;
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *row = &report->row[i];
        if (contends(row, kind) && row->ms.median <= most_ms &&
            (!best || report_error(row) < report_error(best)))
            best = row;
    }
    return best;
}

unsigned report_kinds(const struct report *report, const char *kinds[REPORT_MAX_KINDS])
{
    unsigned count = 0;
    for (unsigned i = 0; i < report->row_count; i++) {
        unsigned k = 0;
        while (k < count && strcmp(kinds[k], report_kind(&report->row[i])) != 0)
            k++;
        if (k == count && count < REPORT_MAX_KINDS && !report->row[i].is_reference)
            kinds[count++] = report_kind(&report->row[i]);
    }
    return count;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile(const double *sorted, unsigned count, double share)
{
    double at = share * (count - 1);
    unsigned below = (unsigned)at;
    if (below + 1 >= count)
        return sorted[count - 1];
    return sorted[below] + (at - below) * (sorted[below + 1] - sorted[below]);
}

struct report_times report_times(double *ms, unsigned count)
{
    qsort(ms, count, sizeof *ms, by_value);
    return (struct report_times){ count,
                                  ms[0],
                                  quantile(ms, count, 0.25),
                                  quantile(ms, count, 0.5),
                                  quantile(ms, count, 0.75),
                                  ms[count - 1] };
}
