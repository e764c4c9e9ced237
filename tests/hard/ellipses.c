/* Outlines of ellipses: needles, edge-on, across the near plane, below the floor, cut by lines. */
#include "ellipses.h"
#include "hard.h"

#define SPLATS 14 /* each a group of its own: a layer of `deferred` */

/* Aspects of 1 to 10^6; `thin` is the lesser semi-axis, or, negative, the larger one negated. */
static void needles(const struct hard_options *o, struct hard_scene *s, double thin, double floor)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    for (int i = 0; i < SPLATS; i++) {
        double aspect = pow(10, i % 7), large = thin > 0 ? thin * aspect : -thin;
        struct vec3 p = v3_add(random_point(&seed, 1.2), v3(0, 0, -4));
        struct vec3 n = v3_add(random_point(&seed, 0.8), v3(0, 0, 1));
        size_t at = points_add(&cloud, p, v3_unit(n), 1);
        struct stp_phong_splat *e =
            points_bend(&cloud, at, 7 * hard_random(&seed), large, large / aspect);
        random_field(&seed, 0.5, e);
        points_paint(&cloud, at, hard_color(&seed));
    }
    hard_show(s, &cloud, plain_camera(o->width, o->height, 1.6 * o->height), floor);
}

static void needles_bare(const struct hard_options *o, struct hard_scene *s)
{
    needles(o, s, 0.05, -1);
}

static void needles_floored(const struct hard_options *o, struct hard_scene *s)
{
    needles(o, s, -0.6, 1.5);
}

/* Every third plane holds the view, exactly or to within 1e-8; the others are at a slant. */
static void edge_on(const struct hard_options *o, struct hard_scene *s, double floor)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    for (int i = 0; i < SPLATS; i++) {
        struct vec3 p = v3_add(random_point(&seed, 0.7), v3(0, 0, -3 - 0.3 * i));
        struct vec3 n = hard_edge_on(p, &seed);
        double slant = i % 3 == 0 ? 0.3 : i % 3 == 1 ? 1e-8 * hard_random(&seed) : 0;
        n = v3_unit(v3_sub(n, v3_scale(v3_unit(p), slant)));
        size_t at = points_add(&cloud, p, n, 1);
        double large = 0.2 + 0.3 * hard_random(&seed);
        struct stp_phong_splat *e =
            points_bend(&cloud, at, 7 * hard_random(&seed), large, large * hard_random(&seed));
        random_field(&seed, 1, e);
        random_clips(&seed, e);
    }
    hard_show(s, &cloud, plain_camera(o->width, o->height, 1.6 * o->height), floor);
}

static void edge_on_bare(const struct hard_options *o, struct hard_scene *s)
{
    edge_on(o, s, -1);
}

static void edge_on_floored(const struct hard_options *o, struct hard_scene *s)
{
    edge_on(o, s, 1.5);
}

/* Round the eye, on all sides, most of them through the near plane. */
static void across_near(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    struct stp_camera camera = plain_camera(o->width, o->height, 0.5 * o->height);
    for (int i = 0; i < SPLATS; i++) {
        struct vec3 n = v3_unit(random_point(&seed, 1)), p = random_point(&seed, 0.6);
        p = v3_sub(p, v3_scale(n, v3_dot(p, n) + 0.3 + hard_random(&seed))); /* off the eye */
        size_t at = points_add(&cloud, p, n, 1);
        double large = 3 * pow(10, hard_random(&seed));
        struct stp_phong_splat *e = points_bend(&cloud, at, 7 * hard_random(&seed), large,
                                                large * pow(10, -hard_random(&seed)));
        random_field(&seed, 1, e);
        random_clips(&seed, e);
        points_paint(&cloud, at, hard_color(&seed));
    }
    camera.near_depth = 0.2;
    hard_show(s, &cloud, camera, -1);
}

/* Dots of the floor, of needles and of wide ellipses alike, some cut. */
static void dots(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    for (int i = 0; i < SPLATS; i++) {
        struct vec3 p = v3_add(random_point(&seed, 1), v3(0, 0, -4));
        size_t at = points_add(&cloud, p, v3_unit(random_point(&seed, 1)), 1);
        double large = 1e-3 * pow(10, 2 * hard_random(&seed) - 4 * (i % 2));
        struct stp_phong_splat *e = points_bend(&cloud, at, 7 * hard_random(&seed), large,
                                                large * pow(10, -4 * hard_random(&seed)));
        random_field(&seed, 0.3, e);
        random_clips(&seed, e);
        points_paint(&cloud, at, hard_color(&seed));
    }
    hard_show(s, &cloud, plain_camera(o->width, o->height, 1.3 * o->height), 4);
}

/* Clip lines: which pixels are there. */
#define WEDGES 12 /* 4 x 3, face on, two units from one another */

