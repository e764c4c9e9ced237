/* Error against the number of samples a pixel, as a table and as a file. */
#include "report/report.h"

#include "base/json.h"

void report_samples_csv(FILE *out, const struct report *report)
{
    fputs("samples,ms_median,ms_min,ms_max,mean_absolute,rmse,psnr,flip,alpha_max\n", out);
    for (unsigned i = 0; i < report->samples_count; i++) {
        const struct report_samples *row = &report->samples[i];
        const double values[] = { row->ms.median,
                                  row->ms.min,
                                  row->ms.max,
                                  row->error.covered.mean_absolute,
                                  row->error.covered.rmse,
                                  row->error.covered.psnr,
                                  row->error.flip,
                                  row->error.alpha_max };
        char text[JSON_NUMBER_SIZE];
        fprintf(out, "%u", row->count);
        for (unsigned k = 0; k < sizeof values / sizeof *values; k++)
            fprintf(out, ",%s", json_number_text(values[k], text));
        fputc('\n', out);
    }
}

void report_samples_markdown(FILE *out, const struct report *report)
{
    char text[REPORT_NUMBER_SIZE];
    if (!report->samples_count)
        return;
    fprintf(out,
            "## Samples\n\n`--samples N` by method exact in %u x %u pixels of the same view, "
            "against the reference's own picture of %u samples a pixel: what is left of the "
            "picture's aliasing, noise of the reference included.\n\n"
            "| samples | ms | mean error | RMSE | PSNR, dB | FLIP |\n|---|---|---|---|---|---|\n",
            report->samples_width, report->samples_height, report->samples_truth);
    for (unsigned i = 0; i < report->samples_count; i++) {
        const struct report_samples *row = &report->samples[i];
        const double values[] = { row->ms.median, row->error.covered.mean_absolute,
                                  row->error.covered.rmse, row->error.covered.psnr,
                                  row->error.flip };
        fprintf(out, "| %u |", row->count);
        for (unsigned k = 0; k < sizeof values / sizeof *values; k++)
            fprintf(out, " %s |", report_number(values[k], text));
        fputc('\n', out);
    }
    fputc('\n', out);
}
