/* Samples that leave a fit of ellipses open, or that a careless one would mix up. What is drawn are
 * the fitted splats; the truth is what was sampled. Flat things: fits_flat.c. */
#include "hard.h"

#define LINES 12

/* Lines of one, two and three samples, 0.1 apart, each in a place and a plane of its own. */
static struct hard_points few_samples(uint32_t seed)
{
    struct hard_points cloud = points_make(3 * LINES);
    for (int i = 0; i < LINES; i++) {
        struct vec3 middle = v3(i % 4 - 1.5, i / 4 - 1, 0.3 * hard_random(&seed));
        struct vec3 n = v3_unit(v3_add(random_point(&seed, 0.4), v3(0, 0, 1)));
        struct vec3 along = v3_unit(v3_cross(n, random_point(&seed, 1)));
        for (int k = 0; k <= i % 3; k++) {
            struct vec3 p = v3_add(middle, v3_scale(along, 0.1 * k));
            struct vec3 lean = v3_add(n, v3_scale(along, 0.3 * k)); /* so that a slope is asked */
            points_add(&cloud, p, v3_unit(lean), 0.08);
        }
    }
    return cloud;
}

static void few(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = few_samples(o->seed);
    struct stp_fit made = hard_fit(s, &cloud, 0.02, 0.005);
    assert_true(made.splats > 0 && made.splats <= cloud.count);
    /* From so near, if need be, that a disc of 0.08 is wider than a pixel's diagonal on a slant. */
    s->camera = plain_camera(o->width, o->height, fmax(90, 1.1 * fmin(o->width, o->height)));
    look_at(&s->camera, v3(0, 0, 5), v3(0, 0, 0));
    s->params = (struct stp_render_params){ .min_splat = -1 };
    s->truth[0] = o->seed;
    points_release(&cloud);
}

/* Every sample's pixel shows a surface within the tolerance, and a pixel's width on a slant of 1,
 * of the sample. */
static double check_few(const struct hard_scene *s, const struct stp_image *image)
{
    struct hard_points cloud = few_samples((uint32_t)s->truth[0]);
    double worst = 0;
    for (size_t i = 0; i < cloud.count; i++) {
        struct vec3 p = m4_point(s->camera.world_to_camera, v3_load(cloud.position[i]));
        double x = s->camera.cx - s->camera.fx * p.x / p.z, slack = 0.005 - p.z / s->camera.fx;
        double y = s->camera.cy + s->camera.fy * p.y / p.z;
        if (x < 0 || y < 0 || x >= image->width || y >= image->height)
            continue;
        double z = value(image, "Z", (uint32_t)x, (uint32_t)y);
        worst = fmax(worst, isfinite(z) ? fabs(z + p.z) / slack : INFINITY);
    }
    points_release(&cloud);
    return worst;
}

/* Of a patch of a sphere, semi-axis a, a linear field misses at most a^3 / 2 of a slope. Its plane
 * lies within the tolerance, all that is averaged within four of them along the ray, and within
 * 0.85 of the middle that is up to 1.61 times as far across it. A wrong sign, or a mean of both, is
 * off by more than 1. */
static double sphere_bound(const struct stp_scene *scene, double tolerance)
{
    double a = (double)scene->facts.radius_max;
    return a * a * a / 2 + 1.61 * 4 * tolerance;
}

/* Against the sphere's normal where the ray meets it. */
static double check_sphere(const struct hard_scene *s, const struct stp_image *image)
{
    double worst = 0;
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        struct hard_seen seen = hard_see(s, image, k);
        struct vec3 along = v3_unit(seen.along);
        double middle = -v3_dot(seen.start, along);
        struct vec3 nearest = v3_add(seen.start, v3_scale(along, middle));
        if (v3_length(nearest) > 0.85)
            continue;
        double half = sqrt(1 - v3_dot(nearest, nearest));
        struct vec3 hit = v3_sub(nearest, v3_scale(along, half));
        worst = fmax(worst, seen.covered ? hard_angle(seen.normal, hit) / s->truth[0] : INFINITY);
    }
    return worst;
}

