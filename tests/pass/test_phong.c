/* Ellipses, normal fields and clip lines by every method and path against the reference. */
#include "ellipses.h"
#include "group_device.h"

static const struct stp_render_params floor_off = { .min_splat = -1 };

/* Those of perspective, inside and wide, orthographic, cut by near and far; with and without
 * colours, clip lines, culling and two sides. The first with a layer a splat, which takes long to
 * compile. */
static void test_random_views(void **state)
{
    static const int views[] = { 0, 2, 5, 7 };
    for (int k = 0; k < 4; k++) {
        char what[32];
        struct stp_scene *scene = random_scene(3 + (uint32_t)k, k ? 60 : 10, k != 1);
        struct stp_camera camera = hard_view(views[k], 61, 43);
        struct stp_render_params p = { .min_splat = -1, .cull = k < 2 ? STP_CULL_BACK : 0 };
        scene->facts.two_sided = k % 2;
        if (k == 0)
            scene_own_groups(scene);
        snprintf(what, sizeof what, "view %d", views[k]);
        expect_everywhere(&device, scene, &camera, &p, what);
        stp_scene_destroy(&scene);
    }
}

/* Floored: tiny ones, and needles of aspect 1000, at two floors. */
static void test_floors(void **state)
{
    static const double floors[] = { 6, 0 };
    struct stp_scene *scene = scene_make(200, 1, 0.02);
    struct stp_camera camera = plain_camera(48, 40, 64);
    uint32_t seed = 5;
    for (int i = 0; i < 200; i++) {
        struct vec3 p = random_point(&seed, 1), n = random_point(&seed, 1);
        size_t at = scene_add(scene, v3_add(p, v3(0, 0, -4)), n, 1);
        double radius = pow(10, -3 + 3 * uniform(&seed)), thin = i % 2 ? 1e-3 : uniform(&seed);
        struct stp_phong_splat e = ellipse(scene, at, 7 * uniform(&seed), radius, thin * radius);
        random_field(&seed, 0.3, &e);
        scene_bend(scene, at, &e);
    }
    scene_finish(scene);
    for (int flat = 0; flat < 2; flat++) {
        struct stp_render_params p = { .min_splat = floors[flat] };
        camera.orthographic = flat;
        camera.fx = camera.fy = flat ? 16 : 64;
        expect_everywhere(&device, scene, &camera, &p, "floors");
    }
    stp_scene_destroy(&scene);
}

/* Tilted by 80 degrees to all but 90, and of aspects up to 1000 either way. */
static void test_tilts(void **state)
{
    static const double tilts[] = { 80, 89.999 };
    struct stp_camera camera = plain_camera(64, 56, 300);
    uint32_t seed = 77;
    for (unsigned i = 0; i < sizeof tilts / sizeof *tilts; i++) {
        struct stp_scene *scene = scene_make(16, 1, 0.05);
        for (int k = 0; k < 16; k++) {
            double turn = k * M_PI / 8, tilt = tilts[i] * M_PI / 180, aspect = pow(10, k % 4);
            struct vec3 c = v3_add(random_point(&seed, 0.1), v3(0, 0, -2 - 0.1 * k));
            struct vec3 along = v3(cos(turn), sin(turn), 0), view = v3_unit(v3_scale(c, -1));
            along = v3_unit(v3_sub(along, v3_scale(view, v3_dot(along, view))));
            struct vec3 n = v3_add(v3_scale(view, cos(tilt)), v3_scale(along, sin(tilt)));
            size_t at = scene_add(scene, c, n, 1);
            double r = 0.4;
            struct stp_phong_splat e =
                ellipse(scene, at, 7 * uniform(&seed), k % 8 < 4 ? r : r / aspect,
                        k % 8 < 4 ? r / aspect : r);
            random_field(&seed, 1.5, &e);
            scene_bend(scene, at, &e);
        }
        scene_finish(scene);
        struct stp_render_params p = { .min_splat = tilts[i] > 89.9 ? 1.5 : -1 };
        expect_everywhere(&device, scene, &camera, &p, "tilts");
        stp_scene_destroy(&scene);
    }
}

/* Across the whole view and beyond, 10^6 times as long as wide: clipping rounds the triangles that
 * the rasteriser draws them by, and still no pixel of them is lost. */
