/* Few points, no points, and very many in one place. */
#include "hard.h"

static void one_point(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(1);
    struct stp_frame_params frame = {
        .azimuth = o->turn, .elevation = o->rise, .width = o->width, .height = o->height
    };
    points_add(&cloud, v3(3, -4, 5), v3(0, 0, 1), 0);
    cloud.no_normals = cloud.no_radii = true;
    s->scene = points_scene(&cloud, 0, 2);
    assert_int_equal(stp_camera_frame(NULL, s->scene, &frame, &s->camera), STP_OK);
    points_release(&cloud);
}

/* No normal can be known: the disc faces the eye, framed to fill the height but for its margins. */
static double check_one_point(const struct hard_scene *s, const struct stp_image *image)
{
    double covered = 0, radius = 0.95 * fmin(image->width, image->height) / 2;
    for (uint32_t i = 0; i < image->width * image->height; i++)
        covered += isfinite(stp_image_find(image, "Z")->data.f[i]);
    return fabs(covered / (M_PI * radius * radius) - 1) / 0.1;
}

static void expect_no_points(struct device *device, const struct hard_points *cloud)
{
    struct stp_scene *scene = NULL;
    unsigned lines = device->lines;
    assert_int_equal(points_try(&device->env, cloud, 0, &scene), STP_ERROR_NO_POINTS);
    assert_null(scene);
    assert_int_equal(device->lines, lines + 1);
    assert_non_null(strstr(device->last, "no points"));
}

static void no_points(const struct hard_options *o, struct device *device)
{
    struct hard_points cloud = points_make(9);
    expect_no_points(device, &cloud);
    for (int i = 0; i < 9; i++)
        points_add(&cloud, v3(i % 2 ? NAN : INFINITY, 0, i), v3(0, 0, 1), 1);
    expect_no_points(device, &cloud);
    points_release(&cloud);
}

/* A million in one place. */
static struct stp_scene *copies(size_t count)
{
    struct hard_points cloud = points_make(count);
    for (size_t i = 0; i < count; i++)
        points_paint(&cloud, points_add(&cloud, v3(0.1, 0.2, 0.3), v3(0.3, 0.4, 0.8660254), 0.5),
                     v3(0.2, 0.5, 0.8));
    struct stp_scene *scene = points_scene(&cloud, 0, 2);
    points_release(&cloud);
    return scene;
}

/* Equal fragments average to themselves: what one disc gives, to 1/255 (packed keys). Where the
 * rasteriser adds them, that is a million roundings to float32: 10^6 2^-24 at worst. */
static void expect_one(const struct stp_image *image, const struct stp_image *one,
                       const struct hard_way *way)
{
    bool blends = way->method == STP_METHOD_TWO_PASS && way->path == STP_PATH_RASTER;
    double bound = blends ? 1e6 * 0x1p-24 : 1 / 255.0;
    static const char *const names[] = { "R", "G", "B", "N.X", "N.Y", "N.Z", "Z", "A" };
    for (unsigned k = 0; k < sizeof names / sizeof *names; k++) {
        const float *a = stp_image_find(image, names[k])->data.f;
        const float *b = stp_image_find(one, names[k])->data.f;
        for (size_t i = 0; i < (size_t)one->width * one->height; i++)
            if (!(a[i] == b[i] || fabs((double)a[i] - b[i]) <= bound))
                fail_msg("%s: %s is %g, not %g", way->name, names[k], a[i], b[i]);
    }
}

