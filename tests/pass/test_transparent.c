/* Transparencies fast, nearest and peel on a device, against the reference and against formulas. */
#include "group_device.h"

/* A group may lack 2 % of the surface by default: of a few sheets that is one. */
static const struct stp_cover_params whole = { .coverage = 1 };

static struct stp_image *picture(struct stp_scene *scene, const struct stp_camera *camera,
                                 struct stp_render_params p, enum stp_transparency transparency)
{
    p.transparency = transparency;
    if (!scene->cover.groups)
        assert_int_equal(stp_scene_cover(&device.env, scene, &whole), STP_OK);
    return device_render(&device, scene, camera, &p);
}

static double psnr_of(const struct stp_image *image, const struct stp_image *truth)
{
    struct stp_comparison c;
    assert_int_equal(stp_compare(NULL, image, truth, NULL, &c), STP_OK);
    return c.covered.psnr;
}

static double square_error(const struct stp_image *image, const struct stp_image *truth, size_t at)
{
    static const char *const names[] = { "R", "G", "B" };
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double a = stp_image_find(image, names[k])->data.f[at];
        double b = stp_image_find(truth, names[k])->data.f[at];
        sum += (a - b) * (a - b) / 3;
    }
    return sum;
}

/* What nearest gains over fast where a ray has two layers, three, and so on. */
#define MOST_LAYERS 8
static void gain_by_layers(const struct stp_image *truth, const struct stp_image *fast,
                           const struct stp_image *nearest)
{
    const float *layers = stp_image_find(truth, "layers")->data.f;
    double of_fast[MOST_LAYERS] = { 0 }, of_nearest[MOST_LAYERS] = { 0 };
    size_t pixels[MOST_LAYERS] = { 0 }, worse = 0, several = 0;
    for (size_t i = 0; i < (size_t)truth->width * truth->height; i++) {
        unsigned k = layers[i] < MOST_LAYERS ? (unsigned)layers[i] : MOST_LAYERS - 1;
        double a = square_error(fast, truth, i), b = square_error(nearest, truth, i);
        of_fast[k] += a;
        of_nearest[k] += b;
        pixels[k]++;
        several += k >= 2;
        worse += k >= 2 && sqrt(b) > sqrt(a) + 1.0 / 255;
    }
    assert_true(pixels[2] >= 5000 && worse * 100 <= several);
    for (unsigned k = 2; k < MOST_LAYERS; k++)
        if (pixels[k] >= 50) {
            double gain = 10 * log10(of_fast[k] / of_nearest[k]);
            if (getenv("STP_TEST_VERDICTS"))
                print_message("%u layers: %zu pixels, nearest gains %.1f dB\n", k, pixels[k], gain);
            assert_true(gain >= 1);
        }
}

/* Of groups that cover all of the surface. Fast errs in the nearest layer and in those behind it,
 * nearest in the latter only. Where the two cancel, fast is better by luck: nearest is off by r,
 * fast by r and a difference e of the other sign, and of a size within (0, 2 r). Were one sign as
 * likely as the other, half of the pixels with such an e would be worse than fast, and by chance a
 * few more. Held of this scene, not proven of all: docs/results/transparency.md has models where it
 * is 0.9 to 1.4 of that. All by more than a step of 8 bits. */
static void worse_by_luck_only(const struct stp_image *truth, const struct stp_image *fast,
                               const struct stp_image *nearest)
{
    const double step = 1.0 / 255;
    size_t worse = 0, better = 0, coins = 0;
    for (size_t i = 0; i < (size_t)truth->width * truth->height; i++) {
        double of_fast = sqrt(square_error(fast, truth, i));
        double r = sqrt(square_error(nearest, truth, i)), e = sqrt(square_error(fast, nearest, i));
        worse += r > of_fast + step;
        better += of_fast > r + step;
        coins += e > step && e < 2 * r - step;
    }
    if (getenv("STP_TEST_VERDICTS"))
        print_message("nearest worse in %zu pixels, better in %zu; %zu coins\n", worse, better,
                      coins);
    assert_true((double)worse <= 0.5 * (double)coins + 1.5 * sqrt((double)coins));
    assert_true(better > 10 * worse);
}

