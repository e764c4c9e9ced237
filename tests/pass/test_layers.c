/* Transparency exact on a device, against the reference and against formulas. */
#include "group_device.h"

static void expect_exact(const struct stp_scene *scene, const struct stp_camera *camera,
                         struct stp_render_params p, const char *what)
{
    p.transparency = STP_TRANSPARENCY_EXACT;
    expect_reference(&device, scene, camera, &p, &layers_tolerance, what);
}

static float one_opacity(size_t i)
{
    return 0.3f;
}

static float varying(size_t i)
{
    return (float)(1 + i * 37 % 100) / 101;
}

static float hard(size_t i)
{
    static const float values[] = { 0, 1e-6f, 1, 0.999999f, 0.6f, 0.3f, 0.3f, 0.3f };
    return values[i * 13 % 8];
}

/* A random cloud in two objects, painted or not. */
static struct stp_scene *cloud(size_t count, float (*opacity)(size_t i), bool painted)
{
    struct fixture *f = fixture_create(0.07);
    struct stp_scene *scene = scene_make(count, 2, 0.07);
    fill_randomly(f, 4711, count);
    for (size_t i = 0; i < count; i++) {
        struct vec3 n = v3_loadf(f->normal[i]);
        scene_add(scene, v3_load(f->position[i]), v3_length(n) > 0 ? n : v3(0, 1, 0), f->radius[i]);
        scene_fade(scene, i, opacity(i));
        if (painted)
            scene_paint(scene, i, f->color[i][0], f->color[i][1], f->color[i][2]);
        scene_assign(scene, i, i % 2);
    }
    scene->objects[1].epsilon = 0.05;
    scene_finish(scene);
    scene->facts.two_sided = true;
    free(f);
    return scene;
}

/* Each view in one of the three, and packed or with ids. */
static void some_views(float (*opacity)(size_t i), bool painted, int third, const char *what)
{
    struct stp_scene *scene = cloud(500, opacity, painted);
    struct stp_render_params params = { .min_splat = -1, .aovs = 127 };
    for (int view = 0; view < VIEWS; view++) {
        struct stp_camera camera = hard_view(view, 41, 31);
        if (view % 3 != third)
            continue;
        params.payload = view % 2 ? STP_PAYLOAD_ID : STP_PAYLOAD_AUTO;
        params.kernel = view % 2 ? STP_KERNEL_GAUSS : STP_KERNEL_PARABOLA;
        expect_exact(scene, &camera, params, what);
    }
    stp_scene_destroy(&scene);
}

static void test_views(void **state)
{
    some_views(one_opacity, false, 0, "one opacity");
    some_views(varying, true, 1, "varying opacity");
    some_views(hard, true, 2, "hard opacities");
}

/* One object, one opacity: packed slots without ids. */
static void test_packed(void **state)
{
    struct stp_scene *scene = scene_random(33, 900, 0.07);
    struct stp_camera camera = hard_view(0, 61, 47);
    scene->splats.opacity = malloc(900 * sizeof(float));
    for (size_t i = 0; i < 900; i++)
        scene->splats.opacity[i] = 0.6f;
    scene->facts.transparent = scene->facts.uniform_opacity = true;
    scene->facts.opacity_min = 0.6f;
    expect_exact(scene, &camera, (struct stp_render_params){ .min_splat = 2 }, "packed");
    free(scene->splats.opacity);
    scene->splats.opacity = NULL;
    stp_scene_destroy(&scene);
}

static float value_at(const struct stp_image *image, const char *name)
{
    size_t middle = (size_t)(image->height / 2) * image->width + image->width / 2;
    return stp_image_find(image, name)->data.f[middle];
}

/* `count` sheets of discs across the middle of the picture, `step` apart. */
static struct stp_scene *painted_sheets(size_t count, double step, float opacity, size_t discs,
                                        const float color[3])
{
    struct stp_scene *scene = scene_make(count * discs, 1, 0.1);
    for (size_t k = 0; k < count * discs; k++) {
        double z = -5 - step * (double)(k / discs);
        scene_add(scene, v3(0.001 * (double)(k % discs), 0, z), v3(0, 0, 1), 2);
        scene_fade(scene, k, opacity);
        if (color)
            scene_paint(scene, k, color[0], color[1], color[2]);
    }
    scene_finish(scene);
    return scene;
}

static struct stp_scene *sheets(size_t count, double step, float opacity, size_t discs)
{
    return painted_sheets(count, step, opacity, discs, NULL);
}

