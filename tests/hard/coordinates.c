/* Coordinates that float32 does not hold. */
#include "hard.h"

#define RELIEF_WAVE   0.25  /* metres */
#define RELIEF_HEIGHT 0.002 /* amplitude */

static double relief(double x, double z)
{
    double k = 2 * M_PI / RELIEF_WAVE;
    return RELIEF_HEIGHT * sin(k * x) * cos(k * z);
}

static struct vec3 relief_normal(double x, double z)
{
    double k = 2 * M_PI / RELIEF_WAVE, a = RELIEF_HEIGHT * k;
    return v3_unit(v3(-a * cos(k * x) * cos(k * z), 1, a * sin(k * x) * sin(k * z)));
}

/* A metre of ground, its lowest corner's coordinates multiples of 2^-3: they add exactly. */
static struct hard_points ground(const struct hard_options *o, struct vec3 at)
{
    size_t side = (size_t)sqrt((double)o->points);
    struct hard_points cloud = points_make(side * side);
    uint32_t seed = o->seed;
    for (size_t i = 0; i < side * side; i++) {
        double x = ((double)(i % side) + 0.5 * hard_random(&seed)) / (double)side;
        double z = ((double)(i / side) + 0.5 * hard_random(&seed)) / (double)side;
        points_add(&cloud, v3(x, relief(x, z), z), relief_normal(x, z), 1.2 / (double)side);
    }
    points_move(&cloud, at);
    return cloud;
}

static struct stp_camera above(const struct hard_options *o, struct vec3 at)
{
    struct hard_options high = *o;
    high.rise = 0.9 + 0.3 * sin(o->rise);
    return hard_look(&high, v3_add(at, v3(0.5, 0, 0.5)), 2.2, 30);
}

static void survey(const struct hard_options *o, struct hard_scene *s)
{
    struct vec3 at = v3(437512.25, 312.5, -6000123.125), zero = v3(0, 0, 0);
    struct hard_points far = ground(o, at), near = ground(o, zero);
    s->scene = points_scene(&far, 0, 2);
    s->twin = points_scene(&near, 0, 2);
    s->camera = above(o, at);
    s->twin_camera = above(o, zero);
    s->params = (struct stp_render_params){ .min_splat = -1, .aovs = STP_AOV_POSITION };
    s->truth[0] = at.x;
    s->truth[1] = at.z;
    s->truth[2] = 1 / sqrt((double)far.count);
    points_release(&far);
    points_release(&near);
}

/* Discs of a radius a and more apart by a turn of k a: the mean of them stays within one such turn
 * of the ground's own normal. A flattened relief would be off by k times its height, twice that. */
static double off_relief(const struct hard_scene *s, const struct stp_image *image, uint32_t px,
                         uint32_t py)
{
    double x = value(image, "P.X", px, py) + image->origin[0] - s->truth[0];
    double z = value(image, "P.Z", px, py) + image->origin[2] - s->truth[1];
    struct vec3 n =
        v3(value(image, "N.X", px, py), value(image, "N.Y", px, py), value(image, "N.Z", px, py));
    return v3_length(v3_sub(n, relief_normal(x, z)));
}

static double check_survey(const struct hard_scene *s, const struct stp_image *image)
{
    double k = 2 * M_PI / RELIEF_WAVE, bound = 1.2 * s->truth[2] * k * k * RELIEF_HEIGHT;
    return hard_worst(s, image, off_relief) / bound;
}

/* A ball two across, moved by `sizes` of its size along each axis. */
static void moved(const struct hard_options *o, struct hard_scene *s, double sizes)
{
    struct vec3 zero = v3(0, 0, 0), at = v3(2 * sizes, -2 * sizes, 2 * sizes);
    struct hard_points cloud = points_ball(o, zero, 0.15);
    s->twin = points_scene(&cloud, 0, 2);
    points_move(&cloud, at);
    s->scene = points_scene(&cloud, 0, 2);
    s->twin_camera = hard_look(o, zero, 4.6, 30);
    s->camera = hard_look(o, zero, 4.6, 30);
    double *m = s->camera.world_to_camera;
    struct vec3 t = m4_direction(m, at);
    m[3] -= t.x;
    m[7] -= t.y;
    m[11] -= t.z;
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&cloud);
}

static void moved_10(const struct hard_options *o, struct hard_scene *s)
{
    moved(o, s, 10);
}

static void moved_100(const struct hard_options *o, struct hard_scene *s)
{
    moved(o, s, 100);
}

static void moved_1000(const struct hard_options *o, struct hard_scene *s)
{
    moved(o, s, 1000);
}

static void moved_1e6(const struct hard_options *o, struct hard_scene *s)
{
    moved(o, s, 1e6);
}

#define MOVED                                                                                      \
    "The picture of the unmoved one, N and relative Z at 90 dB: doubles hold the place to 10^-9 "  \
    "of a size, and all else is relative to an origin amid the points"

static const struct hard_case cases[] = {
    { "Survey coordinates near 6e6, millimetre detail",
      "The relief is there, its normals within the turn between two discs, and the picture is that "
      "of the same ground at 0: 2^-53 of 6e6 is a nanometre",
      survey, check_survey, 45, 90, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Moved by 10 sizes", MOVED, moved_10, NULL, 45, 90, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Moved by 100 sizes", MOVED, moved_100, NULL, 45, 90, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Moved by 1000 sizes", MOVED, moved_1000, NULL, 45, 90, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Moved by a million sizes", MOVED, moved_1e6, NULL, 45, 90, 0, 0, NULL,
      HARD_PYRAMID_SURFACE },
};
const struct hard_family hard_coordinates = { "coordinates", cases, sizeof cases / sizeof *cases };