/* The pyramid takes one of them. */
static void expect_one_winner(struct device *device, const struct stp_scene *many,
                              const struct stp_scene *one, const struct stp_camera *camera)
{
    struct stp_render_params p = { .method = STP_METHOD_PYRAMID, .min_splat = -1 };
    struct stp_image *a = device_render(device, many, camera, &p);
    struct stp_image *b = device_render(device, one, camera, &p);
    expect_same_bits(a, b, "a million by the pyramid");
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void million(const struct hard_options *o, struct device *device)
{
    size_t count = 1000000;
    struct hard_options small = *o;
    small.width = small.height = 8; /* a million times a dozen pixels */
    struct stp_scene *one = copies(1), *many = copies(count);
    struct stp_camera camera = hard_look(&small, v3(0.1, 0.2, 0.3), 4, 30);
    struct stp_render_params p = { .min_splat = -1 };
    assert_int_equal(many->facts.duplicates, count - 1);
    hard_group(many);
    struct stp_image *truth = hard_reference(one, &camera, &p);
    for (unsigned w = 0; w < HARD_WAYS; w++) {
        struct stp_render_params way = hard_way_params(&hard_ways[w], &p);
        struct stp_image *image = hard_ways[w].method == STP_METHOD_REFERENCE
                                      ? hard_reference(many, &camera, &p)
                                      : device_render(device, many, &camera, &way);
        expect_one(image, truth, &hard_ways[w]);
        stp_image_destroy(&image);
    }
    expect_one_winner(device, many, one, &camera);
    stp_image_destroy(&truth);
    stp_scene_destroy(&one);
    stp_scene_destroy(&many);
}

/* A ball seen from so far away that it is a third of a pixel. */
static void one_pixel(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    s->scene = points_scene(&cloud, 0, 2);
    s->camera = hard_look(o, v3(0, 0, 0), 12.0 * o->height, 30);
    s->camera.cx += 0.5;
    s->camera.cy += 0.5;
    s->params = (struct stp_render_params){ .min_splat = 1.5 };
    s->truth[0] = INFINITY;
    for (size_t i = 0; i < cloud.count; i++) {
        struct vec3 p = m4_point(s->camera.world_to_camera, v3_load(cloud.position[i]));
        s->truth[0] = fmin(s->truth[0], -p.z);
    }
    points_release(&cloud);
}

/* From so far away rounding of depths decides which of hundreds of fragments are averaged.
 * Whichever they are, they lie within epsilon of the nearest, and each within its radius, epsilon's
 * size, of its centre: two epsilons and what radii differ. */
static double check_one_pixel(const struct hard_scene *s, const struct stp_image *image)
{
    double worst = 0, covered = 0;
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        double z = value(image, "Z", px, py);
        if (!isfinite(z))
            continue;
        covered++;
        worst = fmax(worst, fabs(z - s->truth[0]) / (2.5 * s->scene->objects[0].epsilon));
        worst = fmax(worst, value(image, "A", px, py) == 1 ? 0 : 2);
    }
    return covered >= 1 && covered <= 4 ? worst : 2;
}

static void ten_thousand(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(10000);
    uint32_t seed = o->seed;
    for (int i = 0; i < 10000; i++) {
        struct vec3 p = random_point(&seed, 0.05);
        struct vec3 n = v3_unit(v3_add(hard_towards_eye(o), random_point(&seed, 0.2)));
        size_t at = points_add(&cloud, p, n, 0.8 + 0.2 * hard_random(&seed));
        points_paint(&cloud, at, v3(hard_random(&seed), hard_random(&seed), hard_random(&seed)));
    }
    struct hard_options small = *o;
    small.width = 20;
    small.height = 15;
    s->scene = points_scene(&cloud, 1, 2);
    s->camera = hard_look(&small, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&cloud);
}

static const struct hard_case cases[] = {
    { "One point", "A disc that faces the eye, its framed area to a tenth", one_point,
      check_one_point, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "No points",
      "STP_ERROR_NO_POINTS and one line that says so, also where no coordinate is finite", NULL,
      NULL, 0, 0, 0, 0, no_points, HARD_PYRAMID_POINTS },
    { "A million coincident points",
      "The picture of one of them, to 1/255: equal fragments average to themselves. Two-pass by "
      "raster adds a million times in float32: 6 %; the pyramid gives the bits of one",
      NULL, NULL, 0, 0, 0, 0, million, HARD_PYRAMID_POINTS },
    { "All points in one pixel",
      "Its depth within two epsilons of the nearest; more fragments than any pixel keeps, resolved "
      "the "
      "second way",
      one_pixel, check_one_pixel, 0, 0, 0, 1, NULL, HARD_PYRAMID_POINTS },
    { "10^4 splats over each other", "To rounding: sums are integers of 64 bits", ten_thousand,
      NULL, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_crowds = { "crowds", cases, sizeof cases / sizeof *cases };
