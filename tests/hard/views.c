/* Depths, fields of view and places of the eye. */
#include "hard.h"

static const struct stp_render_params no_floor = { .min_splat = -1 };

/* Discs at every scale from 2e-3 to 9e5, each a tenth to a third of its depth wide. */
static void nine_decades(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(60);
    uint32_t seed = o->seed;
    for (int i = 0; i < 60; i++) {
        double z = pow(10, -2.7 + 8.6 * i / 59), wide = 0.25;
        struct vec3 p = v3(z * wide * (2 * hard_random(&seed) - 1),
                           z * wide * (2 * hard_random(&seed) - 1), -z);
        struct vec3 tilt = random_point(&seed, 0.5);
        size_t at = points_add(&cloud, p, v3_unit(v3_add(v3(0, 0, 1), tilt)),
                               z * (0.03 + 0.06 * hard_random(&seed)));
        points_paint(&cloud, at, v3(hard_random(&seed), hard_random(&seed), hard_random(&seed)));
    }
    s->scene = points_scene(&cloud, 1e-4, 2);
    s->camera = plain_camera(o->width, o->height, 1.6 * o->height);
    s->camera.near_depth = 1e-3;
    s->camera.far_depth = 1e6;
    s->params = no_floor;
    points_release(&cloud);
}

static void ball(const struct hard_options *o, struct hard_scene *s, double distance, double fov)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    s->scene = points_scene(&cloud, 0, 2);
    s->camera = hard_look(o, v3(0, 0, 0), distance, fov);
    s->params = no_floor;
    points_release(&cloud);
}

static void infinite_far(const struct hard_options *o, struct hard_scene *s)
{
    ball(o, s, 4.6, 30);
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    s->twin = points_scene(&cloud, 0, 2);
    s->twin_camera = s->camera;
    s->camera.far_depth = INFINITY;
    s->twin_camera.far_depth = 1e9;
    points_release(&cloud);
}

static void orthographic(const struct hard_options *o, struct hard_scene *s)
{
    ball(o, s, 2.5, 0);
}

static void one_degree(const struct hard_options *o, struct hard_scene *s)
{
    ball(o, s, 2.5 / tan(M_PI / 180), 1);
}

static void wide(const struct hard_options *o, struct hard_scene *s)
{
    ball(o, s, 0.4, 170);
    s->camera.near_depth = 1e-3;
}

/* 100 degrees high, and wide pictures no wider than 116, as one of 4 to 3 is. */
static void inside(const struct hard_options *o, struct hard_scene *s)
{
    double narrow = fmin(1, 4.0 / 3 * o->height / o->width);
    ball(o, s, 0.4, 360 / M_PI * atan(tan(5 * M_PI / 18) * narrow));
    s->camera.near_depth = 1e-3;
}

/* Discs that the near plane cuts, at any tilt; some hold the eye within their sphere. */
static void across_near(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(48);
    uint32_t seed = o->seed;
    for (int i = 0; i < 48; i++) {
        struct vec3 p = v3_add(random_point(&seed, 0.6), v3(0, 0, -0.5));
        size_t at =
            points_add(&cloud, p, v3_unit(random_point(&seed, 1)), 0.1 + 0.5 * hard_random(&seed));
        points_paint(&cloud, at, v3(hard_random(&seed), hard_random(&seed), hard_random(&seed)));
    }
    s->scene = points_scene(&cloud, 0.05, 2);
    s->camera = plain_camera(o->width, o->height, o->height / 2.0);
    s->camera.near_depth = 0.2;
    s->params = no_floor;
    points_release(&cloud);
}

static const struct hard_case cases[] = {
    { "Far over near of 1e9",
      "To rounding of the reference: depth is linear and float, so its relative error is 2^-24 "
      "at any scale",
      nine_decades, NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Infinite far",
      "The bits of far = 1e9: the far plane only cuts, and nothing lies between the two",
      infinite_far, NULL, 45, INFINITY, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Orthographic", "To rounding of the reference", orthographic, NULL, 45, 0, 0, 0, NULL,
      HARD_PYRAMID_SURFACE },
    { "A field of view of 1 degree",
      "To rounding: the centre is projected in double, and a pixel is measured from it", one_degree,
      NULL, 45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "A field of view of 170 degrees",
      "To rounding: discs are intersected in perspective, never as affine ellipses", wide, NULL, 45,
      0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "The eye inside the cloud", "To rounding: what lies behind the eye is not seen", inside, NULL,
      45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Splats across the near plane",
      "To rounding: cut at the near plane to the pixel, neither dropped nor stretched", across_near,
      NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_views = { "views", cases, sizeof cases / sizeof *cases };
