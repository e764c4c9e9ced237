/* MKC's pyramid: no holes, nothing hidden shows through, normals near those of the true surface,
 * any size of picture, the same bits in tiles, runs and orders and without 64-bit atomics. */
#include "group_device.h"

static struct stp_render_params pyramid_params(void)
{
    return (struct stp_render_params){ .method = STP_METHOD_PYRAMID, .min_splat = -1 };
}

/* A sphere of radius 1 at distance 4, `count` points spread evenly; the usual radius: discs of four
 * times a point's share of the area. */
static struct stp_scene *sphere(size_t count)
{
    double radius = 2 * sqrt(4.0 / (double)count);
    struct stp_scene *scene = scene_make(count, 1, radius);
    for (size_t i = 0; i < count; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)count, ring = sqrt(1 - z * z);
        double turn = (double)i * 2.399963229728653;
        struct vec3 n = v3(ring * cos(turn), ring * sin(turn), z);
        scene_add(scene, v3_add(n, v3(0, 0, -4)), n, radius);
    }
    scene_finish(scene);
    return scene;
}

/* Degrees between the picture's normals and the sphere's, mean over covered pixels whose ray meets
 * it and that face the eye by more than a fifth. */
static double sphere_error(const struct stp_image *image, const struct stp_camera *camera,
                           size_t *holes)
{
    double sum = 0;
    size_t seen = 0;
    *holes = 0;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            struct vec3 ray =
                v3((x + 0.5 - camera->cx) / camera->fx, -(y + 0.5 - camera->cy) / camera->fy, -1);
            double a = v3_dot(ray, ray), b = 4, d = b * b - a * 15;
            if (d <= 0)
                continue;
            struct vec3 n = v3_add(v3_scale(ray, (b - sqrt(d)) / a), v3(0, 0, 4));
            if (-v3_dot(n, v3_unit(ray)) < 0.2)
                continue;
            seen++;
            if (!isfinite(value(image, "Z", x, y))) {
                ++*holes;
                continue;
            }
            struct vec3 m =
                v3(value(image, "N.X", x, y), value(image, "N.Y", x, y), value(image, "N.Z", x, y));
            sum += atan2(v3_length(v3_cross(n, m)), v3_dot(n, m)) * 180 / M_PI;
        }
    assert_true(seen > 10000);
    return sum / (double)(seen - *holes);
}

