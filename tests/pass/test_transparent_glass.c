/* Glass by Algorithms 2 and 3: the layers that a ray crosses are told by its opacity alone. Where
 * all layers are alike that is what exact counts; where they are not, what is let through still is.
 */
#include "group_device.h"
#include "surroundings.h"

static const struct stp_optics bent = { .ior = { 1.05f, 1.1f, 1.2f } };
static const struct stp_optics tinted = { .ior = { 1.05f, 1.1f, 1.2f },
                                          .absorption = { 0.05f, 0.2f, 0.6f },
                                          .thickness = 1 };
static const struct stp_optics straight = { .ior = { 1, 1, 1 } };
static const struct stp_optics mirror = { .reflectance = { 0.5f, 0.3f, 0.9f } };

/* Tilted sheets across the picture, far enough apart to be layers. */
static struct stp_scene *sheets(size_t count, const float opacity[2],
                                const struct stp_optics *optics)
{
    struct stp_scene *scene = scene_make(count, 1, 0.1);
    for (size_t k = 0; k < count; k++) {
        scene_add(scene, v3(0, 0, -5 - 0.31 * (double)k), v3(0.3, 0.1, 1), 3);
        scene_fade(scene, k, opacity[k % 2]);
    }
    scene_finish(scene);
    scene->facts.uniform_opacity = opacity[0] == opacity[1];
    set_optics(scene, 0, optics);
    surround(scene, 64, 32, smooth_sky, NULL);
    const struct stp_cover_params whole = { .coverage = 1 };
    assert_int_equal(stp_scene_cover(&device.env, scene, &whole), STP_OK);
    return scene;
}

static void expect_as_exact(struct stp_scene *scene, struct stp_render_params p, double tolerance,
                            const char *what)
{
    static const char *const channels[] = { "R", "G", "B", "A" };
    struct stp_camera camera = plain_camera(17, 17, 40);
    p.min_splat = -1;
    p.transparency = STP_TRANSPARENCY_EXACT;
    struct stp_image *truth = device_render(&device, scene, &camera, &p);
    for (int way = 0; way < 2; way++) {
        p.transparency = way ? STP_TRANSPARENCY_NEAREST : STP_TRANSPARENCY_FAST;
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        for (int c = 0; c < 4; c++)
            for (size_t i = 0; i < 17 * 17; i++) {
                double is = stp_image_find(image, channels[c])->data.f[i];
                double should = stp_image_find(truth, channels[c])->data.f[i];
                if (!(fabs(is - should) <= tolerance))
                    fail_msg("%s, way %d, %s of %zu: %g, not %g", what, way, channels[c], i, is,
                             should);
            }
        stp_image_destroy(&image);
    }
    stp_image_destroy(&truth);
    stp_scene_destroy(&scene);
}

static void layers_alike(void **state)
{
    static const size_t counts[] = { 1, 2, 5, 30 };
    static const float opacities[][2] = { { 0.3f, 0.3f }, { 0.05f, 0.05f }, { 1e-6f, 1e-6f } };
    for (unsigned i = 0; i < 24; i++) {
        const struct stp_render_params p = { .layers =
                                                 i % 2 ? STP_LAYERS_SINGLE : STP_LAYERS_MULTI };
        const struct stp_optics *optics = i / 2 % 4 / 2 ? &tinted : &bent;
        expect_as_exact(sheets(counts[i / 2 % 4], opacities[i / 8], optics), p, 4e-3, "alike");
    }
}

/* Nothing is bent: what is let through is all that shows, and it does not hang on a count. */
static void opacities_that_differ(void **state)
{
    const float opacity[2] = { 0.15f, 0.6f };
    for (size_t count = 2; count <= 6; count++)
        expect_as_exact(sheets(count, opacity, &straight), (struct stp_render_params){ 0 }, 1e-3,
                        "differ");
}

/* An opaque sheet behind: it mirrors, ends the ray, and nothing behind it shows. */
static void opaque_behind(void **state)
{
    const float opacity[2] = { 0.3f, 0.3f };
    for (int i = 0; i < 2; i++) {
        struct stp_scene *scene = sheets(3, opacity, i ? &mirror : &bent);
        scene_fade(scene, 2 * (size_t)i, 1); /* the nearest; the last */
        scene->facts.mixed = true;
        scene->facts.uniform_opacity = false;
        expect_as_exact(scene, (struct stp_render_params){ .background = NULL }, 4e-3, "opaque");
    }
}

/* A closed surface, from outside: finite, and near the truth. */
static void a_ball(void **state)
{
    struct stp_scene *scene = scene_make(4000, 1, 0.06);
    for (size_t i = 0; i < 4000; i++) {
        double z = 1 - (2 * (double)i + 1) / 4000, a = (double)i * 2.39996322972865332;
        struct vec3 n = v3(sqrt(1 - z * z) * cos(a), sqrt(1 - z * z) * sin(a), z);
        scene_fade(scene, scene_add(scene, v3_add(n, v3(0, 0, -4)), n, 0.06), 0.2f);
    }
    scene_finish(scene);
    scene->facts.uniform_opacity = true;
    set_optics(scene, 0, &tinted);
    surround(scene, 64, 32, smooth_sky, NULL);
    const struct stp_cover_params whole = { .coverage = 1 };
    assert_int_equal(stp_scene_cover(&device.env, scene, &whole), STP_OK);
    struct stp_camera camera = plain_camera(65, 65, 36);
    struct stp_render_params p = { .min_splat = -1, .transparency = STP_TRANSPARENCY_EXACT };
    struct stp_image *truth = device_render(&device, scene, &camera, &p);
    for (int way = 0; way < 2; way++) {
        struct stp_comparison c;
        p.transparency = way ? STP_TRANSPARENCY_NEAREST : STP_TRANSPARENCY_FAST;
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        assert_int_equal(stp_compare(NULL, image, truth, NULL, &c), STP_OK);
        assert_true(c.covered.mean_absolute < 0.02);
        for (size_t i = 0; i < 65 * 65; i++) {
            float r = stp_image_find(image, "R")->data.f[i], alpha;
            alpha = stp_image_find(image, "A")->data.f[i];
            assert_true(isfinite(r) && r >= 0 && (alpha == 0 || alpha == 1));
        }
        stp_image_destroy(&image);
    }
    stp_image_destroy(&truth);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_alike),
        cmocka_unit_test(opacities_that_differ),
        cmocka_unit_test(opaque_behind),
        cmocka_unit_test(a_ball),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
