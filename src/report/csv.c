/* report.csv: one line a configuration, every figure in full precision (docs/report.md). */
#include "report/report.h"

#include <math.h>
#include <string.h>

#include "base/json.h"

static void number(FILE *out, double value)
{
    char text[JSON_NUMBER_SIZE];
    if (isinf(value))
        fputs(value > 0 ? ",inf" : ",-inf", out);
    else
        fprintf(out, ",%s", json_number_text(value, text));
}

static void grouping(FILE *out, const struct report_row *row)
{
    const struct stp_grouping *g = &row->grouping;
    if (!(row->overlap_asked > 0)) {
        fputs(",,,,,,", out);
        return;
    }
    number(out, row->overlap_asked);
    number(out, g->overlap);
    fprintf(out, ",%u,%u", g->groups, g->max_degree);
    number(out, g->avg_degree);
    number(out, g->milliseconds);
}

static void times(FILE *out, const struct report_times *ms)
{
    fprintf(out, ",%u", ms->frames);
    number(out, ms->median);
    number(out, ms->min);
    number(out, ms->quartile1);
    number(out, ms->quartile3);
    number(out, ms->max);
}

static void color_error(FILE *out, const struct stp_color_error *e)
{
    const double values[] = { e->mean_absolute, e->rmse,       e->psnr,      e->p999,
                              e->maximum,       e->over_1_255, e->over_8_255 };
    for (unsigned i = 0; i < sizeof values / sizeof *values; i++)
        number(out, values[i]);
}

static void other_errors(FILE *out, const struct stp_comparison *e)
{
    const double values[] = { e->depth_mean, e->depth_p999, e->depth_max, e->normal_mean,
                              e->normal_p99, e->normal_max, e->flip,      e->alpha_max };
    fprintf(out, ",%llu", (unsigned long long)e->coverage_differs);
    for (unsigned i = 0; i < sizeof values / sizeof *values; i++)
        number(out, values[i]);
}

/* What only transparent scenes and volumes have. */
static void layering(FILE *out, const struct report_row *row)
{
    fprintf(out, ",%s,", row->transparency ? row->transparency : "");
    if (row->peel_layers)
        fprintf(out, "%u", row->peel_layers);
    fprintf(out, ",%s", row->merge ? row->merge : "");
    if (row->merge && strcmp(row->merge, "blend") == 0)
        number(out, row->axis_h);
    else
        fputc(',', out);
}

static void line(FILE *out, const struct report *report, const struct report_row *row)
{
    fprintf(out, "%s,%s,%s,%s", row->method, row->path, row->payload, row->voronoi);
    layering(out, row);
    grouping(out, row);
    number(out, report->epsilon * row->epsilon_scale);
    times(out, &row->ms);
    color_error(out, &row->error.covered);
    color_error(out, &row->error.all);
    other_errors(out, &row->error);
    fprintf(out, ",%u,%u,%llu,%llu,%d\n", row->pass_count, row->tiles,
            (unsigned long long)row->scene_bytes, (unsigned long long)row->transient_bytes,
            row->on_front);
}

void report_csv(FILE *out, const struct report *report)
{
    fputs("method,path,payload,voronoi,transparency,peel_layers,axis_merge,axis_h,overlap_asked,"
          "overlap,groups,max_degree,avg_degree,"
          "grouping_ms,epsilon,frames,ms_median,ms_min,ms_quartile1,ms_quartile3,ms_max,"
          "mean_absolute,rmse,psnr,p999,maximum,over_1_255,over_8_255,"
          "all_mean_absolute,all_rmse,all_psnr,all_p999,all_maximum,all_over_1_255,"
          "all_over_8_255,coverage_differs,depth_mean,depth_p999,depth_max,normal_mean,"
          "normal_p99,normal_max,flip,alpha_max,passes,tiles,scene_bytes,transient_bytes,front\n",
          out);
    for (unsigned i = 0; i < report->row_count; i++)
        line(out, report, &report->row[i]);
}
