/* What must not change a bit. */
#include "hard.h"

static void same(const struct hard_options *o, struct hard_scene *s, bool shuffled, unsigned few,
                 unsigned many)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    s->scene = points_scene(&cloud, 0, few);
    if (shuffled)
        points_shuffle(&cloud, o->seed + 1);
    s->twin = points_scene(&cloud, 0, many);
    s->camera = s->twin_camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .aovs = STP_AOV_ALBEDO | STP_AOV_FRAGMENTS };
    points_release(&cloud);
}

static void shuffled(const struct hard_options *o, struct hard_scene *s)
{
    same(o, s, true, 2, 2);
}

static void threads(const struct hard_options *o, struct hard_scene *s)
{
    same(o, s, false, 1, 7);
}

/* Estimated normals and radii too. */
static void bare(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    cloud.no_normals = cloud.no_radii = true;
    s->scene = points_scene(&cloud, 0, 1);
    points_shuffle(&cloud, o->seed + 2);
    s->twin = points_scene(&cloud, 0, 5);
    s->camera = s->twin_camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    points_release(&cloud);
}

static const struct hard_case cases[] = {
    { "Shuffled input", "The same bits: points are put in an order of their own first", shuffled,
      NULL, 45, INFINITY, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "One thread and seven", "The same bits: no sum is split by thread", threads, NULL, 45,
      INFINITY, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Shuffled, other threads, nothing but positions",
      "The same bits, estimated normals and radii among them", bare, NULL, 40, INFINITY, 0, 0, NULL,
      HARD_PYRAMID_POINTS },
};
const struct hard_family hard_bits = { "bits", cases, sizeof cases / sizeof *cases };
