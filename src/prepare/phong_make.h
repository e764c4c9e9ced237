/* One patch to one splat: BSK Eq. 1-4. */
#ifndef STP_PREPARE_PHONG_MAKE_H
#define STP_PREPARE_PHONG_MAKE_H

#include "prepare/phong_cover.h"
#include "prepare/phong_field.h"

struct splat_maker {
    const struct fit_cloud *cloud;
    const struct patch_set *set;
    struct splats *splats;
    double tolerance;
    bool flat;          /* constant fields */
    double (*point)[2]; /* of the patch at hand, a worker's own */
    struct field_sample *sample;
};

/* Splat `at` of the patch of that number. */
void splat_make(const struct splat_maker *m, size_t at);

/* A disc of the sample's own radius and normal. */
void splat_single(const struct splat_maker *m, uint32_t sample, const float n[3], size_t at);

#endif
