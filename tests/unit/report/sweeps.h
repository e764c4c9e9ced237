/* Made-up sweeps for the tests of tables and plots. */
#ifndef TEST_SWEEPS_H
#define TEST_SWEEPS_H

#include "pictures.h"

#include "report/report.h"

#include <stdlib.h>

static inline struct report_row made_row(const char *method, const char *path, double ms,
                                         double error)
{
    return (struct report_row){ .method = method,
                                .path = path,
                                .payload = "",
                                .voronoi = "",
                                .epsilon_scale = 1,
                                .ms = { 15, ms * 0.9, ms * 0.95, ms, ms * 1.05, ms * 1.5 },
                                .error.covered.mean_absolute = error,
                                .error.covered.psnr = INFINITY };
}

static inline struct report_row made_deferred(double overlap, double ms, double error)
{
    struct report_row row = made_row("deferred", "raster", ms, error);
    row.voronoi = "slab";
    row.overlap_asked = overlap;
    row.grouping = (struct stp_grouping){ .groups = 7, .overlap = overlap, .avg_degree = 2.5 };
    return row;
}

/* Two that win, one that is beaten, the baseline, and the reference. */
#define MADE_ROWS 6
static inline struct report made_report(struct report_row rows[MADE_ROWS])
{
    rows[0] = made_row("exact", "compute", 40, 1e-5);
    rows[0].payload = "packed";
    rows[1] = made_deferred(0.4, 20, 7e-3);
    rows[2] = made_deferred(1, 60, 2e-5);
    rows[3] = made_row("two-pass", "raster", 50, 2e-8);
    rows[3].is_baseline = true;
    rows[4] = rows[0];
    rows[4].epsilon_scale = 2;
    rows[4].ms.median = 10;
    rows[4].error.covered.mean_absolute = 0.02;
    rows[5] = made_row("reference", "", 3000, 0);
    rows[5].is_reference = true;
    strcpy(rows[1].picture, "error_2.png");
    return (struct report){ .title = "a <b> & \"c\"",
                            .command = "stipple report scan.ply",
                            .device = "a device",
                            .driver = "a driver",
                            .version = "1.2.3",
                            .width = 640,
                            .height = 480,
                            .splats = 1234,
                            .epsilon = 0.5,
                            .kernel = "parabola",
                            .cull = "none",
                            .rounds = 5,
                            .row = rows,
                            .row_count = MADE_ROWS };
}

/* What a writer writes; to be freed. */
static inline char *written(void (*writer)(FILE *, const struct report *),
                            const struct report *report)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    writer(out, report);
    assert_int_equal(ferror(out), 0);
    assert_int_equal(fclose(out), 0);
    return text;
}

static inline unsigned occurrences(const char *text, const char *word)
{
    unsigned count = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word))
        count++;
    return count;
}

#endif
