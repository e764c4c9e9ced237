/* The minimum enclosing ellipse whose axes lie along x and y. */
#ifndef STP_PREPARE_PHONG_ELLIPSE_H
#define STP_PREPARE_PHONG_ELLIPSE_H

#include <stddef.h>

#define ELLIPSE_TOLERANCE 1e-6

/* The ellipse of least area that holds all points (count >= 1), among those whose semi-axes are at
 * least `floor` > 0: its area is at most 1 + ELLIPSE_TOLERANCE of the least, and every point is in
 * it as double evaluates ((x - cx) / rx)^2 + ((y - cy) / ry)^2 <= 1. */
void ellipse_enclose(const double (*point)[2], size_t count, double floor, double center[2],
                     double radius[2]);

#endif
