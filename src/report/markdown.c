/* report.md: the plot, the front, equal error, equal time, where the baseline wins, and all rows.
 */
#include "report/report.h"

#include <limits.h>
#include <math.h>
#include <string.h>

static const char *num(double value, char text[REPORT_NUMBER_SIZE])
{
    return report_number(value, text);
}

/* Cells of a table that hold a figure each. */
static void cells(FILE *out, const double *values, unsigned count)
{
    char text[REPORT_NUMBER_SIZE];
    for (unsigned i = 0; i < count; i++)
        fprintf(out, " %s |", num(values[i], text));
    fputc('\n', out);
}

/* What only splats of surfaces have. */
static void surface(FILE *out, const struct report *report)
{
    char epsilon[REPORT_NUMBER_SIZE], floor[REPORT_NUMBER_SIZE];
    fprintf(out, ", epsilon %s, kernel %s, culling %s, screen-space floor %s pixels",
            num(report->epsilon, epsilon), report->kernel, report->cull,
            num(report->min_splat, floor));
}

static void timing(FILE *out, const struct report *report)
{
    unsigned most = 0, least = UINT_MAX;
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *row = &report->row[i];
        if (row->is_reference)
            continue;
        most = row->ms.frames > most ? row->ms.frames : most;
        least = row->ms.frames < least ? row->ms.frames : least;
    }
    fprintf(
        out,
        "Milliseconds are from record to fence with the scene resident, medians of %u frames in "
        "%u round%s: every configuration in turns, in another order each round, the first frame "
        "of each visit thrown away; in brackets the quartiles. ",
        most, report->rounds, report->rounds == 1 ? "" : "s");
    if (least < most)
        fprintf(
            out,
            "What something at least as exact beat by more than %u times in the first round has "
            "the %u frames of that one. ",
            REPORT_OUTCLASSED, least);
}

static void heading(FILE *out, const struct report *report)
{
    fprintf(out, "# Speed against error: %s\n\n", report->title);
    if (report->command)
        fprintf(out, "Made by\n\n    %s\n\n", report->command);
    fprintf(out, "stipple %s on %s (%s); %zu %s, %u x %u pixels", report->version, report->device,
            report->driver, report->splats, report_splats(report), report->width, report->height);
    if (!report->is_volume)
        surface(out, report);
    fputs(". ", out);
    timing(out, report);
    fprintf(out,
            "Errors are those of "
            "`stipple compare` against the float64 reference of the same camera, over covered "
            "pixels. The sweep took %.0f s.\n\n",
            report->seconds);
    fputs("![milliseconds against error](report.svg)\n\n", out);
}

static void time_cell(FILE *out, const struct report_row *row)
{
    char a[REPORT_NUMBER_SIZE], b[REPORT_NUMBER_SIZE], c[REPORT_NUMBER_SIZE];
    fprintf(out, " %s (%s to %s) |", num(row->ms.median, a), num(row->ms.quartile1, b),
            num(row->ms.quartile3, c));
}

static void error_row(FILE *out, const struct report_row *row)
{
    char name[REPORT_NAME_SIZE];
    const struct stp_comparison *e = &row->error;
    const double values[] = {
        e->covered.mean_absolute,    e->covered.psnr, e->covered.p999, 100 * e->covered.over_1_255,
        (double)e->coverage_differs, e->depth_mean,   e->normal_mean,  e->flip
    };
    fprintf(out, "| %s%s |", report_row_name(row, name), row->on_front ? " **front**" : "");
    time_cell(out, row);
    cells(out, values, 8);
}

static void error_head(FILE *out)
{
    fputs("| configuration | ms (quartiles) | mean error | PSNR, dB | p99.9 | over 1/255, % | "
          "coverage, px | depth/epsilon | normal, deg | FLIP |\n"
          "|---|---|---|---|---|---|---|---|---|---|\n",
          out);
}

static void front(FILE *out, const struct report *report)
{
    const struct report_row *rows[REPORT_MAX_ROWS];
    unsigned count = report_front(report, rows);
    fputs("## The front\n\nNo other configuration is both faster and more exact than one of these. "
          "Mean errors below 6e-8, half a step of float32, count as equal.\n\n",
          out);
    error_head(out);
    for (unsigned i = 0; i < count; i++)
        error_row(out, rows[i]);
    fputc('\n', out);
}

static void kind_head(FILE *out, const struct report *report, const char *first)
{
    const char *kinds[REPORT_MAX_KINDS];
    unsigned count = report_kinds(report, kinds);
    fprintf(out, "| %s |", first);
    for (unsigned i = 0; i < count; i++)
        fprintf(out, " %s |", kinds[i]);
    fputs("\n|---|", out);
    for (unsigned i = 0; i < count; i++)
        fputs("---|", out);
    fputc('\n', out);
}