/* Peel by compute, and by the rasteriser. */
#define WAYS 4
static const struct {
    enum stp_transparency transparency;
    enum stp_path path;
} ways[WAYS] = { { STP_TRANSPARENCY_FAST, STP_PATH_AUTO },
                 { STP_TRANSPARENCY_NEAREST, STP_PATH_AUTO },
                 { STP_TRANSPARENCY_PEEL, STP_PATH_COMPUTE },
                 { STP_TRANSPARENCY_PEEL, STP_PATH_RASTER } };

static struct stp_image *picture_by(struct stp_scene *scene, const struct stp_camera *camera,
                                    struct stp_render_params p, unsigned way)
{
    p.path = ways[way].path;
    return picture(scene, camera, p, ways[way].transparency);
}

/* A ball with waves, four discs at a place, seen through from outside. */
static struct stp_scene *ball(size_t count, float opacity)
{
    struct stp_scene *scene = scene_make(count, 1, 3.6 / sqrt((double)count));
    uint32_t seed = 5;
    for (size_t i = 0; i < count; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)count;
        seed = seed * 1664525u + 1013904223u;
        double a = seed * 0x1p-32 * 2 * M_PI, r = sqrt(1 - z * z);
        struct vec3 n = v3(r * cos(a), r * sin(a), z);
        scene_add(scene, v3_add(n, v3(0, 0, -4)), n, 3.6 / sqrt((double)count));
        scene_fade(scene, i, opacity);
    }
    scene_finish(scene);
    scene->facts.uniform_opacity = true;
    return scene;
}

/* How far Algorithms 2 and 3 may be from exact layers on a closed surface, where each ray has two:
 * by what is made where nothing is asked for, and by four groups that cover all of it. */
static void errors_of_a_ball(void **state)
{
    const struct stp_cover_params none = { 0 }, four_whole = { .groups = 4, .coverage = 1 };
    for (int i = 0; i < 4; i++) {
        struct stp_scene *scene = ball(20000, i % 2 ? 0.6f : 0.3f);
        struct stp_cover_params asked = i < 2 ? none : four_whole;
        assert_int_equal(stp_scene_cover(&device.env, scene, &asked), STP_OK);
        struct stp_camera camera = flat_camera(160, 160, 260);
        struct stp_render_params p = { .min_splat = -1 },
                                 counting = { .min_splat = -1, .aovs = STP_AOV_LAYERS };
        struct stp_image *truth = picture(scene, &camera, counting, STP_TRANSPARENCY_REFERENCE);
        struct stp_image *fast = picture(scene, &camera, p, STP_TRANSPARENCY_FAST);
        struct stp_image *nearest = picture(scene, &camera, p, STP_TRANSPARENCY_NEAREST);
        struct stp_image *peel = picture(scene, &camera, p, STP_TRANSPARENCY_PEEL);
        if (getenv("STP_TEST_VERDICTS"))
            print_message("%u groups, opacity %.1f: fast %.1f dB, nearest %.1f, peel %.1f\n",
                          scene->facts.cover.groups, i % 2 ? 0.6 : 0.3, psnr_of(fast, truth),
                          psnr_of(nearest, truth), psnr_of(peel, truth));
        assert_true(psnr_of(fast, truth) >= 28);
        assert_true(psnr_of(nearest, truth) >= fmax(33, psnr_of(fast, truth) + 1));
        assert_true(psnr_of(peel, truth) >= 60);
        gain_by_layers(truth, fast, nearest);
        if (asked.groups == 4)
            worse_by_luck_only(truth, fast, nearest);
        stp_image_destroy(&truth);
        stp_image_destroy(&fast);
        stp_image_destroy(&nearest);
        stp_image_destroy(&peel);
        stp_scene_destroy(&scene);
    }
}

static float value_at(const struct stp_image *image, const char *name)
{
    size_t middle = (size_t)(image->height / 2) * image->width + image->width / 2;
    return stp_image_find(image, name)->data.f[middle];
}

/* `count` discs across the middle of the picture, `step` apart. */
static struct stp_scene *sheets(size_t count, double step, float opacity)
{
    struct stp_scene *scene = scene_make(count, 1, 0.1);
    for (size_t k = 0; k < count; k++) {
        scene_add(scene, v3(0, 0, -5 - step * (double)k), v3(0, 0, 1), 2);
        scene_fade(scene, k, opacity);
    }
    scene_finish(scene);
    return scene;
}

