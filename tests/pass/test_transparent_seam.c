/* The seam of ZP Eq. 6. Where a surface crosses from one slab to the next, two fragments of one
 * layer may both pass. Shifting the slabs of the groups against each other does not make those
 * fewer: it parts the images' seams, so that each shows with a K-th of the weight. */
#include "group_device.h"

#define SIZE    192
#define FOCAL   96.0
#define DISCS   6000
#define EPSILON 0.1
#define SPREAD  (0.2 * EPSILON) /* of the discs' depths: below EPSILON / K, so that seams part */
#define ALPHA   0.5
#define BINS    20

static double dice(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed * 0x1p-32;
}

/* Depth 4 + x over the picture, some twenty slabs, of discs that lie up to SPREAD behind that: one
 * layer everywhere. */
static struct stp_scene *slope(void)
{
    struct stp_scene *scene = scene_make(DISCS, 1, EPSILON);
    uint32_t seed = 7;
    for (size_t i = 0; i < DISCS; i++) {
        double x = 2.3 * (dice(&seed) - 0.5), y = 2.3 * (dice(&seed) - 0.5);
        scene_add(scene, v3(x, y, -4 - x - SPREAD * dice(&seed)), v3(1, 0, 1), 0.06);
        scene_fade(scene, i, (float)ALPHA);
    }
    scene_finish(scene);
    const struct stp_cover_params four = { .groups = 4 };
    assert_int_equal(stp_scene_cover(&device.env, scene, &four), STP_OK);
    assert_int_equal(scene->facts.cover.groups, 4);
    return scene;
}

/* How much more opaque than the layer a picture is. */
struct seam {
    double mean, line,
        worst; /* over pixels; of the phase within a slab that is worst; of a pixel */
};

static struct seam seam_of(const struct stp_image *image, const struct stp_plan *plan)
{
    const float *alpha = stp_image_find(image, "A")->data.f;
    double sum[BINS] = { 0 }, count[BINS] = { 0 }, total = 0, pixels = 0;
    struct seam seam = { 0 };
    for (uint32_t y = SIZE / 16; y < SIZE - SIZE / 16; y++)
        for (uint32_t x = SIZE / 16; x < SIZE - SIZE / 16; x++) {
            double depth = 4 + (x + 0.5 - SIZE / 2.0) / FOCAL, more;
            double phase = (depth - (double)plan->frame.depth_low) / EPSILON;
            unsigned bin = (unsigned)(BINS * (phase - floor(phase))) % BINS;
            if (alpha[(size_t)y * SIZE + x] == 0)
                continue; /* the discs are scattered: a few pixels see none */
            more = (double)alpha[(size_t)y * SIZE + x] - ALPHA;
            sum[bin] += more;
            count[bin]++;
            total += more;
            pixels++;
            seam.worst = fmax(seam.worst, fabs(more));
        }
    for (unsigned b = 0; b < BINS; b++)
        seam.line = fmax(seam.line, sum[b] / fmax(count[b], 1));
    assert_true(pixels > 0.99 * 0.75 * SIZE * SIZE);
    seam.mean = total / pixels;
    return seam;
}

/* shifted: as planned; else every group's slabs start at one depth, as Eq. 6 prints it. */
static struct seam seam_by(const struct stp_scene *scene, enum stp_transparency way, bool shifted)
{
    struct stp_camera camera = flat_camera(SIZE, SIZE, FOCAL);
    struct stp_render_params p = { .min_splat = -1, .transparency = way };
    struct stp_plan *plan = NULL;
    assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
    for (uint32_t i = 0; i < plan->pass_count; i++)
        plan->pass[i].shift *= shifted ? 1 : 0;
    struct stp_image *image = device_render_plan(&device, scene, plan);
    struct seam seam = seam_of(image, plan);
    if (getenv("STP_TEST_VERDICTS"))
        print_message("%s%s: alpha too high by %.5f in the mean, %.5f along a line, %.5f at most\n",
                      stp_transparency_name(way), shifted ? "" : ", unshifted", seam.mean,
                      seam.line, seam.worst);
    stp_image_destroy(&image);
    stp_plan_destroy(&plan);
    return seam;
}

/* A pixel whose K images all count the layer twice is too opaque by alpha (1 - alpha). Shifted by
 * more than the discs' spread, no two images have their seams at one depth: a line has a K-th. */
