/* Prepared splats: discs, or ellipses with normal fields, in canonical order, structure of arrays,
 * owned. */
#ifndef STP_SCENE_SPLATS_H
#define STP_SCENE_SPLATS_H

#include <stipple/scene.h>

struct splats {
    size_t count;
    double origin[3];              /* float32 device positions are position - origin */
    double (*position)[3];         /* absolute */
    float (*normal)[3];            /* unit; (0, 0, 0): unknown, the disc faces the eye */
    float *radius;                 /* > 0 */
    float (*color)[3];             /* NULL: the material's albedo everywhere; linear */
    float *opacity;                /* NULL: 1 everywhere */
    struct stp_phong_splat *phong; /* NULL: circular discs with constant normals; else `normal` is
                                      u x v and `radius` the larger of the two; where the normal is
                                      unknown u is (0, 0, 0) */
    uint16_t *object;              /* NULL: one object */
    uint32_t *input;               /* index in the input, over all objects in order of adding */
    uint8_t *group;                /* NULL: not grouped; in [0, facts.grouping.groups) */
};

/* A plane through the centre of splat id, p, relative to the origin; how it stands is
 * prepare/deferred_bsp.c's. */
struct bsp_node {
    float p[3];
    uint32_t id;
    uint8_t direction;
};

/* ZP 4.2: groups for transparency, each covering the surface; a splat may be in several. */
struct cover_groups {
    unsigned groups;                    /* 0: none were made */
    uint32_t first[STP_MAX_GROUPS + 1]; /* group k is node[first[k]] up to node[first[k + 1]] */
    struct bsp_node *node;              /* a tree a group: prepare/deferred_bsp.h */
    float factor[STP_MAX_GROUPS];       /* of its members' radii */
    uint8_t *home; /* of every splat, the group it was in at first; 255: none */
};

void cover_groups_release(struct cover_groups *groups);
void splats_release(struct splats *splats);

#endif
