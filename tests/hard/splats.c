/* Extents: edge-on, zero, tiny, huge, monstrous. */
#include "hard.h"

/* Discs round the eye's axis whose planes hold the view, exactly or to within 1e-8. */
static void edge_on(const struct hard_options *o, struct hard_scene *s, double min_splat)
{
    struct hard_points cloud = points_make(40);
    uint32_t seed = o->seed;
    for (int i = 0; i < 40; i++) {
        struct vec3 p = v3_add(random_point(&seed, 0.7), v3(0, 0, -3 - 0.1 * i));
        struct vec3 n = hard_edge_on(p, &seed);
        double tilt = i % 4 == 0 ? 0.3 : i % 4 == 1 ? 1e-8 * hard_random(&seed) : 0;
        n = v3_unit(v3_sub(n, v3_scale(v3_unit(p), tilt)));
        points_add(&cloud, p, n, 0.2 + 0.3 * hard_random(&seed));
    }
    points_round(&cloud);
    s->scene = points_scene(&cloud, 0.02, 2);
    s->camera = plain_camera(o->width, o->height, 1.6 * o->height);
    s->params = (struct stp_render_params){ .min_splat = min_splat };
    points_release(&cloud);
}

static void edge_on_bare(const struct hard_options *o, struct hard_scene *s)
{
    edge_on(o, s, -1);
}

static void edge_on_floored(const struct hard_options *o, struct hard_scene *s)
{
    edge_on(o, s, 1.5);
}

/* As above, with discs so large that only a tip of each 1.5 pixel line is in the picture. */
static void long_lines(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(48);
    uint32_t seed = o->seed;
    double focal = 14.0 * o->height;
    for (int i = 0; i < 48; i++) {
        double turn = i * M_PI / 24, length = 2 * (1 + hard_random(&seed));
        struct vec3 u = v3(cos(turn), sin(turn), 0), tip = random_point(&seed, 0.06);
        double r = length * 700 / focal; /* 700 to 1400 pixels */
        struct vec3 c = v3_sub(v3(tip.x, tip.y, -2 - 0.1 * i), v3_scale(u, r));
        points_add(&cloud, c, v3_unit(v3_cross(u, c)), r);
    }
    points_round(&cloud);
    s->scene = points_scene(&cloud, 0.02, 2);
    s->camera = plain_camera(o->width, o->height, focal);
    s->params = (struct stp_render_params){ .min_splat = 1.5 };
    points_release(&cloud);
}

/* A sphere with damage: what is seen is the sphere. */
static void look_at_sphere(const struct hard_options *o, struct hard_scene *s,
                           const struct hard_points *cloud)
{
    s->scene = points_scene(cloud, 0, 2);
    s->camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .min_splat = -1, .aovs = STP_AOV_POSITION };
    for (size_t i = 0; i < s->scene->splats.count; i++)
        s->truth[0] = fmax(s->truth[0], s->scene->splats.radius[i]);
}

/* Tangent discs lie between the sphere and sqrt(1 + r^2), and so does their average wherever the
 * ray is not grazing; none is missing. Rounding: 1e-4. */
static double check_sphere(const struct hard_scene *s, const struct stp_image *image)
{
    double shell = sqrt(1 + s->truth[0] * s->truth[0]) - 1 + 1e-4, worst = 0;
    struct eye eye;
    eye_init(&eye, &s->camera, (double[3]){ 0, 0, 0 });
    struct vec3 centre = eye_point(&eye, (double[3]){ 0, 0, 0 });
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        struct ray ray = eye_ray(&eye, px + 0.5, py + 0.5);
        struct vec3 off = v3_cross(v3_sub(centre, ray.start), v3_unit(ray.along));
        double z = value(image, "Z", px, py);
        if (v3_length(off) > 0.85)
            continue;
        double rise = v3_length(v3_sub(ray_at(&ray, z), centre)) - 1;
        worst = isfinite(z) ? fmax(worst, rise < 0 ? -rise / 1e-4 : rise / shell) : INFINITY;
    }
    return worst;
}

static void radius_zero(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    for (size_t i = 0; i < cloud.count; i += 5)
        cloud.radius[i] = i % 2 ? NAN : 0;
    look_at_sphere(o, s, &cloud);
    assert_int_equal(s->scene->facts.bad_radii, (cloud.count + 4) / 5);
    points_release(&cloud);
}

static void monster(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    cloud.radius[o->seed % cloud.count] *= 1000;
    look_at_sphere(o, s, &cloud);
    assert_int_equal(s->scene->facts.bad_radii, 1);
    points_release(&cloud);
}

