/* BSK Eq. 2-4: the linear normal field of a splat. */
#ifndef STP_PREPARE_PHONG_FIELD_H
#define STP_PREPARE_PHONG_FIELD_H

#include <stdbool.h>
#include <stddef.h>

/* A sample in the splat's frame: (s, t) its place in the ellipse (Eq. 1), (x, y) its normal with
 * the third coordinate 1. */
struct field_sample {
    double s, t, x, y;
    double weight; /* 1 in the paper */
};

/* The least-squares solution of Eq. 3 and 4; the one of least norm where it is underdetermined (one
 * sample, or nearly one s or t only). field = mean x, alpha, mean y, beta; flat: alpha and beta 0.
 */
void field_fit(const struct field_sample *sample, size_t count, bool flat, double field[4]);

#endif
