/* MKC's pyramid where it is hard: near sheets, odd sizes, one point and many in one pixel, the eye
 * in the cloud, an outlier. */
#include "group_device.h"

static struct stp_render_params pyramid_params(void)
{
    return (struct stp_render_params){ .method = STP_METHOD_PYRAMID, .min_splat = -1 };
}

static void add_sheet(struct stp_scene *scene, double z, double spacing, double half, bool red)
{
    uint32_t seed = 7;
    for (double y = -half; y <= half; y += spacing)
        for (double x = -half; x <= half; x += spacing) {
            double dx = 0.4 * spacing * (uniform(&seed) - 0.5);
            double dy = 0.4 * spacing * (uniform(&seed) - 0.5);
            size_t i = scene_add(scene, v3(x + dx, y + dy, -z), v3(0, 0, 1), 1.1 * spacing);
            scene_paint(scene, i, red ? 1 : 0, red ? 0 : 1, 0);
        }
}

/* Pixels that show what is behind; holes. */
struct leaks {
    size_t behind, holes;
};

static struct leaks count_leaks(const struct stp_image *image)
{
    struct leaks l = { 0 };
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            l.holes += !isfinite(value(image, "Z", x, y));
            l.behind += value(image, "G", x, y) > value(image, "R", x, y);
        }
    return l;
}

/* A dense green sheet behind a red one, from a gap of 1.5 radii of the red on: no green, also where
 * there is one red point a pixel on average, and discs of points that share their pixels with
 * nearer ones are all that hides it. */
static void leaking(void **state)
{
    static const double gaps[] = { 1.5, 2, 3, 6, 20, 100 };
    struct stp_camera camera = plain_camera(200, 200, 200);
    for (unsigned i = 0; i < sizeof gaps / sizeof *gaps; i++)
        for (double spacing = 0.01; spacing < 0.1; spacing *= 2.9) {
            struct stp_scene *scene = scene_make(200000, 1, spacing);
            add_sheet(scene, 2, spacing, 1.2, true);
            add_sheet(scene, 2 + gaps[i] * 1.1 * spacing, 0.007, 1.2, false);
            scene_finish(scene);
            struct stp_render_params p = pyramid_params();
            struct stp_image *image = device_render(&device, scene, &camera, &p);
            struct leaks l = count_leaks(image);
            if (l.behind || l.holes)
                fail_msg("gap %g, spacing %g: %zu behind, %zu holes", gaps[i], spacing, l.behind,
                         l.holes);
            stp_image_destroy(&image);
            stp_scene_destroy(&scene);
        }
}

/* A slanted sheet fills pictures of any size: no pixel is lost at an edge, and depths are its own.
 */
static void odd_sizes(void **state)
{
    static const uint32_t sizes[][2] = { { 1, 1 },    { 3, 3 },    { 2, 7 },    { 1023, 5 },
                                         { 5, 1023 }, { 1, 4096 }, { 4096, 1 }, { 129, 257 } };
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        uint32_t w = sizes[i][0], h = sizes[i][1];
        double longest = w > h ? w : h, spacing = 2.4 * 4.3 / longest;
        struct stp_camera camera = plain_camera(w, h, longest);
        struct stp_scene *scene = scene_make(1 << 20, 1, spacing);
        struct vec3 n = v3_unit(v3(0.3, 0.2, 1));
        double across = 2.6 * w / longest + 20 * spacing, down = 2.6 * h / longest + 20 * spacing;
        for (double y = -down / 2; y < down / 2; y += spacing)
            for (double x = -across / 2; x < across / 2; x += spacing)
                scene_add(scene, v3(x, y, -2 - 0.3 * x - 0.2 * y), n, 1.2 * spacing);
        scene_finish(scene);
        struct stp_render_params p = pyramid_params();
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        for (uint32_t y = 0; y < h; y++)
            for (uint32_t x = 0; x < w; x++) {
                double sx = (x + 0.5 - camera.cx) / camera.fx,
                       sy = (y + 0.5 - camera.cy) / camera.fy;
                double truth = 2 / (1 - 0.3 * sx + 0.2 * sy), z = value(image, "Z", x, y);
                if (!(fabs(z - truth) < 0.2 * spacing))
                    fail_msg("%u x %u: depth %g at %u, %u is not %g", w, h, z, x, y, truth);
            }
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* Nothing but finite numbers, and unit normals where something is; how many pixels are covered. */
static size_t expect_sound(const struct stp_image *image)
{
    static const char *const names[] = { "R", "G", "B", "A", "N.X", "N.Y", "N.Z" };
    size_t covered = 0;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++) {
        double length = 0;
        for (unsigned c = 0; c < 7; c++) {
            float v = stp_image_find(image, names[c])->data.f[i];
            assert_true(isfinite(v));
            length += c >= 4 ? (double)v * v : 0;
        }
        float z = stp_image_find(image, "Z")->data.f[i];
        assert_false(isnan(z));
        if (isfinite(z))
            assert_true(fabs(length - 1) < 1e-3);
        covered += isfinite(z);
    }
    return covered;
}

