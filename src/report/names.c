/* How configurations and figures are printed, alike in tables and plots. */
#include "report/report.h"

#include <math.h>
#include <string.h>

static void append(char *name, const char *separator, const char *word)
{
    size_t used = strlen(name);
    if (*word)
        snprintf(name + used, REPORT_NAME_SIZE - used, "%s%s", separator, word);
}

const char *report_row_name(const struct report_row *row, char name[REPORT_NAME_SIZE])
{
    char part[48];
    snprintf(name, REPORT_NAME_SIZE, "%s", report_kind(row));
    append(name, " ", row->path);
    if (row->peel_layers) {
        snprintf(part, sizeof part, "%u layer%s", row->peel_layers,
                 row->peel_layers > 1 ? "s" : "");
        append(name, ", ", part);
    }
    if (row->merge && strcmp(row->merge, "blend") == 0) {
        snprintf(part, sizeof part, "h %.3g", row->axis_h);
        append(name, ", ", part);
    }
    if (row->overlap_asked > 0) {
        snprintf(part, sizeof part, "c %.3g", row->overlap_asked);
        append(name, ", ", part);
    }
    if (*row->voronoi) {
        snprintf(part, sizeof part, "Voronoi %s", row->voronoi);
        append(name, ", ", part);
    }
    append(name, ", ", row->payload);
    if (row->epsilon_scale != 1) {
        snprintf(part, sizeof part, "epsilon x %.3g", row->epsilon_scale);
        append(name, ", ", part);
    }
    return name;
}

const char *report_number(double value, char text[REPORT_NUMBER_SIZE])
{
    double size = fabs(value);
    if (isinf(value))
        snprintf(text, REPORT_NUMBER_SIZE, value > 0 ? "inf" : "-inf");
    else if (size == 0)
        snprintf(text, REPORT_NUMBER_SIZE, "0");
    else if (size >= 1e5 || size < 1e-3)
        snprintf(text, REPORT_NUMBER_SIZE, "%.2e", value);
    else
        snprintf(text, REPORT_NUMBER_SIZE, "%.*f",
                 size >= 1000  ? 0
                 : size >= 100 ? 1
                 : size >= 1   ? 2
                               : 4,
                 value);
    return text;
}

const char *report_splats(const struct report *report)
{
    bool one = report->splats == 1;
    if (report->is_volume)
        return one ? "kernel" : "kernels";
    return one ? "splat" : "splats";
}
