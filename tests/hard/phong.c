/* Normal fields of ellipses: steep, huge, cancelling, a sphere's own; and what has to be the same
 * as something else. */
#include "ellipses.h"
#include "hard.h"

#define SPLATS 14 /* each a group of its own: a layer of `deferred` */

/* Slopes of tan(80 degrees) to tan(89.9), which turn the normal over within the splat. */
static void tilted(const struct hard_options *o, struct hard_scene *s, enum stp_cull cull)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    for (int i = 0; i < SPLATS; i++) {
        struct vec3 p = v3_add(random_point(&seed, 1.3), v3(0, 0, -5));
        struct vec3 n = v3_add(random_point(&seed, 1), v3(0, 0, cull ? -0.3 : 1));
        size_t at = points_add(&cloud, p, v3_unit(n), 1);
        struct stp_phong_splat *e =
            points_bend(&cloud, at, 7 * hard_random(&seed), 0.3 + 0.3 * hard_random(&seed), 0.4);
        for (int k = 0; k < 4; k++)
            e->field[k] = (float)((k % 2 ? 1 : 0.3) * (hard_random(&seed) < 0.5 ? -1 : 1) *
                                  tan((80 + 9.9 * hard_random(&seed)) * M_PI / 180));
        points_paint(&cloud, at, hard_color(&seed));
    }
    hard_show(s, &cloud, plain_camera(o->width, o->height, 1.6 * o->height), -1);
    s->params.cull = cull;
}

static void tilted_bare(const struct hard_options *o, struct hard_scene *s)
{
    tilted(o, s, STP_CULL_NONE);
}

static void tilted_culled(const struct hard_options *o, struct hard_scene *s)
{
    tilted(o, s, STP_CULL_BACK);
}

/* Of any size that a float holds. */
static void huge_fields(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(SPLATS);
    uint32_t seed = o->seed;
    for (int i = 0; i < SPLATS; i++) {
        struct vec3 p = v3_add(random_point(&seed, 1.3), v3(0, 0, -5));
        struct vec3 n = v3_add(random_point(&seed, 0.8), v3(0, 0, 1));
        size_t at = points_add(&cloud, p, v3_unit(n), 1);
        struct stp_phong_splat *e = points_bend(&cloud, at, 7 * hard_random(&seed), 0.4, 0.3);
        random_field(&seed, pow(10, 3 * i - 2), e);
        random_clips(&seed, e);
        for (int k = 0; k < 3; k++)
            e->clip[0][k] *= (float)pow(10, i % 2 ? -2 * i : 3 * i - 2);
        points_paint(&cloud, at, hard_color(&seed));
    }
    hard_show(s, &cloud, plain_camera(o->width, o->height, 1.6 * o->height), -1);
}

/* A unit sphere's tangent ellipses, with its own normals: n + x is its normal above n + x. */
static void sphere(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    uint32_t seed = o->seed;
    for (size_t i = 0; i < cloud.count; i++) {
        double r = (double)cloud.radius[i];
        struct stp_phong_splat *e =
            points_bend(&cloud, i, 7 * hard_random(&seed), r, r * (0.8 + 0.2 * hard_random(&seed)));
        e->field[1] = e->radius[0];
        e->field[3] = e->radius[1];
        s->truth[0] = fmax(s->truth[0], r);
    }
    hard_show_ball(o, s, &cloud);
}

/* What is averaged lies on one ray between the sphere and sqrt(1 + r^2), a shell of t, and has the
 * direction of where it lies: off by the way through the shell across that direction, at most t
 * tan(angle to the ray), 1.61 t within 0.85 of the middle. Rounding: that of packed keys, 28 bits,
 * 1e-3. Flat discs are off by r. */
static double check_sphere(const struct hard_scene *s, const struct stp_image *image)
{
    double shell = sqrt(1 + s->truth[0] * s->truth[0]) - 1, worst = 0;
    struct eye eye;
    eye_init(&eye, &s->camera, (double[3]){ 0, 0, 0 });
    struct vec3 centre = eye_point(&eye, (double[3]){ 0, 0, 0 });
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        uint32_t px = k % image->width, py = k / image->width;
        struct ray ray = eye_ray(&eye, px + 0.5, py + 0.5);
        struct vec3 off = v3_cross(v3_sub(centre, ray.start), v3_unit(ray.along));
        if (v3_length(off) > 0.85)
            continue;
        struct vec3 p = v3_sub(ray_at(&ray, value(image, "Z", px, py)), centre);
        struct vec3 n = v3(value(image, "N.X", px, py), value(image, "N.Y", px, py),
                           value(image, "N.Z", px, py));
        double angle = v3_length(v3_cross(eye_direction(&eye, n), v3_unit(p)));
        worst = fmax(worst, isfinite(angle) ? angle / (1.61 * shell + 1e-3) : INFINITY);
    }
    return worst;
}

static struct hard_points mixture(uint32_t seed)
{
    struct hard_points cloud = points_make(SPLATS);
    for (int i = 0; i < SPLATS; i++) {
        double large = 0.5 * pow(10, -1.2 * hard_random(&seed));
        size_t at =
            points_add(&cloud, random_point(&seed, 1), v3_unit(random_point(&seed, 1)), large);
        points_paint(&cloud, at, hard_color(&seed));
        if (i % 3 == 0)
            continue;
        struct stp_phong_splat *e =
            points_bend(&cloud, at, 7 * hard_random(&seed), large, large * hard_random(&seed));
        random_field(&seed, 0.8, e);
        random_clips(&seed, e);
    }
    return cloud;
}

static void mixed(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = mixture(o->seed);
    hard_show(s, &cloud, hard_look(o, v3(0, 0, 0), 5, 30), -1);
}

