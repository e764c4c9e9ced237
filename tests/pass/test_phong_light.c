/* Ellipses in layers, shuffled, and lit per splat, flat and from a light cube. */
#include "ellipses.h"
#include "group_device.h"

/* A dozen transparent sheets of ellipses, by their layers; 70 of one pixel overflow its slots. */
static void test_layers(void **state)
{
    for (int many = 0; many < 2; many++) {
        size_t count = many ? 90 : 60;
        struct stp_scene *scene = scene_make(count, 1, 0.04);
        struct stp_camera camera = plain_camera(37, 33, 40);
        struct stp_render_params p = { .min_splat = -1, .method = STP_METHOD_EXACT };
        uint32_t seed = 9;
        for (size_t i = 0; i < count; i++) {
            struct vec3 c = random_point(&seed, many ? 0.05 : 0.6), n = random_point(&seed, 0.4);
            size_t at =
                scene_add(scene, v3(c.x, c.y, -1.5 - 0.05 * (double)i), v3_add(n, v3(0, 0, 1)), 1);
            struct stp_phong_splat e = ellipse(scene, at, 7 * uniform(&seed), 0.5, many ? 1 : 0.2);
            random_field(&seed, 0.5, &e);
            if (!many)
                random_clips(&seed, &e);
            scene_bend(scene, at, &e);
            scene_paint(scene, at, (float)uniform(&seed), (float)uniform(&seed), 0.5f);
            scene_fade(scene, at, (float)(0.1 + 0.5 * uniform(&seed)));
        }
        scene_finish(scene);
        for (p.payload = STP_PAYLOAD_ID; p.payload <= STP_PAYLOAD_PACKED; p.payload++)
            expect_reference(&device, scene, &camera, &p, &layers_tolerance,
                             many ? "many layers" : "layers");
        stp_scene_destroy(&scene);
    }
}

/* Points in the order that `stride`, prime to their number, gives: some of one place and normal. */
#define POINTS 200
static struct stp_scene *points_scene(const struct stp_env *env, unsigned stride)
{
    static double position[POINTS][3];
    static float normal[POINTS][3];
    static struct stp_phong_splat phong[POINTS];
    struct stp_scene *scene = NULL, *one = random_scene(31, POINTS, true);
    const struct splats *s = &one->splats;
    for (unsigned i = 0; i < POINTS; i++) {
        unsigned at = i * stride % POINTS, from = i % 10 ? i : 5;
        memcpy(position[at], s->position[from], sizeof *position);
        memcpy(normal[at], s->normal[from], sizeof *normal);
        phong[at] = s->phong[from];
        phong[at].field[1] += 0.01f * (float)i;
    }
    struct stp_points points = {
        .count = POINTS, .position = position, .normal = normal, .phong = phong
    };
    assert_int_equal(stp_scene_create(env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(env, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(env, scene, NULL), STP_OK);
    stp_scene_destroy(&one);
    return scene;
}

static void test_same_bits(void **state)
{
    static const struct stp_render_params ways[] = {
        { .method = STP_METHOD_EXACT, .payload = STP_PAYLOAD_PACKED },
        { .method = STP_METHOD_EXACT, .payload = STP_PAYLOAD_ID },
        { .method = STP_METHOD_TWO_PASS },
        { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER },
    };
    struct stp_env other = { .threads = 3 };
    struct stp_scene *a = points_scene(&device.env, 1), *b = points_scene(&other, 73);
    struct stp_camera camera = hard_view(0, 61, 47);
    assert_true(a->facts.phong > POINTS / 2 && a->facts.clip_lines > POINTS / 4);
    for (unsigned i = 0; i < sizeof ways / sizeof *ways; i++) {
        struct stp_image *x = device_render(&device, a, &camera, &ways[i]);
        struct stp_image *y = device_render(&device, b, &camera, &ways[i]);
        expect_same_bits(x, y, "shuffled ellipses");
        stp_image_destroy(&x);
        stp_image_destroy(&y);
    }
    stp_scene_destroy(&a);
    stp_scene_destroy(&b);
}

/* BSK 6, the baselines: light computed per splat. Lights of all kinds, colours, discs and ellipses.
 */
static void test_shades(void **state)
{
    static const struct {
        struct stp_render_params params;
        const char *name;
    } ways[] = {
        { { .shade = STP_SHADE_SPLAT, .path = STP_PATH_COMPUTE }, "shade splat" },
        { { .shade = STP_SHADE_SPLAT, .path = STP_PATH_RASTER }, "shade splat" },
        { { .shade = STP_SHADE_FLAT }, "shade flat" },
    };
    const struct stp_light lights[] = {
        { .positional = true, .position = { 1, 2, 3 }, .color = { 2, 1, 0.5f } },
        { .direction = { -1, 1, 1 }, .color = { 0.3f, 0.4f, 3 } },
    };
    struct stp_camera camera = hard_view(0, 61, 47);
    for (int colors = 0; colors < 2; colors++) {
        struct stp_scene *scene = random_scene(41, 60, !colors);
        assert_int_equal(stp_scene_set_lights(NULL, scene, lights, 2), STP_OK);
        for (unsigned i = 0; i < sizeof ways / sizeof *ways; i++) {
            struct stp_render_params p = ways[i].params;
            p.method = STP_METHOD_TWO_PASS;
            p.min_splat = -1;
            p.epsilon = 0.4;
            p.local_viewer = colors;
            expect_reference(&device, scene, &camera, &p, &float_tolerance, ways[i].name);
        }
        stp_scene_destroy(&scene);
    }
}

/* Looked up against summed, on normals of all directions: within the bound,
 * and not by far. */
static void test_light_cube(void **state)
{
    struct stp_light lights[STP_MAX_LIGHTS];
    uint32_t seed = 12;
    struct stp_scene *scene = random_scene(51, 200, false);
    struct stp_camera camera = hard_view(0, 120, 90);
    struct stp_render_params p = { .method = STP_METHOD_EXACT, .payload = STP_PAYLOAD_ID };
    for (int i = 0; i < STP_MAX_LIGHTS; i++) {
        struct vec3 d = random_point(&seed, 1);
        lights[i] = (struct stp_light){ .at_eye = i == 0,
                                        .direction = { d.x, d.y, d.z },
                                        .color = { 0.3f, (float)uniform(&seed), 0.7f } };
    }
    assert_int_equal(stp_scene_set_lights(NULL, scene, lights, STP_MAX_LIGHTS), STP_OK);
    struct stp_image *summed = device_render(&device, scene, &camera, &p);
    struct stp_plan *plan = NULL;
    p.light_cube = STP_ON;
    assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
    struct stp_image *found = device_render_plan(&device, scene, plan);
    double bound = plan_light_cube_error(plan, scene), worst = 0;
    for (size_t at = 0; at < 120 * 90; at++)
        for (const char *c = "R\0G\0B"; *c; c += 2)
            worst = fmax(worst, fabs((double)stp_image_find(found, c)->data.f[at] -
                                     (double)stp_image_find(summed, c)->data.f[at]));
    if (!(worst <= bound && worst > 0.01 * bound))
        fail_msg("off by %g, the bound is %g", worst, bound);
    stp_image_destroy(&summed);
    stp_image_destroy(&found);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layers),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_shades),
        cmocka_unit_test(test_light_cube),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