/* The row's name without its kind, which the column says. */
static const char *rest_of_name(const struct report_row *row, char name[REPORT_NAME_SIZE])
{
    const char *rest = report_row_name(row, name) + strlen(report_kind(row));
    return *rest == ' ' ? rest + 1 : rest;
}

static void equal_cell(FILE *out, const struct report_row *row, bool best, bool wants_ms)
{
    char name[REPORT_NAME_SIZE], text[REPORT_NUMBER_SIZE];
    if (!row) {
        fputs(" - |", out);
        return;
    }
    const char *mark = best ? "**" : "";
    if (wants_ms)
        fprintf(out, " %s%s ms%s, ", mark, num(row->ms.median, text), mark);
    else
        fprintf(out, " %s%s%s, ", mark, num(row->error.covered.mean_absolute, text), mark);
    fprintf(out, "%s |", rest_of_name(row, name));
}

static void equal_error(FILE *out, const struct report *report)
{
    static const double bounds[] = { 3e-2, 1e-2, 1.0 / 255, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7 };
    const char *kinds[REPORT_MAX_KINDS];
    char text[REPORT_NUMBER_SIZE];
    unsigned count = report_kinds(report, kinds);
    fputs("## Equal error\n\nThe fastest configuration of each kind with at most this mean error; "
          "the fastest of all in bold.\n\n",
          out);
    kind_head(out, report, "mean error at most");
    for (unsigned b = 0; b < sizeof bounds / sizeof *bounds; b++) {
        const struct report_row *best = report_fastest(report, NULL, bounds[b]);
        fprintf(out, "| %s |", bounds[b] == 1.0 / 255 ? "1/255" : num(bounds[b], text));
        for (unsigned i = 0; i < count; i++) {
            const struct report_row *row = report_fastest(report, kinds[i], bounds[b]);
            equal_cell(out, row, row && row == best, true);
        }
        fputc('\n', out);
    }
    fputc('\n', out);
}

static void equal_time(FILE *out, const struct report *report)
{
    const char *kinds[REPORT_MAX_KINDS];
    char name[REPORT_NAME_SIZE], text[REPORT_NUMBER_SIZE];
    unsigned count = report_kinds(report, kinds);
    fputs("## Equal time\n\nThe least mean error of each kind within the time of one "
          "configuration: of the fastest of every kind, and of the most exact.\n\n",
          out);
    kind_head(out, report, "within the time of");
    for (unsigned m = 0; m < 2 * count; m++) {
        const char *kind = kinds[m / 2];
        const struct report_row *of = m % 2 ? report_most_exact(report, kind, INFINITY)
                                            : report_fastest(report, kind, INFINITY);
        if (!of || (m % 2 && of == report_fastest(report, kind, INFINITY)))
            continue;
        fprintf(out, "| %s, %s ms |", report_row_name(of, name), num(of->ms.median, text));
        const struct report_row *best = report_most_exact(report, NULL, of->ms.median);
        for (unsigned i = 0; i < count; i++) {
            const struct report_row *row = report_most_exact(report, kinds[i], of->ms.median);
            equal_cell(out, row, row && row == best, false);
        }
        fputc('\n', out);
    }
    fputc('\n', out);
}

static void against_baseline(FILE *out, const struct report *report)
{
    char name[REPORT_NAME_SIZE], text[REPORT_NUMBER_SIZE], ratio[REPORT_NUMBER_SIZE];
    const struct report_row *base = report_baseline(report);
    if (!base)
        return;
    unsigned slower = 0, contenders = 0;
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *row = &report->row[i];
        if (!report_contends(row) || row->is_baseline)
            continue;
        contenders++;
        slower += row->ms.median >= base->ms.median;
    }
    fprintf(out,
            "## Where the baseline wins\n\nThe baseline is %s: %s ms. Of the "
            "other %u configurations %u are slower than it",
            report_row_name(base, name), num(base->ms.median, text), contenders, slower);
    if (!slower) {
        fputs(".\n\n", out);
        return;
    }
    fputs(":\n\n| configuration | times the baseline | mean error, baseline's in brackets |\n"
          "|---|---|---|\n",
          out);
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *row = &report->row[i];
        if (!report_contends(row) || row->is_baseline || row->ms.median < base->ms.median)
            continue;
        fprintf(out, "| %s | %s |", report_row_name(row, name),
                num(row->ms.median / base->ms.median, ratio));
        fprintf(out, " %s", num(row->error.covered.mean_absolute, text));
        fprintf(out, " (%s) |\n", num(base->error.covered.mean_absolute, text));
    }
    fputc('\n', out);
}

