/* Scenes and cameras filled by hand for the tests of the reference. */
#ifndef TEST_REFERENCE_FIXTURE_H
#define TEST_REFERENCE_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
#include <cmocka.h>

#include "reference/disc.h"
#include "reference/reference.h"

#define MOST 4096

struct fixture {
    struct stp_scene scene;
    struct scene_object objects[2];
    double position[MOST][3];
    float normal[MOST][3], radius[MOST], color[MOST][3], opacity[MOST];
    uint16_t object[MOST];
    uint32_t input[MOST];
};

/* No splats yet; one object with the default material and epsilon; a head light. */
static inline struct fixture *fixture_create(double epsilon)
{
    struct fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    for (int i = 0; i < 2; i++)
        f->objects[i] = (struct scene_object){ .material = SCENE_DEFAULT_MATERIAL,
                                               .epsilon = epsilon,
                                               .opacity = 1 };
    f->scene.objects = f->objects;
    f->scene.object_count = 2;
    f->scene.light_count = 1;
    f->scene.lights[0] = (struct stp_light){ .at_eye = true, .color = { 1, 1, 1 } };
    f->scene.prepared = true;
    f->scene.splats = (struct splats){
        .position = f->position, .normal = f->normal, .radius = f->radius, .input = f->input
    };
    return f;
}

static inline size_t add_splat(struct fixture *f, struct vec3 p, struct vec3 n, double radius)
{
    size_t i = f->scene.splats.count++;
    assert_true(i < MOST);
    n = v3_unit(n);
    memcpy(f->position[i], (double[3]){ p.x, p.y, p.z }, sizeof f->position[i]);
    memcpy(f->normal[i], (float[3]){ (float)n.x, (float)n.y, (float)n.z }, sizeof f->normal[i]);
    f->radius[i] = (float)radius;
    f->input[i] = (uint32_t)(1000 + i);
    return i;
}

static inline void paint(struct fixture *f, size_t i, float r, float g, float b)
{
    f->scene.splats.color = f->color;
    memcpy(f->color[i], (float[3]){ r, g, b }, sizeof f->color[i]);
}

/* Others stay opaque. */
static inline void fade(struct fixture *f, size_t i, float opacity)
{
    for (size_t k = 0; k < MOST && !f->scene.splats.opacity; k++)
        f->opacity[k] = 1;
    f->scene.splats.opacity = f->opacity;
    f->scene.facts.transparent = true;
    f->opacity[i] = opacity;
}

/* At the origin, looking down -Z. */
static inline struct stp_camera plain_camera(uint32_t width, uint32_t height, double focal)
{
    struct stp_camera c = { .world_to_camera = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 },
                            .fx = focal,
                            .fy = focal,
                            .cx = width / 2.0,
                            .cy = height / 2.0,
                            .width = width,
                            .height = height,
                            .near_depth = 1e-3,
                            .far_depth = INFINITY };
    return c;
}

static inline struct stp_camera flat_camera(uint32_t width, uint32_t height, double focal)
{
    struct stp_camera c = plain_camera(width, height, focal);
    c.orthographic = true;
    return c;
}

static inline void look_at(struct stp_camera *camera, struct vec3 eye, struct vec3 target)
{
    struct vec3 back = v3_unit(v3_sub(eye, target));
    struct vec3 right = v3_unit(v3_cross(v3(0.1, 1, 0.05), back)), up = v3_cross(back, right);
    const struct vec3 row[3] = { right, up, back };
    for (int i = 0; i < 3; i++) {
        double *m = &camera->world_to_camera[4 * i];
        m[0] = row[i].x;
        m[1] = row[i].y;
        m[2] = row[i].z;
        m[3] = -v3_dot(row[i], eye);
    }
}

/* The floor off, as accuracy is measured. */
static inline struct stp_render_params exact_params(void)
{
    return (struct stp_render_params){ .min_splat = -1, .aovs = 127 };
}

static inline struct stp_image *render(struct fixture *f, const struct stp_camera *camera,
                                       const struct stp_render_params *params)
{
    struct stp_env env = { .threads = 2 };
    struct stp_image *image = NULL;
    assert_int_equal(reference_render(&env, &f->scene, camera, params, &image), STP_OK);
    return image;
}

static inline float value(const struct stp_image *image, const char *name, uint32_t x, uint32_t y)
{
    struct stp_channel *channel = stp_image_find(image, name);
    assert_non_null(channel);
    return channel->data.f[(size_t)y * image->width + x];
}

static inline uint32_t id_at(const struct stp_image *image, uint32_t x, uint32_t y)
{
    return stp_image_find(image, "id")->data.u[(size_t)y * image->width + x];
}

static inline void close_to(double actual, double expected, double tolerance)
{
    if (!(fabs(actual - expected) <= tolerance))
        fail_msg("%.12g, expected %.12g within %g", actual, expected, tolerance);
}

static inline double uniform(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state / 4294967296.0;
}

static inline struct vec3 random_point(uint32_t *state, double size)
{
    double x = uniform(state), y = uniform(state), z = uniform(state);
    return v3((2 * x - 1) * size, (2 * y - 1) * size, (2 * z - 1) * size);
}

/* `count` splats in a cube of half side 1: radii over three decades, some without a normal. */
static inline void fill_randomly(struct fixture *f, uint32_t seed, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        struct vec3 p = random_point(&seed, 1), n = random_point(&seed, 1);
        double radius = 0.4 * pow(10, -3 * uniform(&seed));
        size_t s = add_splat(f, p, uniform(&seed) < 0.1 ? v3(0, 0, 0) : n, radius);
        float r = (float)uniform(&seed), g = (float)uniform(&seed), b = (float)uniform(&seed);
        paint(f, s, r, g, b);
    }
}

/* Views of that cube: outside, inside, wide, narrow, near and far cutting, orthographic. */
#define VIEWS 8
static inline struct stp_camera hard_view(int index, uint32_t width, uint32_t height)
{
    static const struct {
        double fov; /* degrees; 0: orthographic */
        struct vec3 eye, target;
        double near_depth, far_depth;
    } view[VIEWS] = {
        { 30, { 2, 3, 5 }, { 0, 0, 0 }, 0.1, INFINITY },
        { 90, { 0.1, 0, 0.2 }, { 1, 0.3, -1 }, 1e-3, INFINITY }, /* inside */
        { 170, { 0, 0, 0.3 }, { 0, 0.2, -1 }, 1e-6, INFINITY },  /* inside, wide */
        { 1, { 60, 30, 90 }, { 0, 0, 0 }, 1, 1000 },
        { 60, { 0, 0, 2 }, { 0.1, 0, 0 }, 1.5, 2.25 }, /* a slice */
        { 120, { 1, 1, 1 }, { 0, 0, 0 }, 0.05, 3 },    /* on the corner */
        { 0, { 2, 3, 5 }, { 0, 0, 0 }, 0.1, INFINITY },
        { 0, { 0.1, 0.2, 0.1 }, { 0, 0, -1 }, -0.4, 0.8 }, /* a slice, eye inside */
    };
    struct stp_camera c = plain_camera(width, height, 1);
    c.orthographic = view[index].fov == 0;
    c.fy = c.orthographic ? height / 2.2 : height / 2.0 / tan(view[index].fov * M_PI / 360);
    c.fx = 1.1 * c.fy; /* pixels need not be square, nor the centre central */
    c.cx += 1.75;
    c.cy -= 0.5;
    c.near_depth = view[index].near_depth;
    c.far_depth = view[index].far_depth;
    look_at(&c, view[index].eye, view[index].target);
    return c;
}

#endif
