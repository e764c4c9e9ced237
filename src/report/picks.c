/* What auto takes for a bound, beside the fastest that the sweep found within it. */
#include "report/report.h"

#include <math.h>
#include <string.h>

#include "base/json.h"

static void number(FILE *out, double value)
{
    char text[JSON_NUMBER_SIZE];
    fprintf(out, ",%s", json_number_text(value, text));
}

static void way(FILE *out, const struct report_row *row)
{
    fprintf(out, ",%s,%s,%s,%s", row->method, row->path, row->payload, row->voronoi);
    if (row->overlap_asked > 0)
        number(out, row->overlap_asked);
    else
        fputc(',', out);
    fprintf(out, ",%s,", row->transparency ? row->transparency : "");
    if (row->peel_layers)
        fprintf(out, "%u", row->peel_layers);
    number(out, row->ms.median);
    number(out, row->ms.quartile1);
    number(out, row->ms.quartile3);
    number(out, row->error.covered.mean_absolute);
}

/* Empty where nothing in the sweep is within the bound. */
static void pick_line(FILE *out, const struct report *report, const struct report_pick *pick)
{
    const struct report_row *best = report_fastest(report, NULL, pick->bound);
    char text[JSON_NUMBER_SIZE];
    fprintf(out, "%s,%d", json_number_text(pick->bound, text), pick->met);
    number(out, pick->ms);
    number(out, pick->error);
    way(out, &report->row[pick->row]);
    if (best)
        way(out, best);
    else
        fputs(",,,,,,,,,,,", out);
    fputc('\n', out);
}

void report_picks_csv(FILE *out, const struct report *report)
{
    fputs("bound,met,predicted_ms,predicted_error", out);
    for (int best = 0; best < 2; best++) {
        static const char *const columns[] = { "method",       "path",    "payload",
                                               "voronoi",      "overlap", "transparency",
                                               "peel_layers",  "ms",      "ms_quartile1",
                                               "ms_quartile3", "error" };
        for (unsigned i = 0; i < sizeof columns / sizeof *columns; i++)
            fprintf(out, ",%s%s", best ? "best_" : "", columns[i]);
    }
    fputc('\n', out);
    for (unsigned i = 0; i < report->pick_count; i++)
        pick_line(out, report, &report->pick[i]);
}

static void pick_row(FILE *out, const struct report *report, const struct report_pick *pick)
{
    const struct report_row *row = &report->row[pick->row];
    const struct report_row *best = report_fastest(report, NULL, pick->bound);
    char name[REPORT_NAME_SIZE], text[REPORT_NUMBER_SIZE];
    fprintf(out, "| %s |", report_number(pick->bound, text));
    fprintf(out, " %s |", report_row_name(row, name));
    fprintf(out, " %s |", report_number(pick->ms, text));
    fprintf(out, " %s |", report_number(row->ms.median, text));
    fprintf(out, " %s%s |", report_number(pick->error, text), pick->met ? "" : ", none is sure");
    fprintf(out, " %s |", report_number(row->error.covered.mean_absolute, text));
    if (!best) {
        fputs(" none | |\n", out);
        return;
    }
    fprintf(out, " %s, %s ms |", best == row ? "the same" : report_row_name(best, name),
            report_number(best->ms.median, text));
    fprintf(out, " %.2f |\n", row->ms.median / best->ms.median);
}

void report_picks_markdown(FILE *out, const struct report *report)
{
    if (!report->pick_count)
        return;
    fputs(
        "## What auto takes\n\nThe way that `--max-error` takes for a bound, as predicted and as "
        "measured here, beside the fastest of the sweep within that bound.\n\n"
        "| bound | taken | ms predicted | ms | error predicted, at most | error | fastest | times "
        "its time |\n|---|---|---|---|---|---|---|---|\n",
        out);
    for (unsigned i = 0; i < report->pick_count; i++)
        pick_row(out, report, &report->pick[i]);
    fputc('\n', out);
}