static void shifted_seams(void **state)
{
    struct stp_scene *scene = slope();
    struct seam printed = seam_by(scene, STP_TRANSPARENCY_FAST, false);
    struct seam fast = seam_by(scene, STP_TRANSPARENCY_FAST, true);
    assert_true(printed.line > 0.02 && printed.worst <= ALPHA * (1 - ALPHA) + 1e-5);
    assert_true(fabs(fast.mean / printed.mean - 1) < 0.1);
    assert_true(fast.line < printed.line * (0.25 + 0.1)); /* bins have a few discs each */
    stp_scene_destroy(&scene);
}

/* The nearest layer apart has no slabs, nor has exact. */
static void without_slabs(void **state)
{
    struct stp_scene *scene = slope();
    assert_true(seam_by(scene, STP_TRANSPARENCY_NEAREST, true).worst < 1e-5);
    assert_true(seam_by(scene, STP_TRANSPARENCY_EXACT, true).worst < 1e-5);
    stp_scene_destroy(&scene);
}

static void cover(struct stp_scene *scene)
{
    const struct stp_cover_params whole = { .coverage = 1 };
    scene_finish(scene);
    assert_int_equal(stp_scene_cover(&device.env, scene, &whole), STP_OK);
}

#define SIDE 17
/* By fast, then by nearest. */
static struct stp_image *picture_by(const struct stp_scene *scene, int way)
{
    struct stp_camera camera = flat_camera(SIDE, SIDE, 8);
    struct stp_render_params p = { .min_splat = -1,
                                   .transparency =
                                       way ? STP_TRANSPARENCY_NEAREST : STP_TRANSPARENCY_FAST };
    return device_render(&device, scene, &camera, &p);
}

static double middle(const struct stp_image *image, const char *name)
{
    return (double)stp_image_find(image, name)->data.f[SIDE / 2 * SIDE + SIDE / 2];
}

/* A layer of twelve discs within a fifth of their object's epsilon, which is twenty times that of
 * the sheet behind them: slabs of the least epsilon would count it up to three times a group. Steps
 * of shifted slabs are a quarter of an epsilon apart, so that one group of four may count it twice.
 */
static void epsilons_of_objects(void **state)
{
    struct stp_scene *scene = scene_make(13, 2, EPSILON);
    scene->objects[1].epsilon = EPSILON / 20;
    for (size_t i = 0; i < 12; i++)
        scene_add(scene, v3(0, 0, -5 - SPREAD * (double)(i * 5 % 12) / 11), v3(0, 0, 1), 2);
    scene_assign(scene, scene_add(scene, v3(0, 0, -6), v3(0, 0, 1), 2), 1);
    for (size_t i = 0; i < 13; i++)
        scene_fade(scene, i, (float)ALPHA);
    cover(scene);
    for (int way = 0; way < 2; way++) {
        struct stp_image *image = picture_by(scene, way);
        double alpha = middle(image, "A");
        double twice = 1 - pow(1 - ALPHA, 2), thrice = 1 - pow(1 - ALPHA, 3);
        if (getenv("STP_TEST_VERDICTS"))
            print_message("opacity %.4f of two layers\n", alpha);
        assert_true(alpha >= twice - 1e-5 && alpha <= (3 * twice + thrice) / 4 + 1e-5);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

/* A coarse object's opaque disc stands in front of a fine one's veil, within the coarse epsilon. */
static void opaque_of_a_coarse_object(void **state)
{
    struct stp_scene *scene = scene_make(2, 2, EPSILON);
    scene->objects[1].epsilon = EPSILON / 20;
    scene_add(scene, v3(0, 0, -5), v3(0, 0, 1), 2);
    scene_assign(scene, scene_add(scene, v3(0, 0, -5 - EPSILON / 4), v3(0, 0, 1), 2), 1);
    scene_fade(scene, 0, 1);
    scene_fade(scene, 1, (float)ALPHA);
    cover(scene);
    for (int way = 0; way < 2; way++) {
        struct stp_image *image = picture_by(scene, way);
        double alpha = middle(image, "A");
        assert_true(fabs(alpha - 1) <= 1e-6 && fabs(middle(image, "Z") - 5) <= EPSILON / 8);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shifted_seams),
        cmocka_unit_test(without_slabs),
        cmocka_unit_test(epsilons_of_objects),
        cmocka_unit_test(opaque_of_a_coarse_object),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
