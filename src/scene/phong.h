/* Elliptical splats with linear normal fields (BSK 3), one by one: cleaned, compared, moved. */
#ifndef STP_SCENE_PHONG_H
#define STP_SCENE_PHONG_H

#include <stipple/scene.h>

/* u is (0, 0, 0): the disc of the splat's own normal and radius. */
bool phong_is_disc(const struct stp_phong_splat *phong);

/* The same disc as an ellipse. Of a normal that is (0, 0, 0) u is too. */
struct stp_phong_splat phong_of_disc(const float normal[3], float radius);

/* A circle of a constant normal, whole: nothing that a disc could not say. */
bool phong_is_plain(const struct stp_phong_splat *phong);

/* Makes u unit and normal to `normal`, which is unit, and lines that are not used 0. What is so to
 * rounding stays bit for bit; fields above 2^50, and lines above that or below 2^-50, are scaled by
 * a power of two, which they mean the same by. False where that cannot be: something is not finite,
 * an axis is not above 0, there are more than two lines, or u is parallel to the normal. */
bool phong_clean(struct stp_phong_splat *phong, const float normal[3]);

/* By a rotation times `scale`, row-major 4x4. */
void phong_transform(struct stp_phong_splat *phong, const double m[16], double scale);

/* The most of a s + b t over what the splat shows of itself; -INFINITY where its lines leave
 * nothing. */
double phong_support(const struct stp_phong_splat *phong, double a, double b);

/* Bit for bit, padding aside. */
bool phong_equal(const struct stp_phong_splat *a, const struct stp_phong_splat *b);

/* Its bits, two words of 32 at a time: equal splats have equal words. */
#define PHONG_WORDS 8
void phong_word(const struct stp_phong_splat *phong, unsigned word, uint32_t half[2]);

#endif