static void test_needles(void **state)
{
    const struct stp_render_params raster = { .method = STP_METHOD_TWO_PASS,
                                              .path = STP_PATH_RASTER,
                                              .min_splat = -1 };
    struct stp_camera camera = plain_camera(112, 84, 134.4);
    for (uint32_t k = 1; k < 4; k++) {
        struct stp_scene *scene = scene_make(60, 1, 0.02);
        uint32_t seed = k;
        for (int i = 0; i < 60; i++) {
            double aspect = pow(10, i % 7);
            struct vec3 p = v3_add(random_point(&seed, 1.2), v3(0, 0, -4));
            struct vec3 n = v3_add(random_point(&seed, 0.8), v3(0, 0, 1));
            size_t at = scene_add(scene, v3((float)p.x, (float)p.y, (float)p.z), n, 1);
            struct stp_phong_splat e = ellipse(scene, at, 7 * uniform(&seed), 0.05 * aspect, 0.05);
            random_field(&seed, 0.5, &e);
            scene_bend(scene, at, &e);
            float r = (float)uniform(&seed), g = (float)uniform(&seed), b = (float)uniform(&seed);
            scene_paint(scene, at, r, g, b);
        }
        scene_finish(scene);
        expect_reference(&device, scene, &camera, &raster, &float_tolerance, "needles");
        stp_scene_destroy(&scene);
    }
}

/* The ground below the eye, longer than wide, with a field and a line across it. */
static void test_across_near(void **state)
{
    for (int near = 1; near < 3; near++) {
        struct stp_scene *scene = scene_make(3, 1, 0.5);
        struct stp_camera camera = plain_camera(48, 48, 20);
        struct stp_phong_splat e;
        camera.near_depth = near == 1 ? 0.1 : 2.9;
        scene_add(scene, v3(0, -1, -1), v3(0, 1, 0), 1e3);
        e = ellipse(scene, 0, 0.5, 1e3, 30);
        e.clips = 1;
        memcpy(e.clip[0], (float[3]){ 1, 0.2f, -0.002f }, sizeof e.clip[0]);
        memcpy(e.field, (float[4]){ -0.3f, 2, 0.4f, 0.4f }, sizeof e.field);
        scene_bend(scene, 0, &e);
        scene_add(scene, v3(0.5, 2, 0.5), v3(0, -1, 0.02), 50);
        e = ellipse(scene, 1, 2.5, 3, 50);
        e.field[1] = 1;
        scene_bend(scene, 1, &e);
        scene_add(scene, v3(1.5, 0, -0.001), v3(1, 0.3, 0.1), 2);
        e = ellipse(scene, 2, 1, 2, 0.5);
        e.field[3] = 1;
        scene_bend(scene, 2, &e);
        scene_finish(scene);
        scene_own_groups(scene);
        expect_everywhere(&device, scene, &camera, &floor_off, "across the near plane");
        stp_scene_destroy(&scene);
    }
}

/* Two tiles in the same memory. In the left one a third splat fills a third slot, and the normals
 * do not cancel; in the right one they do, of two splats, and the nearest, whose normal there is
 * the other way round, is the one that the third slot still shows of the left. */
static void test_stale_slots(void **state)
{
    struct stp_camera camera = flat_camera(256, 32, 100);
    struct stp_scene *scene = scene_make(3, 1, 0.1);
    struct stp_plan *plan = NULL;
    struct stp_phong_splat left = { .u = { 1, 0, 0 }, .radius = { 3, 3 }, .clips = 1 };
    memcpy(left.clip[0], (float[3]){ -1, 0, 0.26f }, sizeof left.clip[0]); /* up to x = -0.22 */
    scene_bend(scene, scene_add(scene, v3(-1, 0, -4.02), v3(0, 0, 1), 3), &left);
    for (int i = 1; i < 3; i++) {
        struct stp_phong_splat e = { .u = { 1, 0, 0 }, .radius = { 2, 2 } };
        size_t at = scene_add(scene, v3(0, 0, -4 - 0.01 * (2 - i)), v3(0, 0, 1), 2);
        e.field[1] = i == 1 ? -1e12f : 1e12f;
        scene_bend(scene, at, &e);
    }
    scene_finish(scene);
    struct stp_render_params p = { .method = STP_METHOD_EXACT,
                                   .payload = STP_PAYLOAD_ID,
                                   .min_splat = -1 };
    for (uint32_t tiles = 0, limit = 1000000; tiles != 2; limit += limit / 8) {
        p.memory_limit = limit;
        assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
        tiles = plan->tile_count;
        stp_plan_destroy(&plan);
        assert_true(tiles >= 2);
    }
    expect_reference(&device, scene, &camera, &p, &exact_tolerance, "stale slots");
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stale_slots), cmocka_unit_test(test_random_views),
        cmocka_unit_test(test_floors),      cmocka_unit_test(test_tilts),
        cmocka_unit_test(test_needles),     cmocka_unit_test(test_across_near),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
