/* Prepared splats: circular discs in canonical order, structure of arrays, owned. */
#ifndef STP_SCENE_SPLATS_H
#define STP_SCENE_SPLATS_H

#include <stipple/scene.h>

struct splats {
    size_t count;
    double origin[3];      /* float32 device positions are position - origin */
    double (*position)[3]; /* absolute */
    float (*normal)[3];    /* unit; (0, 0, 0): unknown, the disc faces the eye */
    float *radius;         /* > 0 */
    float (*color)[3];     /* NULL: the material's albedo everywhere; linear */
    float *opacity;        /* NULL: 1 everywhere */
    uint16_t *object;      /* NULL: one object */
    uint32_t *input;       /* index in the input, over all objects in order of adding */
    uint8_t *group;        /* NULL: not grouped; in [0, facts.grouping.groups) */
};

void splats_release(struct splats *splats);

#endif