static void far_away(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points near = mixture(o->seed), far = mixture(o->seed);
    struct vec3 by = v3(4.5e5, 5.9e6, 300);
    points_move(&far, by);
    s->twin = points_scene(&near, 0.02, 2);
    s->twin_camera = hard_look(o, v3(0, 0, 0), 5, 30);
    s->scene = points_scene(&far, 0.02, 2);
    s->camera = hard_look(o, by, 5, 30);
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&near);
    points_release(&far);
}

static void plain(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    s->twin = points_scene(&cloud, 0, 2);
    for (size_t i = 0; i < cloud.count; i++)
        points_bend(&cloud, i, (double)i, (double)cloud.radius[i], (double)cloud.radius[i]);
    s->scene = points_scene(&cloud, 0, 2);
    assert_int_equal(s->scene->facts.phong, 0);
    s->camera = s->twin_camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&cloud);
}

#define SPOILS 7

static void spoil(struct stp_phong_splat *e, const float normal[3], size_t kind)
{
    switch (kind) {
    case 0:
        e->u[1] = NAN;
        break;
    case 1:
        memcpy(e->u, normal, sizeof e->u);
        break;
    case 2:
        e->radius[0] = 0;
        break;
    case 3:
        e->radius[1] = -1;
        break;
    case 4:
        e->field[2] = INFINITY;
        break;
    case 5:
        e->clips = 3;
        break;
    default:
        e->clips = 1;
        e->clip[0][2] = NAN;
    }
}

/* The first seven ellipses spoilt, each its own way; in the twin they are discs. */
static void spoilt(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = mixture(o->seed), twin = mixture(o->seed);
    size_t bad = 0;
    for (size_t i = 0; i < cloud.count; i++) {
        if (bad == SPOILS || i % 3 == 0) /* the latter are discs */
            continue;
        spoil(&cloud.phong[i], cloud.normal[i], bad++);
        twin.phong[i] = (struct stp_phong_splat){ 0 };
    }
    s->scene = points_scene(&cloud, 0.02, 2);
    s->twin = points_scene(&twin, 0.02, 2);
    assert_true(bad == SPOILS && s->scene->facts.phong > 0);
    assert_int_equal(s->scene->facts.bad_phong, bad);
    s->camera = s->twin_camera = hard_look(o, v3(0, 0, 0), 5, 30);
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&cloud);
    points_release(&twin);
}

/* Two sheets half of epsilon apart whose normals cancel: 10^7 u + n and -10^7 u + n. */
static void opposed(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(2);
    for (int i = 0; i < 2; i++) {
        size_t at = points_add(&cloud, v3(0, 0, -4 - i / 64.0), v3(0, 0, 1), 1);
        struct stp_phong_splat e = { .u = { 1, 0, 0 },
                                     .radius = { 1, 0.75f },
                                     .field = { i ? -1e7f : 1e7f } };
        *points_bend(&cloud, at, 0, 1, 1) = e;
        points_paint(&cloud, at, i ? v3(0, 1, 0) : v3(1, 0, 0));
    }
    s->scene = points_scene(&cloud, 1 / 32.0, 2);
    s->camera = flat_camera(o->width, o->height, o->height / 2.2);
    s->params = (struct stp_render_params){ .min_splat = -1, .aovs = STP_AOV_ALBEDO };
    points_release(&cloud);
}

/* The nearer one's normal, whose x is 1, and its colour. The bound is that of packed keys, 1/255.
 */
static double off_near(const struct hard_scene *s, const struct stp_image *image, uint32_t px,
                       uint32_t py)
{
    double x = value(image, "N.X", px, py), red = value(image, "albedo.R", px, py);
    return fmax(fabs(x - 1), fabs(red - 1)) * 255;
}

static double check_opposed(const struct hard_scene *s, const struct stp_image *image)
{
    return hard_worst(s, image, off_near);
}

static const struct hard_case cases[] = {
    { "Normals tilted past 80 degrees",
      "To rounding: N is made unit where it is evaluated, never before it is interpolated",
      tilted_bare, NULL, 0, 0, 0, 0, NULL, 0 },
    { "Normals tilted past 80 degrees, culled",
      "To rounding: a splat stays while any normal on it may face the eye", tilted_culled, NULL, 0,
      0, 0, 0, NULL, 0 },
    { "Fields and lines of 10^-26 to 10^37",
      "To rounding, and no square overflows: N has a direction whatever "
      "its length",
      huge_fields, NULL, 0, 0, 0, 0, NULL, 0 },
    { "A sphere's own normals",
      "A normal's error is of second order in the splats' size, where flat discs have the first",
      sphere, check_sphere, 45, 0, 0, 0, NULL, 0 },
    { "Normals that cancel",
      "The nearest one's normal and colour, where the sum has no direction: less than 1e-6",
      opposed, check_opposed, 0, 0, 0, 1, NULL, 0 },
    { "Discs among ellipses", "To rounding: both by one shader", mixed, NULL, 0, 0, 0, 0, NULL, 0 },
    { "Ellipses near 6e6", "The picture of the unmoved ones, N and relative Z at 90 dB", far_away,
      NULL, 0, 90, 0, 0, NULL, 0 },
    { "Ellipses that are discs", "The bits of the discs: nothing of an ellipse is kept", plain,
      NULL, 40, INFINITY, 0, 0, NULL, 0 },
    { "What is no ellipse",
      "NaN, no axis, u along the normal, three lines: counted, and drawn as the discs that they "
      "are "
      "in its twin, to the bit",
      spoilt, NULL, 0, INFINITY, 0, 0, NULL, 0 },
};
const struct hard_family hard_phong = { "phong", cases, sizeof cases / sizeof *cases };