/* One point in so many pixels; degrees allowed. 15.7 pixels of area are 1 point in 16. */
static void sphere_normals(void **state)
{
    static const struct {
        double pixels, degrees;
    } cases[] = { { 1, 0.3 }, { 4, 0.4 }, { 16, 0.65 }, { 64, 1.2 }, { 256, 2.5 } };
    struct stp_camera camera = plain_camera(256, 256, 466); /* 240 pixels across */
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        /* Half of the points face the eye, on 45000 pixels. */
        struct stp_scene *scene = sphere((size_t)(2 * 45000 / cases[i].pixels));
        struct stp_render_params p = pyramid_params();
        p.cull = STP_CULL_BACK;
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        size_t holes;
        double error = sphere_error(image, &camera, &holes);
        if (getenv("STP_TEST_VERDICTS"))
            print_message("1 in %g: %.3f degrees, %zu holes\n", cases[i].pixels, error, holes);
        assert_int_equal(holes, 0);
        assert_true(error < cases[i].degrees);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* Pixels that the reference covers and the pyramid leaves empty, and the other way round. */
static void coverage_of_reference(void **state)
{
    struct stp_camera camera = plain_camera(256, 256, 466);
    for (size_t count = 300; count <= 300000; count *= 10) {
        struct stp_scene *scene = sphere(count);
        struct stp_render_params p = pyramid_params();
        p.cull = STP_CULL_BACK;
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        p.method = STP_METHOD_REFERENCE;
        struct stp_image *truth = device_render(&device, scene, &camera, &p);
        size_t covered = 0, missing = 0, more = 0;
        for (size_t i = 0; i < (size_t)256 * 256; i++) {
            bool a = isfinite(stp_image_find(image, "Z")->data.f[i]);
            bool b = isfinite(stp_image_find(truth, "Z")->data.f[i]);
            covered += b;
            missing += b && !a;
            more += a && !b;
        }
        if (getenv("STP_TEST_VERDICTS"))
            print_message("%zu points: %zu covered, %zu missing, %zu more\n", count, covered,
                          missing, more);
        assert_true((double)missing <= 1e-4 * (double)covered);
        assert_true((double)more <= 0.015 * (double)covered);
        stp_image_destroy(&image);
        stp_image_destroy(&truth);
        stp_scene_destroy(&scene);
    }
}

/* Two objects, colours and ids: what they are reaches the pixels between the points too. */
static void attributes(void **state)
{
    struct stp_camera camera = plain_camera(100, 100, 100);
    struct stp_scene *scene = scene_make(2000, 2, 0.1);
    scene->objects[1].material.ambient = 0.5f;
    for (int i = 0; i < 2000; i++) {
        size_t at =
            scene_add(scene, v3(i % 50 * 0.04 - 0.98, i / 50 * 0.05 - 0.98, -2), v3(0, 0, 1), 0.06);
        scene_paint(scene, at, i % 50 < 25 ? 1000 : 0.25f, 0, 0.5f);
        scene_assign(scene, at, i % 50 < 25);
    }
    scene_finish(scene);
    struct stp_render_params p = pyramid_params();
    p.aovs = 127;
    struct stp_image *image = device_render(&device, scene, &camera, &p);
    for (uint32_t y = 10; y < 90; y++)
        for (uint32_t x = 10; x < 90; x++) {
            bool left = x<46, right = x> 54;
            double albedo = value(image, "albedo.R", x, y);
            uint32_t column = (id_at(image, x, y) - 1000) % 50;
            if (left || right) {
                assert_true((column < 25) == left);
                close_to(albedo, left ? 1000 : 0.25, left ? 1 : 0.3);
                close_to(value(image, "albedo.B", x, y), 0.5, 0.3);
                close_to(value(image, "R", x, y), albedo * (left ? 1.2 : 0.8) + 0.2,
                         2e-3 * albedo + 1e-3);
            }
            assert_true(value(image, "weight", x, y) > 0 && value(image, "fragments", x, y) >= 1);
            assert_true(value(image, "coverage", x, y) == 1);
            close_to(value(image, "P.Z", x, y), 0, 0.01);
        }
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

static struct stp_image *bumps(struct stp_render_params *p, unsigned stride, unsigned *tiles)
{
    const unsigned count = 24007;
    struct stp_scene *scene = scene_make(count, 1, 0.02);
    struct stp_camera camera = plain_camera(500, 380, 330);
    for (unsigned k = 0; k < count; k++) {
        unsigned i = k * stride % count;
        double x = fmod(i * 0.7548776662466927, 1) * 4 - 2,
               y = fmod(i * 0.5698402909980532, 1) * 3 - 1.5;
        double h = 0.2 * sin(5 * x) * cos(4 * y);
        scene_paint(scene,
                    scene_add(scene, v3(x, y, h - 2.5 - (i % 3 == 0)),
                              v3(-cos(5 * x) * cos(4 * y), 0.8 * sin(5 * x) * sin(4 * y), 1),
                              0.035),
                    (float)fmod(x + 2, 1), 0.5f, (float)fmod(y + 2, 1));
    }
    scene_finish(scene);
    struct stp_plan *plan = NULL;
    assert_int_equal(device_plan(&device, scene, &camera, p, &plan), STP_OK);
    struct stp_image *image = device_render_plan(&device, scene, plan);
    if (tiles)
        *tiles = plan->tile_count;
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    return image;
}

static void same_bits(void **state)
{
    struct stp_render_params p = pyramid_params();
    p.aovs = 127;
    for (p.samples = 1; p.samples <= 4; p.samples += 3) {
        unsigned tiles;
        struct stp_image *whole = bumps(&p, 1, NULL), *again = bumps(&p, 1, NULL);
        expect_same_bits(again, whole, "again");
        p.memory_limit = 6 << 20;
        struct stp_image *tiled = bumps(&p, 1, &tiles);
        assert_true(tiles > 4);
        expect_same_bits(tiled, whole, "tiles");
        p.memory_limit = 0;
        struct stp_image *const images[] = { whole, again, tiled };
        for (unsigned i = 0; i < 3; i++) {
            struct stp_image *image = images[i];
            stp_image_destroy(&image);
        }
    }
}

/* Points at different depths: no two keys are equal but for the id, so any order gives the same. */
static void order_of_points(void **state)
{
    struct stp_render_params p = pyramid_params();
    struct stp_image *a = bumps(&p, 1, NULL), *b = bumps(&p, 5003, NULL);
    expect_same_bits(b, a, "shuffled");
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* An edge between covered and not becomes a ramp. */
static void samples_smooth_edges(void **state)
{
    struct stp_camera camera = plain_camera(128, 128, 233);
    struct stp_scene *scene = sphere(4000);
    struct stp_render_params p = pyramid_params();
    p.samples = 16;
    struct stp_image *image = device_render(&device, scene, &camera, &p);
    double area = 0, partial = 0;
    for (uint32_t y = 0; y < 128; y++)
        for (uint32_t x = 0; x < 128; x++) {
            float a = value(image, "A", x, y);
            area += a;
            partial += a > 0 && a < 1;
        }
    double radius = 233 / sqrt(15.0); /* of the sphere's outline: tangent rays */
    assert_true(fabs(area / (M_PI * radius * radius) - 1) < 0.03);
    assert_true(partial > 4 * radius);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere_normals),  cmocka_unit_test(coverage_of_reference),
        cmocka_unit_test(attributes),      cmocka_unit_test(same_bits),
        cmocka_unit_test(order_of_points), cmocka_unit_test(samples_smooth_edges),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