/* The closed form, within and beyond the slots, of small discs and of large ones. */
static void test_many_layers(void **state)
{
    static const struct {
        size_t layers, discs;
        float opacity;
        double focal;
    } cases[] = { { 1, 300, 0.3f, 8 }, { 8, 9, 0.3f, 8 },    { 64, 1, 0.05f, 8 },
                  { 65, 1, 0.05f, 8 }, { 300, 2, 1e-6f, 8 }, { 100, 3, 0.01f, 100 } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct stp_scene *scene = sheets(cases[i].layers, 0.11, cases[i].opacity, cases[i].discs);
        struct stp_camera camera = flat_camera(21, 17, cases[i].focal);
        struct stp_render_params p = { .min_splat = -1,
                                       .aovs = STP_AOV_LAYERS | STP_AOV_FRAGMENTS };
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        double alpha = -expm1((double)cases[i].layers * log1p(-(double)cases[i].opacity));
        assert_true(value_at(image, "layers") == (float)cases[i].layers);
        assert_true(value_at(image, "fragments") == (float)cases[i].discs);
        close_to(value_at(image, "A"), alpha, 3e-5 * alpha + 1e-7);
        close_to(value_at(image, "R"), 0.84 * alpha, 1e-4 * alpha + 1e-7); /* 0.8 * 0.8 + 0.2 */
        close_to(value_at(image, "Z"), 5, 1e-5);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* Discs of one colour and one opacity: their mean is that colour, to half a step of those that
 * slots hold; 0 and 1 to a float's rounding, and so is what is outside of 0 to 1, which they do not
 * hold. Within the slots, in lists, and of large discs. */
static void test_colors(void **state)
{
    static const float colors[][3] = { { 0, 1, 0.5f },
                                       { 0.7f, 0.0001f, 0.9999f },
                                       { 0.3f, 0.123f, 0.877f },
                                       { 1.5f, 0.7f, 0.3f },
                                       { -0.25f, 0.7f, 0.3f } };
    static const struct {
        size_t discs;
        double focal;
    } cases[] = { { 1, 8 }, { 64, 8 }, { 300, 8 }, { 3, 100 } };
    for (unsigned k = 0; k < sizeof colors / sizeof *colors; k++)
        for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
            struct stp_scene *scene = painted_sheets(2, 0.3, 0.5f, cases[i].discs, colors[k]);
            struct stp_camera camera = flat_camera(21, 17, cases[i].focal);
            struct stp_render_params p = { .min_splat = -1, .aovs = STP_AOV_ALBEDO };
            struct stp_image *image = device_render(&device, scene, &camera, &p);
            static const char *const names[] = { "albedo.R", "albedo.G", "albedo.B" };
            for (unsigned c = 0; c < 3; c++) {
                double v = (double)colors[k][c];
                double steps = k < 3 && v != 0 && v != 1 ? 0.5 / 4095 : 0;
                close_to(value_at(image, names[c]), v, steps + 3e-7 * fabs(v));
            }
            stp_image_destroy(&image);
            stp_scene_destroy(&scene);
        }
}

/* A few deep blocks far from each other, drawn again alone: among blocks that are touched but hold
 * every fragment, each is taken once, and nothing else. There is room for the lists of some of
 * them; the others are mended layer by layer. */
static void test_deep_blocks_apart(void **state)
{
    const size_t deep = STP_SLOTS + 9;
    struct stp_scene *scene = scene_make(4 * deep + 2, 1, 0.1);
    struct stp_camera camera = flat_camera(120, 90, 20);
    struct stp_render_params p = { .min_splat = -1, .aovs = STP_AOV_LAYERS };
    for (size_t k = 0; k < 4 * deep; k++) {
        double x = k % 2 ? -2.5 : 2.5, y = k / 2 % 2 ? -1.7 : 1.7, z = -5 - 0.11 * (double)(k / 4);
        scene_fade(scene, scene_add(scene, v3(x, y, z), v3(0, 0, 1), 0.3), 0.05f);
    }
    for (int k = 0; k < 2; k++)
        scene_fade(scene, scene_add(scene, v3(0, 0, -3 - k), v3(0, 0, 1), 6), 0.3f);
    scene_finish(scene);
    struct stp_image *image = device_render(&device, scene, &camera, &p);
    const struct stp_channel *layers = stp_image_find(image, "layers");
    unsigned found[3] = { 0 };
    for (size_t i = 0; i < 120 * 90; i++) {
        float n = layers->data.f[i];
        found[0] += n == 2;
        found[1] += n == (float)deep + 2;
        found[2] += n != 2 && n != (float)deep + 2;
    }
    assert_true(found[0] > 9000 && found[1] > 300 && found[2] == 0);
    stp_image_destroy(&image);
    expect_exact(scene, &camera, p, "deep blocks apart");
    stp_scene_destroy(&scene);
}

/* As two_sheets in test_layers of the reference. */
static void test_two_sheets(void **state)
{
    static const double distance[] = { 0.5, 0.99, 1.01, 2 };
    for (int k = 0; k < 4; k++) {
        struct stp_scene *scene = scene_make(2, 1, 0.1);
        struct stp_camera camera = flat_camera(5, 5, 1);
        struct stp_render_params p = { .min_splat = -1, .aovs = STP_AOV_LAYERS };
        p.payload = k % 2 ? STP_PAYLOAD_AUTO : STP_PAYLOAD_ID;
        scene_paint(scene, scene_add(scene, v3(0, 0, -5), v3(0, 0, 1), 100), 1, 0, 0);
        scene_paint(scene, scene_add(scene, v3(0, 0, -5 - 0.1 * distance[k]), v3(0, 0, 1), 100), 0,
                    0, 1);
        scene_fade(scene, 0, 0.3f);
        scene_fade(scene, 1, 0.6f);
        scene_finish(scene);
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        bool merged = distance[k] < 1;
        assert_true(value_at(image, "layers") == (merged ? 1 : 2));
        close_to(value_at(image, "A"), merged ? 0.45 : 1 - 0.7 * 0.4, 1e-4);
        close_to(value_at(image, "B"), merged ? 0.45 * 0.6 : 0.3 * 0.2 + 0.7 * 0.6, 1e-4);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* Something opaque among 100 sheets: alpha is 1, and what is behind does not count. */
static void test_opaque_among_many(void **state)
{
    for (size_t wall = 0; wall < 100; wall += 33) {
        struct stp_scene *scene = sheets(100, 0.11, 0.01f, 1);
        struct stp_camera camera = flat_camera(9, 9, 4);
        struct stp_render_params p = { .min_splat = -1, .aovs = STP_AOV_LAYERS };
        scene->splats.opacity[wall] = 1;
        scene->facts.mixed = true;
        scene->facts.uniform_opacity = false;
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        assert_true(value_at(image, "A") == 1);
        assert_true(value_at(image, "layers") == (float)(wall + 1));
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* Premultiplied: what was there comes back from the picture over two backgrounds. */
static void test_backgrounds(void **state)
{
    static const float backgrounds[3][4] = { { 0, 0, 0, 1 }, { 1e4f, 2, 1, 1 }, { 3, 2, 1, 0 } };
    struct stp_scene *scene = cloud(500, varying, true);
    struct stp_camera camera = hard_view(0, 40, 30);
    struct stp_render_params p = { .min_splat = -1 };
    struct stp_image *bare = device_render(&device, scene, &camera, &p), *on[3];
    for (int k = 0; k < 3; k++) {
        p.background = backgrounds[k];
        on[k] = device_render(&device, scene, &camera, &p);
    }
    for (size_t at = 0; at < 40 * 30; at++) {
        double a = stp_image_find(bare, "A")->data.f[at];
        double through = (stp_image_find(on[1], "R")->data.f[at] -
                          (double)stp_image_find(on[0], "R")->data.f[at]) /
                         1e4;
        close_to(1 - through, a, 1e-6);
        assert_true(stp_image_find(on[0], "A")->data.f[at] == 1);
        for (unsigned c = 0; c < 4; c++) {
            assert_true(c == 3 || on[0]->channels[c].data.f[at] == bare->channels[c].data.f[at]);
            assert_true(on[2]->channels[c].data.f[at] == bare->channels[c].data.f[at]);
        }
    }
    stp_image_destroy(&bare);
    for (int k = 0; k < 3; k++)
        stp_image_destroy(&on[k]);
    stp_scene_destroy(&scene);
}

/* Tiles, and a second run, give the same bits; also where slots overflow. */
static void test_same_bits(void **state)
{
    for (int crowded = 0; crowded < 2; crowded++) {
        struct stp_scene *scene = cloud(crowded ? 2500 : 600, hard, true);
        struct stp_camera camera = hard_view(0, 90, 70);
        struct stp_render_params p = { .min_splat = crowded ? 24 : 2, .aovs = 127, .samples = 4 };
        struct stp_image *first = device_render(&device, scene, &camera, &p);
        struct stp_image *again = device_render(&device, scene, &camera, &p);
        expect_same_bits(first, again, "again");
        stp_image_destroy(&again);
        p.memory_limit = 2 << 20;
        again = device_render(&device, scene, &camera, &p);
        expect_same_bits(first, again, "in tiles");
        stp_image_destroy(&again);
        stp_image_destroy(&first);
        stp_scene_destroy(&scene);
    }
}

static void test_samples(void **state)
{
    struct stp_scene *scene = cloud(400, hard, true);
    struct stp_camera camera = hard_view(0, 40, 30);
    struct stp_render_params p = { .min_splat = -1, .aovs = 127, .samples = 4 };
    expect_exact(scene, &camera, p, "samples");
    stp_scene_destroy(&scene);
}

static void test_all_invisible(void **state)
{
    struct stp_scene *scene = sheets(3, 0.2, 0, 1);
    struct stp_camera camera = flat_camera(9, 9, 4);
    struct stp_image *image =
        device_render(&device, scene, &camera, &(struct stp_render_params){ 0 });
    assert_true(value_at(image, "A") == 0 && value_at(image, "Z") == INFINITY);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views),
        cmocka_unit_test(test_packed),
        cmocka_unit_test(test_many_layers),
        cmocka_unit_test(test_colors),
        cmocka_unit_test(test_deep_blocks_apart),
        cmocka_unit_test(test_two_sheets),
        cmocka_unit_test(test_opaque_among_many),
        cmocka_unit_test(test_backgrounds),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_samples),
        cmocka_unit_test(test_all_invisible),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