static void opposed(const struct hard_options *o, struct hard_scene *s)
{
    /* A patch of radius a lies within a^2 / 2: of four samples and more. */
    const double tolerance = 7.5 / (double)o->points;
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    uint32_t seed = o->seed;
    cloud.colored = false;
    for (size_t i = 0; i < cloud.count; i++)
        for (int k = 0, turn = hard_random(&seed) < 0.5; k < 3; k++)
            cloud.normal[i][k] *= turn ? -1 : 1;
    struct stp_fit made = hard_fit(s, &cloud, 0, tolerance);
    assert_true(!made.signs && made.splats < cloud.count / 3);
    s->truth[0] = sphere_bound(s->scene, tolerance);
    hard_look_at_fit(o, s, v3(0, 0, 0), 4.6);
    points_release(&cloud);
}

static void duplicates(const struct hard_options *o, struct hard_scene *s)
{
    const double tolerance = 0.01;
    struct hard_points once = points_ball(o, v3(0, 0, 0), 0), thrice = points_make(3 * once.count);
    once.colored = false;
    for (size_t i = 0; i < 3 * once.count; i++) {
        size_t k = i % once.count;
        points_add(&thrice, v3_load(once.position[k]), v3_loadf(once.normal[k]),
                   (double)once.radius[k]);
    }
    struct hard_scene single = { 0 };
    struct stp_fit a = hard_fit(&single, &once, 0.05, tolerance);
    struct stp_fit b = hard_fit(s, &thrice, 0.05, tolerance);
    assert_int_equal(a.splats, b.splats);
    s->twin = single.scene;
    hard_look_at_fit(o, s, v3(0, 0, 0), 4.6);
    s->twin_camera = s->camera;
    points_release(&once);
    points_release(&thrice);
}

static void of_zero(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    struct stp_fit made = hard_fit(s, &cloud, 0, 0);
    s->twin = points_scene(&cloud, 0, 2);
    assert_int_equal(made.splats, cloud.count);
    hard_look_at_fit(o, s, v3(0, 0, 0), 4.6);
    s->twin_camera = s->camera;
    points_release(&cloud);
}

static void of_all(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    cloud.colored = false;
    struct stp_fit made = hard_fit(s, &cloud, 0, 2);
    assert_true(made.splats <= 64);
    hard_look_at_fit(o, s, v3(0, 0, 0), 6);
    points_release(&cloud);
}

/* A splat whose normals span 75 degrees is 1.2 of the ball's radius wide and stands off the sphere
 * by 0.2 (1 - cos 37.5 degrees), by more than its neighbour or by less: that slit beside its width
 * is the share of rays through the ball of half the size that may miss both. */
static double check_of_all(const struct hard_scene *s, const struct stp_image *image)
{
    double lost = 0, all = 0;
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        struct hard_seen seen = hard_see(s, image, k);
        bool through = v3_length(v3_cross(seen.start, v3_unit(seen.along))) < 0.5;
        lost += through && !seen.covered;
        all += through;
    }
    return lost / fmax(1, all) / (0.2 / 1.2);
}

static const struct hard_case cases[] = {
    { "One, two and three samples on a line",
      "A splat a line, its slopes across the line 0: every sample's pixel shows its line, within "
      "the "
      "tolerance",
      few, check_few, 0, 0, 0, 0, NULL, 0 },
    { "Opposed normals in one neighbourhood",
      "Half of all samples turned about at random: the sphere's normals, to the third order in a "
      "splat's size and a few tolerances",
      opposed, check_sphere, HARD_FIT_GROUPED, 0, HARD_FIT_PACKED, 0, NULL, 0 },
    { "Every sample three times", "The bits of the fit of one each", duplicates, NULL,
      HARD_FIT_GROUPED, INFINITY, HARD_FIT_PACKED, 0, NULL, 0 },
    { "A tolerance of zero", "The bits of the points: each stays a splat of its own", of_zero, NULL,
      HARD_FIT_GROUPED, INFINITY, HARD_FIT_PACKED, 0, NULL, 0 },
    { "A tolerance of the whole size",
      "Few splats, none of more than 75 degrees of normals: sound, and slits of a sixth at most",
      of_all, check_of_all, HARD_FIT_GROUPED, 0, HARD_FIT_PACKED, 0, NULL, 0 },
};
const struct hard_family hard_fits = { "fits", cases, sizeof cases / sizeof *cases };