static size_t covered_by(struct stp_scene *scene, const struct stp_camera *camera)
{
    struct stp_render_params p = pyramid_params();
    scene_finish(scene);
    struct stp_image *image = device_render(&device, scene, camera, &p);
    size_t covered = expect_sound(image);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
    return covered;
}

static void one_point(void **state)
{
    struct stp_camera camera = plain_camera(64, 64, 64);
    for (double radius = 1e-6; radius < 1; radius *= 30) {
        struct stp_scene *scene = scene_make(1, 1, 0.1);
        scene_add(scene, v3(0.01, 0.02, -2), v3(0, 0, 1), radius);
        double pixels = M_PI * pow(radius * 32, 2);
        double covered = (double)covered_by(scene, &camera);
        assert_true(covered >= 1 && covered >= pixels - 2 * sqrt(pixels) && /* all, and no more */
                    covered <= pixels + 8 * sqrt(pixels) + 4);
    }
}

static void one_pixel(void **state)
{
    uint32_t seed = 3;
    struct stp_camera camera = plain_camera(32, 32, 32);
    struct stp_scene *scene = scene_make(20000, 1, 0.1);
    for (int i = 0; i < 20000; i++)
        scene_add(scene, v3(0.02 + 0.01 * uniform(&seed), 0.02, -2 - uniform(&seed)), v3(0, 0, 1),
                  1e-4);
    assert_in_range(covered_by(scene, &camera), 1, 9);
}

/* Splats before, across and behind the near plane, and the eye among them. */
static void eye_inside(void **state)
{
    uint32_t seed = 5;
    struct stp_camera camera = plain_camera(80, 60, 50);
    camera.near_depth = 0.2;
    struct stp_scene *scene = scene_make(4000, 1, 0.1);
    for (int i = 0; i < 4000; i++) {
        struct vec3 p = v3(4 * uniform(&seed) - 2, 4 * uniform(&seed) - 2, 4 * uniform(&seed) - 2);
        struct vec3 n = v3(uniform(&seed) - 0.5, uniform(&seed) - 0.5, uniform(&seed) - 0.5);
        scene_add(scene, p, n, 0.02 + 0.3 * uniform(&seed));
    }
    assert_true(covered_by(scene, &camera) > 4000);
}

/* A radius a thousand times the rest: the rest of the picture keeps its depths, but for what the
 * large disc truly hides. */