static struct stp_phong_splat wedge(uint32_t seed, int i)
{
    struct stp_phong_splat e;
    seed = seed * 2654435761u + (uint32_t)i * 40503u + 1;
    for (int k = 0; k < 4; k++)
        hard_random(&seed);
    e = ellipse_across((float[3]){ 0, 0, 1 }, 7 * hard_random(&seed), 0.95, 0.5);
    e.clips = (uint8_t)(i < 2 ? 1 : 2);
    e.reflex = i % 2 && e.clips == 2;
    for (int k = 0; k < e.clips; k++) {
        double angle = 7 * hard_random(&seed);
        e.clip[k][0] = (float)cos(angle);
        e.clip[k][1] = (float)sin(angle);
        e.clip[k][2] = (float)(0.6 * hard_random(&seed) - 0.3);
    }
    return e;
}

static void wedges(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(WEDGES);
    for (int i = 0; i < WEDGES; i++) {
        struct stp_phong_splat e = wedge(o->seed, i);
        size_t at = points_add(&cloud, v3(i % 4 * 2 - 3, i / 4 * 2 - 2, -4), v3(0, 0, 1), 1);
        *points_bend(&cloud, at, 0, 1, 1) = e;
        points_paint(&cloud, at, e.reflex ? v3(1, 0.5, 0) : v3(0, 0.5, 1));
    }
    double unit = fmin(o->width / 8.4, o->height / 6.4);
    hard_show(s, &cloud, flat_camera(o->width, o->height, unit), -1);
    s->truth[0] = o->seed;
}

/* Least distance from a border, in parameters; negative: outside. */
static double within(const struct stp_phong_splat *e, double x, double y)
{
    struct vec3 u = v3_loadf(e->u), v = v3_cross(v3(0, 0, 1), u);
    double p = (u.x * x + u.y * y) / (double)e->radius[0];
    double q = (v.x * x + v.y * y) / (double)e->radius[1], kept[2];
    for (int k = 0; k < 2; k++)
        kept[k] = (double)e->clip[k][0] * p + (double)e->clip[k][1] * q + (double)e->clip[k][2];
    if (e->clips < 2)
        kept[1] = kept[0];
    return fmin(1 - hypot(p, q), e->reflex ? fmax(kept[0], kept[1]) : fmin(kept[0], kept[1]));
}

/* Every pixel but those whose centre is within 1e-4 of a border. */
static double check_wedges(const struct hard_scene *s, const struct stp_image *image)
{
    double wrong = 0;
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        uint32_t px = k % image->width, py = k / image->width;
        double x = (px + 0.5 - s->camera.cx) / s->camera.fx;
        double y = (s->camera.cy - py - 0.5) / s->camera.fy, least = -1;
        for (int i = 0; i < WEDGES; i++) {
            struct stp_phong_splat e = wedge((uint32_t)s->truth[0], i);
            least = fmax(least, within(&e, x - (i % 4 * 2 - 3), y - (i / 4 * 2 - 2)));
        }
        if (fabs(least) > 1e-4)
            wrong += isfinite(value(image, "Z", px, py)) != (least > 0);
    }
    return wrong > 0 ? 1 + wrong : 0;
}

static const struct hard_case cases[] = {
    { "Aspects to a million",
      "To rounding: (s, t) are two linear forms of the pixel, and neither is a small difference of "
      "large numbers",
      needles_bare, NULL, 0, 0, 0, 0, NULL, 0 },
    { "Aspects to a million, floored", "To rounding; each is at least a line 1.5 pixels wide",
      needles_floored, NULL, 0, 0, 0, 0, NULL, 0 },
    { "Edge-on ellipses, no floor", "To rounding; a plane seen exactly edge-on has no pixels",
      edge_on_bare, NULL, 0, 0, 0, 0, NULL, 0 },
    { "Edge-on ellipses, floored", "To rounding; each is a line 1.5 pixels wide, cut by its lines",
      edge_on_floored, NULL, 0, 0, 0, 0, NULL, 0 },
    { "Ellipses across the near plane",
      "To rounding: outlines that are hyperbolas, cut at the near plane to the pixel", across_near,
      NULL, 0, 0, 0, 0, NULL, 0 },
    { "Ellipses below the floor",
      "To rounding: the projection's directions stay, its widths are those of the floor, lines cut "
      "the same share of it",
      dots, NULL, 0, 0, 0, 0, NULL, 0 },
    { "Lines of both and of either",
      "The pixels that 1 - rho >= 0 and the lines' sides say, each: both keep a convex edge, "
      "either "
      "a reflex one",
      wedges, check_wedges, 0, 0, 0, 0, NULL, 0 },
};
const struct hard_family hard_ellipses = { "ellipses", cases, sizeof cases / sizeof *cases };