static void closed_forms(void **state)
{
    static const struct {
        size_t layers;
        float opacity;
    } cases[] = { { 1, 0.3f },   { 2, 0.6f },    { 8, 0.3f },
                  { 300, 0.3f }, { 300, 1e-6f }, { 300, 0.01f } };
    for (unsigned i = 0; i < WAYS * sizeof cases / sizeof *cases; i++) {
        size_t layers = cases[i / WAYS].layers;
        float opacity = cases[i / WAYS].opacity;
        struct stp_scene *scene = sheets(layers, 0.21, opacity);
        struct stp_camera camera = flat_camera(21, 17, 8);
        struct stp_render_params p = { .min_splat = -1, .peel_layers = 300 };
        struct stp_image *image = picture_by(scene, &camera, p, i % WAYS);
        double alpha = -expm1((double)layers * log1p(-(double)opacity));
        close_to(value_at(image, "A"), alpha, 1e-4 * alpha + 1e-7);
        close_to(value_at(image, "R"), 0.84 * alpha, 1e-3 * alpha + 1e-7); /* 0.8 * 0.8 + 0.2 */
        close_to(value_at(image, "Z"), 5, 1e-4);
        close_to(value_at(image, "N.Z"), 1, 1e-4);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* k layers and no more. */
static void peels_as_many_as_asked(void **state)
{
    struct stp_scene *scene = sheets(20, 0.21, 0.25f);
    struct stp_camera camera = flat_camera(21, 17, 8);
    for (unsigned k = 1; k <= 20; k += 3) {
        unsigned way = 2 + k % 2;
        struct stp_render_params p = { .min_splat = -1, .peel_layers = k, .aovs = STP_AOV_LAYERS };
        struct stp_image *image = picture_by(scene, &camera, p, way);
        close_to(value_at(image, "A"), 1 - pow(0.75, k), 1e-5);
        assert_true(value_at(image, "layers") == (float)k);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

/* Of a scene of unequal opacities, some of them 1: both ways of peeling against the reference. */
static void expect_peeled(struct stp_scene *scene, const struct stp_camera *camera, double least)
{
    scene->facts.mixed = true;
    scene->facts.uniform_opacity = false;
    struct stp_render_params p = { .min_splat = -1, .peel_layers = 12, .aovs = STP_AOV_LAYERS };
    struct stp_image *truth = picture(scene, camera, p, STP_TRANSPARENCY_REFERENCE);
    for (unsigned way = 2; way < WAYS; way++) {
        struct stp_image *image = picture_by(scene, camera, p, way);
        struct stp_comparison c;
        assert_int_equal(stp_compare(NULL, image, truth, NULL, &c), STP_OK);
        if (c.covered.psnr < least)
            fail_msg("way %u: %.1f dB of %.0f", way, c.covered.psnr, least);
        stp_image_destroy(&image);
    }
    stp_image_destroy(&truth);
}

/* Opacities that differ within a layer are averaged with its weights, in both ways of peeling. What
 * is opaque is a ball within the ball, or stands anywhere on the same surface: within the layers.
 */
static void peels_varying_opacities(void **state)
{
    for (size_t every = 3; every <= 9; every += 6) {
        struct stp_scene *scene = ball(3000, 0.5f);
        for (size_t i = 0; i < 3000; i++) {
            double *at = scene->splats.position[i];
            scene_fade(scene, i, i % every == 0 ? 1 : 0.05f + 0.1f * (float)(i % 8));
            for (int a = 0; every == 3 && i % every == 0 && a < 3; a++)
                at[a] = (a == 2 ? -4 : 0) + (at[a] - (a == 2 ? -4 : 0)) / 2;
        }
        struct stp_camera flat = flat_camera(64, 64, 100), near = plain_camera(64, 64, 160);
        expect_peeled(scene, every == 9 ? &near : &flat, 60);
        stp_scene_destroy(&scene);
    }
}

/* Discs across the picture: two of one layer; within epsilon of them one that is opaque; as deep as
 * that, and still within epsilon, others that must not be seen. Small and large, before the eye
 * and, orthographic, behind it. */
static void opaque_within_a_layer(void **state)
{
    static const struct {
        double step;
        float opacity;
    } discs[] = { { 0, 0.2f }, { 2, 0.9f }, { 1, 0.4f }, { 2, 1 }, { 2, 0.9f }, { 3, 0.9f } };
    for (unsigned i = 0; i < 6; i++) {
        unsigned size = i % 2 ? 48 : 17;
        double z = i < 4 ? -4 : 3; /* binary fractions: what is as deep is so to the bit */
        struct stp_scene *scene = scene_make(6, 1, 0.125);
        for (size_t k = 0; k < 6; k++) {
            scene_add(scene, v3(0, 0, z - 0.03125 * discs[k].step), v3(0, 0, 1), 2);
            scene_paint(scene, k, k % 3 == 0, k % 3 == 1, k % 3 == 2);
            scene_fade(scene, k, discs[k].opacity);
        }
        scene_finish(scene);
        struct stp_camera camera =
            i < 2 ? plain_camera(size, size, size) : flat_camera(size, size, size / 3.0);
        if (i >= 4)
            camera.near_depth = -10;
        expect_peeled(scene, &camera, 90);
        stp_scene_destroy(&scene);
    }
}

/* An opaque disc among the sheets ends the ray, and hides what lies behind. */
static void opaque_among_transparent(void **state)
{
    for (unsigned i = 0; i < WAYS; i++) {
        struct stp_scene *scene = sheets(6, 0.21, 0.3f);
        struct stp_camera camera = flat_camera(21, 17, 8);
        scene_fade(scene, 3, 1);
        scene->facts.mixed = true;
        scene->facts.uniform_opacity = false;
        struct stp_render_params p = { .min_splat = -1 };
        struct stp_image *image = picture_by(scene, &camera, p, i);
        close_to(value_at(image, "A"), 1, 1e-5);
        close_to(value_at(image, "R"), 0.84, 1e-3);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* Premultiplied: over black and over white, and solved back. */
static void over_two_backgrounds(void **state)
{
    static const float black[] = { 0, 0, 0, 1 }, white[] = { 1, 1, 1, 1 };
    for (unsigned i = 0; i < WAYS; i++) {
        struct stp_scene *scene = ball(2000, 0.4f);
        struct stp_camera camera = flat_camera(64, 64, 100);
        struct stp_render_params p = { .min_splat = -1 };
        struct stp_image *none = picture_by(scene, &camera, p, i);
        p.background = black;
        struct stp_image *dark = picture_by(scene, &camera, p, i);
        p.background = white;
        struct stp_image *light = picture_by(scene, &camera, p, i);
        const float *a = stp_image_find(none, "A")->data.f, *c = stp_image_find(none, "R")->data.f;
        const float *b = stp_image_find(dark, "R")->data.f, *w = stp_image_find(light, "R")->data.f;
        for (size_t at = 0; at < 64 * 64; at++) {
            assert_true(isfinite(c[at]) && a[at] >= 0 && a[at] <= 1 + 1e-5);
            close_to(b[at], c[at], 1e-6);
            close_to(1 - (w[at] - b[at]), a[at], 1e-5);
        }
        stp_image_destroy(&none);
        stp_image_destroy(&dark);
        stp_image_destroy(&light);
        stp_scene_destroy(&scene);
    }
}

/* From inside, and twice: nothing that is not finite, and the same bits. */
static void inside_and_again(void **state)
{
    for (unsigned i = 0; i < WAYS; i++) {
        struct stp_scene *scene = ball(2000, 0.3f);
        struct stp_camera camera = flat_camera(48, 48, 20);
        camera.world_to_camera[11] = 3.9; /* near the middle of the ball */
        struct stp_render_params p = { .min_splat = -1 };
        struct stp_image *a = picture_by(scene, &camera, p, i);
        struct stp_image *b = picture_by(scene, &camera, p, i);
        expect_same_bits(a, b, "again");
        assert_true(value_at(a, "A") > 0.29f);
        stp_image_destroy(&a);
        stp_image_destroy(&b);
        stp_scene_destroy(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_of_a_ball),        cmocka_unit_test(closed_forms),
        cmocka_unit_test(peels_as_many_as_asked),  cmocka_unit_test(opaque_among_transparent),
        cmocka_unit_test(peels_varying_opacities), cmocka_unit_test(over_two_backgrounds),
        cmocka_unit_test(inside_and_again),        cmocka_unit_test(opaque_within_a_layer),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
