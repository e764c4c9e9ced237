/* Ellipses, normal fields and clip lines by every method and path against the reference. */
#include "device.h"

static struct device device;

static int open_device(void **state)
{
    device_open(&device, 0);
    return 0;
}

static int close_device(void **state)
{
    device_close(&device);
    return 0;
}

static const struct stp_render_params floor_off = { .min_splat = -1 };

static void store(struct vec3 v, float out[3])
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* Of the splat's normal as it is stored: u at `angle` in its plane. */
static struct stp_phong_splat ellipse(const struct stp_scene *scene, size_t i, double angle,
                                      double radius_u, double radius_v)
{
    struct stp_phong_splat p = { .radius = { (float)radius_u, (float)radius_v } };
    struct vec3 n = v3_unit(v3_loadf(scene->splats.normal[i]));
    struct vec3 a = v3_unit(v3_cross(n, fabs(n.x) < 0.7 ? v3(1, 0, 0) : v3(0, 1, 0)));
    struct vec3 b = v3_cross(n, a);
    store(v3_add(v3_scale(a, cos(angle)), v3_scale(b, sin(angle))), p.u);
    return p;
}

static void random_field(uint32_t *seed, double size, struct stp_phong_splat *p)
{
    for (int k = 0; k < 4; k++)
        p->field[k] = (float)((2 * uniform(seed) - 1) * size);
}

static void random_clips(uint32_t *seed, struct stp_phong_splat *p)
{
    p->clips = (uint8_t)(3 * uniform(seed));
    p->reflex = p->clips == 2 && uniform(seed) < 0.5;
    for (int k = 0; k < p->clips; k++) {
        double angle = 2 * M_PI * uniform(seed);
        p->clip[k][0] = (float)cos(angle);
        p->clip[k][1] = (float)sin(angle);
        p->clip[k][2] = (float)(0.8 * uniform(seed) - 0.2);
    }
}

/* As scene_random, with discs, ellipses, fields and clip lines among each other. */
static struct stp_scene *random_scene(uint32_t seed, size_t count, bool clips)
{
    struct stp_scene *scene = scene_make(count, 1, 0.05);
    for (size_t i = 0; i < count; i++) {
        struct vec3 p = random_point(&seed, 1), n = random_point(&seed, 1);
        double radius = 0.4 * pow(10, -2 * uniform(&seed)), kind = uniform(&seed);
        double flat = radius * pow(10, -1.5 * uniform(&seed));
        size_t at = scene_add(scene, p, kind < 0.1 ? v3(0, 0, 0) : n, radius);
        if (!clips) /* packed layers have no room for colours */
            scene_paint(scene, at, (float)uniform(&seed), 0.5f, (float)uniform(&seed));
        if (kind < 0.2)
            continue;
        bool along = uniform(&seed) < 0.5;
        struct stp_phong_splat e =
            ellipse(scene, at, 7 * uniform(&seed), along ? radius : flat, along ? flat : radius);
        random_field(&seed, 0.8, &e);
        if (clips)
            random_clips(&seed, &e);
        scene_bend(scene, at, &e);
    }
    scene_finish(scene);
    return scene;
}

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
    static const double tilts[] = { 80, 89, 89.999 };
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
        assert_int_equal(stp_scene_set_lights(scene, lights, 2), STP_OK);
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

/* Looked up against summed, on normals of all directions: within the bound that the plan states,
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
    assert_int_equal(stp_scene_set_lights(scene, lights, STP_MAX_LIGHTS), STP_OK);
    struct stp_image *summed = device_render(&device, scene, &camera, &p);
    struct stp_plan *plan = NULL;
    p.light_cube = STP_ON;
    assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
    struct stp_image *found = device_render_plan(&device, scene, plan);
    double bound = plan_light_cube_error(plan, &scene->objects[0].material, 1), worst = 0;
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
        cmocka_unit_test(test_random_views), cmocka_unit_test(test_floors),
        cmocka_unit_test(test_tilts),        cmocka_unit_test(test_across_near),
        cmocka_unit_test(test_layers),       cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_shades),       cmocka_unit_test(test_light_cube),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
