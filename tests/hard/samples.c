/* Anti-aliasing: samples converge to the reference's own many, and a cloud of many points a pixel
 * neither aliases nor sparkles. */
#include "hard.h"

#define SHIFTS 8

static double rmse_to(const struct stp_image *image, const struct stp_image *truth)
{
    struct stp_comparison error;
    struct stp_compare_params compare = { 0 };
    assert_int_equal(stp_compare(NULL, image, truth, &compare, &error), STP_OK);
    return error.all.rmse;
}

static void say(const struct hard_options *o, const char *format, double a, double b, double c)
{
    FILE *file = o->table ? fopen(o->table, "a") : NULL;
    if (getenv("STP_TEST_VERDICTS"))
        print_message(format, a, b, c);
    if (!file)
        return;
    fprintf(file, format, a, b, c);
    fclose(file);
}

/* Strata lessen the error of an edge that crosses a pixel at least as fast as chance does: N^-1/2
 * of N samples. Fourfold samples have to halve it, to within a quarter for luck; but from the
 * first, which lies in the middle and is better than chance, it only has to fall. */
static void converging(const struct hard_options *o, struct device *device)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    struct stp_scene *scene = points_scene(&cloud, 0, 2);
    struct stp_camera camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    struct stp_render_params p = { .min_splat = -1, .samples = 1024 };
    struct stp_image *truth = hard_reference(scene, &camera, &p);
    double before[2] = { 0 };
    for (unsigned n = 1; n <= 64; n *= 4) {
        double error[2];
        for (int i = 0; i < 2; i++) {
            p.method = i ? STP_METHOD_TWO_PASS : STP_METHOD_EXACT;
            p.samples = n;
            struct stp_image *image = device_render(device, scene, &camera, &p);
            error[i] = rmse_to(image, truth);
            if (n > 1 && error[i] > (n > 4 ? 0.625 : 1) * before[i])
                fail_msg("%u samples: %g, of %g", n, error[i], before[i]);
            before[i] = error[i];
            stp_image_destroy(&image);
        }
        say(o, "| %.0f | %.5f | %.5f |\n", n, error[0], error[1]);
    }
    stp_image_destroy(&truth);
    stp_scene_destroy(&scene);
    points_release(&cloud);
}

/* Of every pixel that all pictures cover, how its red moves about its mean; the root of the mean of
 * the squares. */
static double sparkle(struct stp_image *const image[SHIFTS])
{
    size_t count = (size_t)image[0]->width * image[0]->height, inside = 0;
    double squares = 0;
    for (size_t i = 0; i < count; i++) {
        double sum = 0, square = 0, least = 1;
        for (int k = 0; k < SHIFTS; k++) {
            double r = stp_image_find(image[k], "R")->data.f[i];
            sum += r / SHIFTS;
            square += r * r / SHIFTS;
            least = fmin(least, stp_image_find(image[k], "A")->data.f[i]);
        }
        if (least == 1) {
            squares += fmax(0, square - sum * sum);
            inside++;
        }
    }
    assert_true(inside > 0);
    return sqrt(squares / (double)inside);
}

static double sparkle_of(struct device *device, const struct stp_scene *scene,
                         const struct stp_camera *camera, unsigned samples)
{
    struct stp_image *image[SHIFTS];
    struct stp_render_params p = { .samples = samples };
    for (int k = 0; k < SHIFTS; k++) {
        struct stp_camera shifted = *camera;
        shifted.cx += k / (double)SHIFTS;
        shifted.cy += k * 3 % SHIFTS / (double)SHIFTS;
        image[k] = device_render(device, scene, &shifted, &p);
    }
    double found = sparkle(image);
    for (int k = 0; k < SHIFTS; k++)
        stp_image_destroy(&image[k]);
    return found;
}

/* Fifteen points a pixel, every one of another grey: 0.25 to 0.75, so 0.14 about their mean. What a
 * picture may show of that when it moves by parts of a pixel is what a mean of the 13 dots on a
 * pixel's centre leaves, 0.14 / sqrt(13) = 0.04, were they all to change; samples average more of
 * them, and have to leave less than two thirds of it. */
static void dense(const struct hard_options *o, struct device *device)
{
    struct hard_options many = *o;
    uint32_t seed = o->seed;
    many.width = many.height = 64;
    many.points = 1000000 / 16; /* a million points on 256 x 256 */
    struct hard_points cloud = points_ball(&many, v3(0, 0, 0), 0.05);
    for (size_t i = 0; i < cloud.count; i++) {
        double grey = 0.25 + 0.5 * hard_random(&seed);
        points_paint(&cloud, i, v3(grey, grey, grey));
        cloud.radius[i] *= 0.5f;
    }
    struct stp_scene *scene = points_scene(&cloud, 0.02, 2);
    struct stp_camera camera = hard_look(&many, v3(0, 0, 0), 4.2, 30);
    double one = sparkle_of(device, scene, &camera, 1),
           nine = sparkle_of(device, scene, &camera, 9);
    say(o, "| sparkle of 1 sample %.4f, of 9 samples %.4f; bound %.4f | | |\n", one, nine, 0.04);
    if (!(one <= 0.04 && nine <= 0.667 * one))
        fail_msg("1 sample: %g, 9: %g", one, nine);
    stp_scene_destroy(&scene);
    points_release(&cloud);
}

static const struct hard_case cases[] = {
    { "Samples converge", "", NULL, NULL, 0, 0, 0, 0, converging, HARD_PYRAMID_POINTS },
    { "A dense cloud does not sparkle", "", NULL, NULL, 0, 0, 0, 0, dense, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_samples = { "samples", cases, sizeof cases / sizeof *cases };
