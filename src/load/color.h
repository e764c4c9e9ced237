/* Colours and opacities as files store them, to linear floats; and scalars to colours. */
#ifndef STP_LOAD_COLOR_H
#define STP_LOAD_COLOR_H

#include <stipple/scene.h>

/* How a column stores a component. */
enum scale {
    SCALE_LINEAR = 0, /* exactly what is wanted: prepared files */
    SCALE_BYTE,       /* 0..255, whole for certain: a binary file */
    SCALE_UINT8,      /* 0..255, unless the text holds fractions */
    SCALE_INTEGER,    /* 8 bits when nothing is above 255, else 16, else 32 */
    SCALE_FLOAT,      /* 0..1 and above, unless the values are plainly 0..255 */
    SCALE_TEXT,       /* no type was declared: whole numbers above 1 are integers, else floats */
};

double color_from_srgb(double encoded); /* IEC 61966-2-1; odd about 0, continued above 1 */

/* In place, raw to linear. */
void color_decode(const struct stp_env *env, const char *path, float (*color)[3], size_t count,
                  enum scale scale, enum stp_transfer transfer);

/* In place, raw to 0..1; true when every integer opacity is 0, which means that the writer never
 * set it. */
bool opacity_decode(const struct stp_env *env, const char *path, float *opacity, size_t count,
                    enum scale scale);

/* A ramp of even steps in Oklab over the 1st to the 99th percentile of the finite values; what is
 * not finite is grey. */
enum stp_result color_ramp(const struct stp_env *env, const float *value, size_t count,
                           float (*color)[3]);
void color_ramp_at(double t, float color[3]); /* t in [0, 1] */

/* The 1st and 99th percentiles (nearest rank); false when no value is finite. `tally` holds 65536
 * entries. */
bool color_percentiles(const float *value, size_t count, size_t *tally, float bounds[2]);

/* A colour per class, neighbours far apart; negative classes are grey. */
void color_classes(const struct stp_env *env, const float *value, size_t count, float (*color)[3]);
void color_class_at(double value, float color[3]);

#endif