/* A stray point a thousand sizes away, its radius left to the program. */
static void stray(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points ball = points_ball(o, v3(0, 0, 0), 0), cloud = points_make(ball.count + 1);
    struct stp_frame_params frame = {
        .azimuth = o->turn, .elevation = o->rise, .width = o->width, .height = o->height
    };
    struct stp_camera alone;
    points_add(&cloud, v3(2000, 1500, -900), v3(0, 0, 1), 0);
    for (size_t i = 0; i < ball.count; i++)
        points_add(&cloud, v3_load(ball.position[i]),
                   v3(ball.normal[i][0], ball.normal[i][1], ball.normal[i][2]), ball.radius[i]);
    struct stp_scene *without = points_scene(&ball, 0, 2);
    look_at_sphere(o, s, &cloud);
    s->truth[0] = without->facts.radius_max;
    assert_int_equal(stp_camera_frame(NULL, s->scene, &frame, &s->camera), STP_OK);
    assert_int_equal(stp_camera_frame(NULL, without, &frame, &alone), STP_OK);
    struct vec3 a = m4_point(s->camera.world_to_camera, v3(0, 0, 0));
    struct vec3 b = m4_point(alone.world_to_camera, v3(0, 0, 0));
    assert_true(fabs(v3_length(a) / v3_length(b) - 1) < 0.01);
    stp_scene_destroy(&without);
    points_release(&ball);
    points_release(&cloud);
}

static void tiny(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    for (size_t i = 0; i < cloud.count; i++)
        cloud.radius[i] *= 1e-6f;
    s->scene = points_scene(&cloud, 0.05, 2);
    s->camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .cull = STP_CULL_BACK };
    s->truth[0] = (double)cloud.count;
    points_release(&cloud);
}

/* The floor makes a dot of 1.5 pixels of each: one holds pi/4 1.5^2 = 1.8 pixel centres on average.
 * Half the ball is seen, of a fifth of the points face on and more towards its outline, and dots
 * share pixels: 1 - exp(-density) of them is covered, less a quarter for the ball's bumps and two
 * standard deviations. */
static double check_tiny(const struct hard_scene *s, const struct stp_image *image)
{
    double focal = s->camera.fx / 4.6, covered = 0, expected = 0;
    double dots = M_PI / 4 * 2.25 * 0.2 * s->truth[0] / (M_PI * focal * focal); /* face on */
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        double x = (i % image->width + 0.5 - s->camera.cx) / focal;
        double y = (i / image->width + 0.5 - s->camera.cy) / focal, cosine2 = 1 - x * x - y * y;
        covered += isfinite(stp_image_find(image, "Z")->data.f[i]);
        expected += cosine2 > 0 ? 1 - exp(-dots / sqrt(cosine2)) : 0;
    }
    return (0.75 * expected - 2 * sqrt(M_PI / 4 * 2.25 * expected)) / covered;
}

static void huge(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(12);
    uint32_t seed = o->seed;
    for (int i = 0; i < 12; i++) {
        struct vec3 n = v3_unit(v3_add(random_point(&seed, 0.8), v3(0, 0, 1)));
        size_t at = points_add(&cloud, v3_add(random_point(&seed, 1), v3(0, 0, -4)), n,
                               1e4 * (1 + hard_random(&seed)));
        points_paint(&cloud, at, v3(hard_random(&seed), hard_random(&seed), hard_random(&seed)));
    }
    s->scene = points_scene(&cloud, 0.05, 2);
    s->camera = plain_camera(o->width, o->height, o->height);
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&cloud);
}

static const struct hard_case cases[] = {
    { "Edge-on splats, no floor", "To rounding; a disc seen exactly edge-on has no pixels",
      edge_on_bare, NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Edge-on splats, floored", "To rounding; each is a line 1.5 pixels wide", edge_on_floored,
      NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Floored lines of 2800 pixels",
      "To rounding: the tips are where the form's terms are 10^6 times their sum", long_lines, NULL,
      0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Radius 0 or NaN",
      "Set from the spacing and counted; the sphere is closed and within its tangent discs",
      radius_zero, check_sphere, 45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "One radius 1000 times the others",
      "Taken for a mistake, set from the spacing and counted; the sphere is unharmed", monster,
      check_sphere, 45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "One point 1000 sizes away",
      "The frame is that without it to 1 %, and the sphere is unharmed", stray, check_sphere, 40, 0,
      0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Tiny radii", "Every splat is a dot of 1.5 pixels: none is lost", tiny, check_tiny, 40, 0, 0,
      0, NULL, HARD_PYRAMID_POINTS },
    { "Huge radii", "To rounding: planes across the whole view, cut by each other", huge, NULL, 0,
      0, 0, 0, NULL, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_splats = { "splats", cases, sizeof cases / sizeof *cases };
