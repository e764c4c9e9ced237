/* Range images made in code, for the tests of ellipsoids. */
#ifndef TEST_REFERENCE_RANGES_H
#define TEST_REFERENCE_RANGES_H

#include "volumes.h"

#include "base/memory.h"
#include "prepare/range.h"
#include "scene/range.h"

/* A camera at `eye` that looks at `target`: x right, y down, z forward. */
static inline struct range_camera range_camera_at(struct vec3 eye, struct vec3 target, double focal,
                                                  uint32_t width, uint32_t height)
{
    struct range_camera c = {
        .fx = focal, .fy = 1.1 * focal, .cx = width / 2.0 + 0.25, .cy = height / 2.0 - 0.5
    };
    struct vec3 z = v3_unit(v3_sub(target, eye)), x = v3_unit(v3_cross(z, v3(0.1, 1, 0.05)));
    struct vec3 y = v3_cross(z, x);
    const double m[16] = { x.x, y.x, z.x, eye.x, x.y, y.y, z.y, eye.y,
                           x.z, y.z, z.z, eye.z, 0,   0,   0,   1 };
    memcpy(c.to_world, m, sizeof m);
    return c;
}

static inline void range_frame_make(struct range_frame *frame, const struct range_camera *camera,
                                    uint32_t width, uint32_t height, double sigma)
{
    *frame = (struct range_frame){ .camera = *camera,
                                   .width = width,
                                   .height = height,
                                   .sensor = { .kind = RANGE_CONSTANT, .sigma = sigma } };
    frame->depth = mem_zalloc((size_t)width * height, sizeof *frame->depth);
    frame->color = mem_zalloc((size_t)width * height, sizeof *frame->color);
    assert_true(frame->depth && frame->color);
}

/* `count` frames around 0 that see noise near it, with holes. */
static inline struct range random_range(uint32_t seed, unsigned count, uint32_t side, double sigma)
{
    static const struct vec3 eyes[] = { { 0.4, 0.2, 3 }, { 2.2, 0.5, 2 }, { -1.5, 1.5, 2.2 } };
    struct range range = { .count = count,
                           .frame = mem_zalloc(count, sizeof *range.frame),
                           .uncertainty = 1 };
    assert_true(range.frame && count <= 3);
    for (unsigned f = 0; f < count; f++) {
        struct range_camera camera = range_camera_at(eyes[f], v3(0, 0, 0), 1.5 * side, side, side);
        range_frame_make(&range.frame[f], &camera, side, side, sigma * (f + 1));
        for (size_t i = 0; i < (size_t)side * side; i++) {
            bool hole = uniform(&seed) < 0.2;
            range.frame[f].depth[i] = hole ? 0 : (float)(2.6 + 0.8 * uniform(&seed));
            for (int k = 0; k < 3; k++)
                range.frame[f].color[i][k] = (float)uniform(&seed);
        }
    }
    return range;
}

/* Takes ownership of the range; prepared. */
static inline struct stp_scene *range_scene(struct range *range)
{
    struct stp_scene *scene = NULL;
    struct stp_env env = { .threads = 2 };
    assert_int_equal(stp_scene_create(&env, &scene), STP_OK);
    assert_int_equal(scene_add_range(&env, scene, range), STP_OK);
    assert_int_equal(stp_scene_prepare(&env, scene, NULL), STP_OK);
    return scene;
}

/* One frame at the origin that looks along -z of the world, y down: as plain_camera does. Every
 * reading at `depth`. */
static inline struct range wall_range(uint32_t width, uint32_t height, double focal, double depth,
                                      double sigma)
{
    struct range range = { .count = 1,
                           .frame = mem_zalloc(1, sizeof *range.frame),
                           .uncertainty = 1 };
    const struct range_camera camera = { .fx = focal,
                                         .fy = focal,
                                         .cx = width / 2.0,
                                         .cy = height / 2.0,
                                         .to_world = { 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0,
                                                       0, 1 } };
    assert_non_null(range.frame);
    range_frame_make(range.frame, &camera, width, height, sigma);
    for (size_t i = 0; i < (size_t)width * height; i++) {
        range.frame->depth[i] = (float)depth;
        range.frame->color[i][0] = 0.25f;
        range.frame->color[i][1] = 0.5f;
        range.frame->color[i][2] = (float)(i % width) / (float)width;
    }
    return range;
}

#endif
