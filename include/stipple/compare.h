/* Error of one picture against another (docs/accuracy.md). */
#ifndef STIPPLE_COMPARE_H
#define STIPPLE_COMPARE_H

#include <stipple/image.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Over linear premultiplied RGB, peak 1. */
struct stp_color_error {
    uint64_t pixels;
    double mean_absolute, rmse, psnr; /* psnr is INFINITY for equal pictures */
    double p999, maximum;             /* of the pixel's largest channel difference */
    double over_1_255, over_8_255;    /* shares of pixels */
};

struct stp_compare_params {
    double epsilon;           /* scene units; 0: depth errors are absolute */
    double exposure;          /* stops, before FLIP */
    double pixels_per_degree; /* of FLIP; 0: 67 */
};

struct stp_comparison {
    struct stp_color_error covered; /* over pixels with alpha > 0 in either: what every bar means */
    struct stp_color_error all;
    uint64_t coverage_differs;                  /* pixels */
    double depth_mean, depth_p999, depth_max;   /* over epsilon; where both are finite */
    double normal_mean, normal_p99, normal_max; /* degrees */
    double flip;                                /* LDR-FLIP, mean */
    double alpha_max;                           /* largest difference of alpha */
};

/* Both need R G B; A, Z and N are compared where both have them. NaN in any of these, or Inf in any
 * but Z, is STP_ERROR_FORMAT with a line that says where. */
STP_API enum stp_result stp_compare(const struct stp_env *env, const struct stp_image *image,
                                    const struct stp_image *reference,
                                    const struct stp_compare_params *params,
                                    struct stp_comparison *comparison);

#ifdef __cplusplus
}
#endif
#endif
