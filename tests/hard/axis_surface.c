/* Surfaces as flat Gaussians in the order of axis lists, where that is hard: the views of axis.c,
 * and splats of every shape. Planes cross at random and colours are random, so that every exchange
 * of two splats shows. */
#include "ellipses.h"
#include "hard.h"

#define SPLATS 160

/* Discs about 0 of many sizes; `least` is the least opacity: 1: opaque. */
static struct hard_points discs(const struct hard_options *o, double least)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    for (int i = 0; i < SPLATS; i++) {
        struct vec3 p = random_point(&seed, 0.9), n = v3_unit(random_point(&seed, 1));
        size_t at = points_add(&cloud, p, n, 0.5 * pow(10, -1.2 * hard_random(&seed)));
        points_paint(&cloud, at, hard_color(&seed));
        if (least < 1)
            points_fade(&cloud, at, least + (1 - least) * hard_random(&seed));
    }
    return cloud;
}

/* Seen as the caller says next. */
static void show(const struct hard_options *o, struct hard_scene *s, struct hard_points cloud,
                 double min_splat)
{
    hard_show(s, &cloud, plain_camera(o->width, o->height, o->height), min_splat);
}

static void two_axes(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 1), -1);
    hard_axis_from(o, s, v3(2.6, 0, 2.6), false);
}

static void three_axes(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 0.2), -1);
    hard_axis_from(o, s, v3(2.2, -2.2, 2.2), false);
}

static void two_axes_everywhere(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 0.2), -1);
    hard_axis_from(o, s, v3(-3, 1, 3), true);
}

static void three_axes_everywhere(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 1), -1);
    hard_axis_from(o, s, v3(3, 3, 3), true);
}

static void all_share(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 1), -1);
    hard_axis_look(o, s, -1);
    s->truth[1] = 3;
}

static void hardly_any_share(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 1), -1);
    hard_axis_look(o, s, 0.99);
}

static void six_walks(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 0.1), -1);
    hard_axis_wide(o, s);
}

static void inside(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 1), -1);
    hard_axis_inside(o, s);
}

static void orthographic(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 1), -1);
    hard_axis_flat(o, s);
}

static void half_see_through(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, discs(o, 5e-5), -1); /* some are too faint for any fragment, or for their rim */
    hard_axis_look(o, s, 0);
}

static void one_splat(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(1);
    points_paint(&cloud, points_add(&cloud, v3(0, 0, 0), v3(0.3, 0.5, 1), 0.8), v3(1, 0.5, 0.25));
    show(o, s, cloud, -1);
    hard_axis_look(o, s, 0);
}

/* Ellipses with fields and clip lines. */
static void cut(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = discs(o, 1);
    uint32_t seed = o->seed + 1;
    for (size_t i = 0; i < cloud.count; i++) {
        double large = (double)cloud.radius[i], flat = large * pow(10, -1.5 * hard_random(&seed));
        struct stp_phong_splat *e = points_bend(&cloud, i, 7 * hard_random(&seed), large, flat);
        random_field(&seed, 0.8, e);
        random_clips(&seed, e);
    }
    show(o, s, cloud, -1);
    hard_axis_look(o, s, 0);
}

/* Ellipses of aspects from 1 to 10^6; `large` is the larger semi-axis, or, where `thin`, the
 * lesser.
 */
static struct hard_points needles(const struct hard_options *o, double place, double large,
                                  bool thin)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    for (int i = 0; i < SPLATS; i++) {
        struct vec3 p = random_point(&seed, place), n = v3_unit(random_point(&seed, 1));
        double aspect = pow(10, i % 7), u = thin ? large * aspect : large;
        size_t at = points_add(&cloud, p, n, u);
        random_field(&seed, 0.5, points_bend(&cloud, at, 7 * hard_random(&seed), u, u / aspect));
        points_paint(&cloud, at, hard_color(&seed));
    }
    return cloud;
}

/* Lines of three pixels, by the floor. */
static void needles_floored(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, needles(o, 0.9, 0.6, false), 3);
    hard_axis_look(o, s, 0);
}

/* Some pixels wide, and as long as a million of that: ribbons through the picture. */
static void ribbons(const struct hard_options *o, struct hard_scene *s)
{
    show(o, s, needles(o, 0.9, 0.1, true), -1);
    hard_axis_flat(o, s);
    s->camera.near_depth = -1e6;
}

#define BORDER                                                                                     \
    "compute and rasteriser: every ray is its lists' order to rounding, and blend is the same "    \
    "picture a millionth of a radian aside"

static const struct hard_case cases[] = {
    { .name = "The border of two axes", .outcome = "Opaque: " BORDER, .make = two_axes },
    { .name = "The border of three axes",
      .outcome = "As above; transparent, so not divided by what is covered",
      .make = three_axes },
    { .name = "All rays on the border of two axes",
      .outcome = "As above; clip takes for each ray the list of one of the two",
      .make = two_axes_everywhere },
    { .name = "All rays on the border of three axes",
      .outcome = "As above, opaque, one of the three",
      .make = three_axes_everywhere },
    { .name = "h = 0", .outcome = "To rounding; three lists, all of weight", .make = all_share },
    { .name = "h = 0.99",
      .outcome = "To rounding, though weights go from 0 to 1 within a hundredth",
      .make = hardly_any_share },
    { .name = "170 degrees from inside",
      .outcome = "To rounding; six walks: each axis with both signs",
      .make = six_walks },
    { .name = "The eye inside",
      .outcome = "To rounding; what is nearer than the near plane is not there",
      .make = inside },
    { .name = "Orthographic", .outcome = "To rounding", .make = orthographic },
    { .name = "Opacities from nearly 0 to 1",
      .outcome = "To rounding; fragments below 1e-4 are left out",
      .make = half_see_through },
    { .name = "One splat", .outcome = "To rounding; the same by every merge", .make = one_splat },
    { .name = "Clip lines",
      .outcome = "To rounding: ellipses with fields, lit at their centres, cut by their lines",
      .make = cut },
    { .name = "Ellipses of 1 to 10^6 : 1, floored",
      .outcome = "To rounding: lines as wide as the floor",
      .make = needles_floored },
    { .name = "Ribbons of 1 to 10^6 : 1",
      .outcome = "To rounding, all through the picture",
      .make = ribbons },
};
const struct hard_family hard_axis_surface = { "axis_surface", cases,
                                               sizeof cases / sizeof *cases };
