/* Shared by the metrics of stp_compare. */
#ifndef STP_REPORT_METRICS_H
#define STP_REPORT_METRICS_H

#include <stipple/compare.h>

/* The R G B planes of both pictures, of one size. */
struct color_pair {
    uint32_t width, height;
    const float *image[3], *reference[3];
};

/* A list of values >= 0, and what is made of it. */
struct samples {
    double *value;
    size_t count;
};

double samples_mean(const struct samples *samples);
double samples_max(const struct samples *samples);
/* Exact, by nearest rank: the ceil(count * permille / 1000)-th smallest; 0 of none. */
double samples_permille(const struct samples *samples, unsigned permille);

/* metrics_flip.c: mean LDR-FLIP of linear colours after an exposure in stops. */
enum stp_result flip_mean(const struct stp_env *env, const struct color_pair *pair, double exposure,
                          double pixels_per_degree, double *mean);

#endif