static void outlier(void **state)
{
    struct stp_camera camera = plain_camera(128, 128, 128);
    struct stp_render_params p = pyramid_params();
    struct stp_image *image[2];
    for (int with = 0; with < 2; with++) {
        struct stp_scene *scene = scene_make(40000, 1, 0.02);
        add_sheet(scene, 2, 0.02, 0.9, true);
        /* Behind the sheet: what it covers of the picture's border is all that it may add. */
        size_t i = scene_add(scene, v3(0.003, 0.001, -3), v3(0, 0, 1), with ? 22 : 0.022);
        scene_paint(scene, i, 0, 1, 0);
        scene_finish(scene);
        image[with] = device_render(&device, scene, &camera, &p);
        expect_sound(image[with]);
        stp_scene_destroy(&scene);
    }
    size_t changed = 0;
    for (uint32_t y = 0; y < 128; y++)
        for (uint32_t x = 0; x < 128; x++) {
            float a = value(image[0], "Z", x, y), b = value(image[1], "Z", x, y);
            changed += isfinite(a) && fabsf(a - b) > 0.01f;
        }
    assert_int_equal(changed, 0);
    stp_image_destroy(&image[0]);
    stp_image_destroy(&image[1]);
}

/* The view's bounds allow discs that reach beyond the pixels beside their own, as the largest is
 * the farthest, but none does: the bits of a plan without passes for such. */
static void none_far(void **state)
{
    struct stp_camera camera = plain_camera(160, 120, 100);
    struct stp_scene *scene = scene_make(60000, 1, 0.01);
    uint32_t seed = 11;
    for (int i = 0; i < 60000; i++) {
        double x = 2.4 * uniform(&seed) - 1.2, y = 2 * uniform(&seed) - 1, z = 2.2 + 0.9 * x;
        scene_add(scene, v3(0.5 * x * z, 0.5 * y * z, -z), v3(0.3, 0.1, 1), 0.004 * z);
    }
    scene_finish(scene);
    struct stp_render_params p = pyramid_params();
    struct stp_plan *plan = NULL;
    struct stp_image *image[2];
    assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
    assert_int_equal(plan->constant[PLAN_RIM_FAR], 1);
    for (int i = 0; i < 2; i++) {
        plan->constant[PLAN_RIM_FAR] = i;
        image[i] = device_render_plan(&device, scene, plan);
    }
    assert_true(expect_sound(image[1]) > 5000);
    expect_same_bits(image[1], image[0], "no disc is far");
    stp_image_destroy(&image[0]);
    stp_image_destroy(&image[1]);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
}

/* Discs without normals, little wider than a pixel, of which some reach far: what is covered does
 * not hang on the unit of length. */
static struct stp_image *without_normals(double unit)
{
    struct stp_camera camera = plain_camera(160, 120, 100);
    struct stp_scene *scene = scene_make(4000, 1, 0.01 * unit);
    uint32_t seed = 12;
    for (int i = 0; i < 4000; i++) {
        double x = 1.2 * uniform(&seed) - 0.6, y = 0.9 * uniform(&seed) - 0.45, z = 1 + 0.3 * x;
        scene_add(scene, v3(x * z * unit, y * z * unit, -z * unit), v3(0, 0, 0), 0.013 * z * unit);
    }
    scene_finish(scene);
    struct stp_render_params p = pyramid_params();
    struct stp_image *image = device_render(&device, scene, &camera, &p);
    stp_scene_destroy(&scene);
    return image;
}

static void unit_of_length(void **state)
{
    struct stp_image *near_by = without_normals(0.25), *far_off = without_normals(32);
    size_t covered = expect_sound(near_by), differs = 0;
    for (uint32_t y = 0; y < 120; y++)
        for (uint32_t x = 0; x < 160; x++)
            differs += value(near_by, "A", x, y) != value(far_off, "A", x, y);
    assert_true(covered > 5000);
    assert_int_equal(differs, 0);
    stp_image_destroy(&near_by);
    stp_image_destroy(&far_off);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(leaking),   cmocka_unit_test(odd_sizes),      cmocka_unit_test(one_point),
        cmocka_unit_test(one_pixel), cmocka_unit_test(eye_inside),     cmocka_unit_test(outlier),
        cmocka_unit_test(none_far),  cmocka_unit_test(unit_of_length),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