static void all_rows(FILE *out, const struct report *report)
{
    fputs("## All configurations\n\n", out);
    error_head(out);
    for (unsigned i = 0; i < report->row_count; i++)
        error_row(out, &report->row[i]);
    fputs("\nThe reference's one frame is timed on the CPU. report.csv has every figure.\n\n", out);
}

static bool first_of_overlap(const struct report *report, unsigned index)
{
    for (unsigned i = 0; i < index; i++)
        if (report->row[i].overlap_asked == report->row[index].overlap_asked)
            return false;
    return report->row[index].overlap_asked > 0;
}

static void groupings(FILE *out, const struct report *report)
{
    char text[3][REPORT_NUMBER_SIZE];
    bool any = false;
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *row = &report->row[i];
        const struct stp_grouping *g = &row->grouping;
        if (!first_of_overlap(report, i))
            continue;
        if (!any)
            fputs(
                "## Grouping\n\n| c | used | groups K | largest degree | average degree | ms, once "
                "|\n|---|---|---|---|---|---|\n",
                out);
        any = true;
        fprintf(out, "| %.3g | %s | %u | %u | %s | %s |\n", row->overlap_asked,
                num(g->overlap, text[0]), g->groups, g->max_degree, num(g->avg_degree, text[1]),
                num(g->milliseconds, text[2]));
    }
    if (any)
        fputc('\n', out);
}

static void passes_of(FILE *out, const struct report_row *row)
{
    char name[REPORT_NAME_SIZE], text[REPORT_NUMBER_SIZE];
    fprintf(out, "| %s | %llu + %llu |", report_row_name(row, name),
            (unsigned long long)(row->scene_bytes >> 20),
            (unsigned long long)(row->transient_bytes >> 20));
    const char *separator = " ";
    for (unsigned i = 0; i < row->pass_count && i < STP_MAX_PASSES; i++) {
        if (row->pass[i].milliseconds < 0.01 * row->ms.median)
            continue;
        fprintf(out, "%s%s %s", separator, row->pass[i].name, num(row->pass[i].milliseconds, text));
        separator = ", ";
    }
    fputs(" |\n", out);
}

static void passes(FILE *out, const struct report *report)
{
    fputs(
        "## Passes\n\nMedians of a few frames with a full barrier after every pass, milliseconds; "
        "passes under 1 % of the frame are left out. MiB are of the scene and of transient images "
        "and buffers.\n\n| configuration | MiB | passes |\n|---|---|---|\n",
        out);
    for (unsigned i = 0; i < report->row_count; i++)
        if (report->row[i].pass_count && report->row[i].pass[0].name[0])
            passes_of(out, &report->row[i]);
    fputc('\n', out);
}

static void pictures(FILE *out, const struct report *report)
{
    const struct report_row *rows[REPORT_MAX_ROWS];
    char name[REPORT_NAME_SIZE];
    unsigned count = report_front(report, rows);
    fprintf(
        out,
        "## Error pictures of the front\n\nThe largest channel difference of a pixel, averaged "
        "where the picture is reduced. One scale for all: the bar at the foot of each runs from "
        "%g (and less) at the left to %g (and more) at the right, logarithmic; 1/255 is at %.0f "
        "%% of it. Grey: nothing there.\n\n",
        HEAT_LOW, HEAT_HIGH, 100 * log(1 / 255.0 / HEAT_LOW) / log(HEAT_HIGH / HEAT_LOW));
    for (unsigned i = 0; i < count; i++)
        if (rows[i]->picture[0])
            fprintf(out, "%s\n\n![error of %s](%s)\n\n", report_row_name(rows[i], name), name,
                    rows[i]->picture);
}

static void skips(FILE *out, const struct report *report)
{
    if (!report->skip_count)
        return;
    fputs("## Left out\n\nWhat does not apply to this scene or device:\n\n", out);
    for (unsigned i = 0; i < report->skip_count; i++)
        fprintf(out, "- %s: %s\n", report->skip[i].name, report->skip[i].why);
}

void report_markdown(FILE *out, const struct report *report)
{
    heading(out, report);
    front(out, report);
    equal_error(out, report);
    equal_time(out, report);
    report_picks_markdown(out, report);
    report_samples_markdown(out, report);
    against_baseline(out, report);
    all_rows(out, report);
    groupings(out, report);
    passes(out, report);
    pictures(out, report);
    skips(out, report);
}
