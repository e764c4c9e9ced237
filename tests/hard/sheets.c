/* Two sheets before one another, nearer and farther than epsilon. */
#include "hard.h"

struct hard_points hard_sheets_make(double gap)
{
    struct hard_points cloud = points_make(60);
    for (int i = 0; i < 60; i++) {
        double x = (i % 6 - 2.5) * 0.25, y = (i / 6 % 5 - 2) * 0.25;
        bool front = i < 30;
        double z = front ? -4 : -4 - gap * HARD_SHEETS_EPSILON;
        size_t at = points_add(&cloud, v3(x, y, z), v3(0, 0, 1), 0.25);
        points_paint(&cloud, at, front ? v3(1, 0, 0) : v3(0, 1, 0));
    }
    return cloud;
}

struct stp_camera hard_sheets_camera(const struct hard_options *o)
{
    return flat_camera(o->width, o->height, o->height / 1.5);
}

static void two_sheets(const struct hard_options *o, struct hard_scene *s, double gap)
{
    struct hard_points cloud = hard_sheets_make(gap);
    s->scene = points_scene(&cloud, HARD_SHEETS_EPSILON, 2);
    s->camera = hard_sheets_camera(o);
    s->params = (struct stp_render_params){ .min_splat = -1, .aovs = STP_AOV_ALBEDO };
    s->truth[0] = gap;
    points_release(&cloud);
}

static void closer(const struct hard_options *o, struct hard_scene *s)
{
    two_sheets(o, s, 0.5);
}

static void at_epsilon(const struct hard_options *o, struct hard_scene *s)
{
    two_sheets(o, s, 1);
}

static void farther(const struct hard_options *o, struct hard_scene *s)
{
    two_sheets(o, s, 1.0625);
}

/* The sheets are congruent: where both count, each is half of the albedo and the depth is halfway;
 * where the front alone counts, the back leaves no trace. Steps of packed depth: 2^-8 epsilon. */
static double off(const struct hard_scene *s, const struct stp_image *image, uint32_t px,
                  uint32_t py)
{
    double share = s->truth[0] <= 1 ? 0.5 : 0;
    double depth = 4 + share * s->truth[0] * HARD_SHEETS_EPSILON;
    double green = fabs(value(image, "albedo.G", px, py) - share);
    double z = fabs(value(image, "Z", px, py) - depth);
    return fmax(green / 1e-5, z / (HARD_SHEETS_EPSILON / 256));
}

static double check(const struct hard_scene *s, const struct stp_image *image)
{
    return hard_worst(s, image, off);
}

static const struct hard_case cases[] = {
    { "Two sheets half of epsilon apart",
      "Half of each, at half the depth: epsilon says that they are one surface", closer, check, 0,
      0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Two sheets at epsilon", "Both count, exactly: depth <= d + epsilon includes its end",
      at_epsilon, check, 0, 0, 0, 1, NULL, HARD_PYRAMID_SURFACE },
    { "Two sheets 17/16 of epsilon apart", "The nearer alone, without a trace of the other",
      farther, check, 0, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
};
const struct hard_family hard_sheets = { "sheets", cases, sizeof cases / sizeof *cases };
