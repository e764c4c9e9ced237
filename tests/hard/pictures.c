/* Pictures of every shape. */
#include "hard.h"

static void shaped(const struct hard_options *o, struct hard_scene *s, uint32_t width,
                   uint32_t height)
{
    struct hard_options shape = *o;
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    shape.width = width;
    shape.height = height;
    s->scene = points_scene(&cloud, 0, 2);
    s->camera = hard_look(&shape, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&cloud);
}

static void one_by_one(const struct hard_options *o, struct hard_scene *s)
{
    shaped(o, s, 1, 1);
}

static void column(const struct hard_options *o, struct hard_scene *s)
{
    shaped(o, s, 1, 301);
}

static void row(const struct hard_options *o, struct hard_scene *s)
{
    shaped(o, s, 301, 1);
    s->camera.fx *= 100;
}

static void odd(const struct hard_options *o, struct hard_scene *s)
{
    shaped(o, s, (o->width | 1) + 2, (o->height | 1) + 4);
}

/* 16384 columns of the ball, four rows of it: pixels are not square. */
static void sixteen_thousand(const struct hard_options *o, struct hard_scene *s)
{
    /* Discs of fewer points are thousands of pixels long: a pyramid of gigabytes. */
    struct hard_options fine = *o;
    fine.points = o->points > 1500 ? o->points : 1500;
    shaped(&fine, s, 16384, 4);
    s->camera.fx = 16384 / 2.0 / 0.3;
}

static const struct hard_case cases[] = {
    { "A 1x1 picture", "To rounding", one_by_one, NULL, 40, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "A 1xN picture", "To rounding", column, NULL, 40, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "An Nx1 picture", "To rounding", row, NULL, 40, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Odd sizes", "To rounding: blocks of 8 x 8 stop at the edge", odd, NULL, 45, 0, 0, 0, NULL,
      HARD_PYRAMID_SURFACE },
    { "A 16k wide picture", "To rounding at 16384 columns", sixteen_thousand, NULL, 45, 0, 0, 0,
      NULL, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_pictures = { "pictures", cases, sizeof cases / sizeof *cases };
