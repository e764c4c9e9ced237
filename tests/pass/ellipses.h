/* Random ellipses, fields and clip lines for the tests of the passes. */
#ifndef TEST_ELLIPSES_H
#define TEST_ELLIPSES_H

#include "device.h"

static inline void store(struct vec3 v, float out[3])
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* u at `angle` in the normal's plane. */
static inline struct stp_phong_splat ellipse_across(const float normal[3], double angle,
                                                    double radius_u, double radius_v)
{
    struct stp_phong_splat p = { .radius = { (float)radius_u, (float)radius_v } };
    struct vec3 n = v3_unit(v3_loadf(normal));
    struct vec3 a = v3_unit(v3_cross(n, fabs(n.x) < 0.7 ? v3(1, 0, 0) : v3(0, 1, 0)));
    struct vec3 b = v3_cross(n, a);
    store(v3_add(v3_scale(a, cos(angle)), v3_scale(b, sin(angle))), p.u);
    return p;
}

/* Of the splat's normal as it is stored. */
static inline struct stp_phong_splat ellipse(const struct stp_scene *scene, size_t i, double angle,
                                             double radius_u, double radius_v)
{
    return ellipse_across(scene->splats.normal[i], angle, radius_u, radius_v);
}

static inline void random_field(uint32_t *seed, double size, struct stp_phong_splat *p)
{
    for (int k = 0; k < 4; k++)
        p->field[k] = (float)((2 * uniform(seed) - 1) * size);
}

static inline void random_clips(uint32_t *seed, struct stp_phong_splat *p)
{
    p->clips = (uint8_t)(3 * uniform(seed));
    p->reflex = p->clips == 2 && uniform(seed) < 0.5;
    for (int k = 0; k < p->clips; k++) {
        double angle = 2 * M_PI * uniform(seed);
        p->clip[k][0] = (float)cos(angle);
        p->clip[k][1] = (float)sin(angle);
        p->clip[k][2] = (float)(0.8 * uniform(seed) - 0.2);
    }
}

/* As scene_random, with discs, ellipses, fields and clip lines among each other. */
static inline struct stp_scene *random_scene(uint32_t seed, size_t count, bool clips)
{
    struct stp_scene *scene = scene_make(count, 1, 0.05);
    for (size_t i = 0; i < count; i++) {
        struct vec3 p = random_point(&seed, 1), n = random_point(&seed, 1);
        double radius = 0.4 * pow(10, -2 * uniform(&seed)), kind = uniform(&seed);
        double flat = radius * pow(10, -1.5 * uniform(&seed));
        size_t at = scene_add(scene, p, kind < 0.1 ? v3(0, 0, 0) : n, radius);
        if (!clips) /* packed layers have no room for colours */
            scene_paint(scene, at, (float)uniform(&seed), 0.5f, (float)uniform(&seed));
        if (kind < 0.2)
            continue;
        bool along = uniform(&seed) < 0.5;
        struct stp_phong_splat e =
            ellipse(scene, at, 7 * uniform(&seed), along ? radius : flat, along ? flat : radius);
        random_field(&seed, 0.8, &e);
        if (clips)
            random_clips(&seed, &e);
        scene_bend(scene, at, &e);
    }
    scene_finish(scene);
    return scene;
}

#endif
