/* The order of axis lists where it is hard: rays on the borders between axes, lists that all or
 * hardly any share, six walks, kernels of every shape. Random colours and opacities, so that every
 * exchange of two kernels shows. */
#include "hard.h"
#include "volumes.h"

#define TURN 1e-6 /* radians to the other side of a border */

static const double even[3] = { 0.2, 0.2113,
                                0.1871 }; /* no two kernels equally far along a diagonal */

/* What is random of it comes from the seed: values, and where the grid lies amid its voxels. */
static void volume(const struct hard_options *o, struct hard_scene *s, const uint32_t dims[3],
                   const double spacing[3], double least, double most)
{
    struct transfer_function f = { .count = 3,
                                   .point = { { 0, { 1, 0.2f, 0 }, (float)least },
                                              { 0.6, { 0, 1, 0.3f }, (float)most },
                                              { 1, { 0.1f, 0.2f, 1 }, (float)most } } };
    double middle[3];
    uint32_t seed = o->seed;
    for (int axis = 0; axis < 3; axis++)
        middle[axis] = 0.3 * spacing[axis] * hard_random(&seed);
    s->scene = random_volume_scene(o->seed, dims, spacing, middle, &f);
}

static void block(const struct hard_options *o, struct hard_scene *s)
{
    volume(o, s, (const uint32_t[]){ 9, 9, 9 }, even, 0.01, 0.6);
}

/* Odd sizes: a column, a row and a pixel of the picture look straight ahead. */
static struct stp_camera odd_camera(const struct hard_options *o, bool flat)
{
    uint32_t w = o->width / 2 | 1, h = o->height / 2 | 1;
    return flat ? flat_camera(w, h, h / 2.6) : plain_camera(w, h, 1.5 * h);
}

/* From `eye`, and from a place that is turned off by TURN. */
void hard_axis_from(const struct hard_options *o, struct hard_scene *s, struct vec3 eye, bool flat)
{
    struct vec3 aside = v3_scale(v3_cross(eye, v3_unit(v3(0.2, 1, 0.1))), TURN);
    s->camera = s->twin_camera = odd_camera(o, flat);
    look_at(&s->camera, eye, v3(0, 0, 0));
    look_at(&s->twin_camera, v3_add(eye, aside), v3(0, 0, 0));
    s->truth[0] = 1;
}

static void two_axes(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_from(o, s, v3(2.6, 0, 2.6), false);
}

static void three_axes(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_from(o, s, v3(2.2, -2.2, 2.2), false);
}

static void two_axes_everywhere(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_from(o, s, v3(-3, 1, 3), true);
}

static void three_axes_everywhere(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_from(o, s, v3(3, 3, 3), true);
}

void hard_axis_look(const struct hard_options *o, struct hard_scene *s, double h)
{
    s->camera = odd_camera(o, false);
    look_at(&s->camera, v3_scale(hard_towards_eye(o), 3.6), v3(0, 0, 0));
    s->params.axis_h = h;
}

static void all_share(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_look(o, s, -1);
    s->truth[1] = 3;
}

static void hardly_any_share(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_look(o, s, 0.99);
}

void hard_axis_wide(const struct hard_options *o, struct hard_scene *s)
{
    s->camera = odd_camera(o, false);
    s->camera.fx = s->camera.fy = s->camera.height / 2.0 / tan(85 * M_PI / 180);
    look_at(&s->camera, v3(0.01, 0.02, 0.03), v3(1, 1, 1));
    s->truth[1] = 6;
}

static void six_walks(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_wide(o, s);
}

void hard_axis_inside(const struct hard_options *o, struct hard_scene *s)
{
    s->camera = odd_camera(o, false);
    look_at(&s->camera, v3_scale(hard_towards_eye(o), 0.3), v3(0, 0, 0));
    s->camera.near_depth = 0.05;
}

static void inside(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_inside(o, s);
}

void hard_axis_flat(const struct hard_options *o, struct hard_scene *s)
{
    s->camera = odd_camera(o, true);
    look_at(&s->camera, v3_scale(hard_towards_eye(o), 3.6), v3(0, 0, 0));
}

static void orthographic(const struct hard_options *o, struct hard_scene *s)
{
    block(o, s);
    hard_axis_flat(o, s);
}

static void tall(const struct hard_options *o, struct hard_scene *s)
{
    volume(o, s, (const uint32_t[]){ 13, 13, 3 }, (const double[]){ 0.06, 0.0613, 0.6 }, 0.01, 0.6);
    hard_axis_look(o, s, 0);
}

static void opaque(const struct hard_options *o, struct hard_scene *s)
{
    volume(o, s, (const uint32_t[]){ 9, 9, 9 }, even, 1, 1);
    hard_axis_look(o, s, 0);
}

static void one_voxel(const struct hard_options *o, struct hard_scene *s)
{
    volume(o, s, (const uint32_t[]){ 1, 1, 1 }, (const double[]){ 0.6, 0.6, 0.6 }, 0.7, 0.7);
    hard_axis_look(o, s, 0);
}

/* Sheets of a millionth of their kernels' length. */
static void a_million_to_one(const struct hard_options *o, struct hard_scene *s)
{
    volume(o, s, (const uint32_t[]){ 4, 4, 2 }, (const double[]){ 5e-7, 0.5, 0.53 }, 0.1, 0.6);
    hard_axis_look(o, s, 0);
}

#define BORDER                                                                                     \
    "every ray is its lists' order to rounding, and blend, whose weights are continuous, is the "  \
    "same picture a millionth of a radian aside"

static const struct hard_case cases[] = {
    { "The border of two axes", "Compute and rasteriser: " BORDER, two_axes, NULL, 0, 0, 0, 0, NULL,
      HARD_PYRAMID_POINTS },
    { "The border of three axes", "As above", three_axes, NULL, 0, 0, 0, 0, NULL,
      HARD_PYRAMID_POINTS },
    { "All rays on the border of two axes",
      "As above; clip takes for each ray the list of one of the two", two_axes_everywhere, NULL, 0,
      0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "All rays on the border of three axes", "As above, one of the three", three_axes_everywhere,
      NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "h = 0", "To rounding; three lists, all of weight", all_share, NULL, 0, 0, 0, 0, NULL,
      HARD_PYRAMID_POINTS },
    { "h = 0.99", "To rounding, though weights go from 0 to 1 within a hundredth", hardly_any_share,
      NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "170 degrees from inside", "To rounding; six walks: each axis with both signs", six_walks,
      NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "The eye inside", "To rounding; kernels that the near plane cuts count by what is visible",
      inside, NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Orthographic", "To rounding", orthographic, NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Spacing 1 : 1 : 10", "To rounding; the kernels are as long as their voxels", tall, NULL, 0,
      0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Opacity 1 everywhere", "To rounding; tau is finite, ln 2^24 over a spacing", opaque, NULL, 0,
      0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "One voxel", "To rounding; the same by every merge", one_voxel, NULL, 0, 0, 0, 0, NULL,
      HARD_PYRAMID_POINTS },
    { "Kernels of 10^6 : 1", "To rounding: the form is of the kernel's own size", a_million_to_one,
      NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_axis = { "axis", cases, sizeof cases / sizeof *cases };
