/* The plot's geometry: log axes on a page of pixels. */
#ifndef STP_REPORT_PLOT_H
#define STP_REPORT_PLOT_H

#include "report/report.h"

struct axis {
    double low, high; /* values at the ends */
    double from, to;  /* their pixels */
};
double axis_at(const struct axis *axis, double value);

#define AXIS_MAX_TICKS 24
/* Round values inside the axis, at least four where it can be; returns how many. */
unsigned axis_ticks(const struct axis *axis, double ticks[AXIS_MAX_TICKS]);
/* The powers of ten inside. */
unsigned axis_decades(const struct axis *axis, double ticks[AXIS_MAX_TICKS]);

/* &, <, > and quotes as XML wants them. */
void svg_text(FILE *out, const char *text);

#endif
