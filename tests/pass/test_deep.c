/* Deep pictures: flattened they are the flat picture, and their layers are the reference's. */
#include "base/memory.h"
#include "group_device.h"
#include "surroundings.h"

static float hard(size_t i)
{
    static const float values[] = { 0, 1e-6f, 1, 0.999999f, 0.6f, 0.3f, 0.3f, 0.3f };
    return values[i * 13 % 8];
}

static float faint(size_t i)
{
    return (float)(1 + i % 9) / 40;
}

/* Random splats in two painted objects. */
static struct stp_scene *cloud(size_t count, float (*opacity)(size_t i))
{
    struct fixture *f = fixture_create(0.07);
    struct stp_scene *scene = scene_make(count, 2, 0.07);
    fill_randomly(f, 815, count);
    for (size_t i = 0; i < count; i++) {
        struct vec3 n = v3_loadf(f->normal[i]);
        scene_add(scene, v3_load(f->position[i]), v3_length(n) > 0 ? n : v3(0, 1, 0), f->radius[i]);
        scene_fade(scene, i, opacity(i));
        scene_paint(scene, i, f->color[i][0], f->color[i][1], f->color[i][2]);
        scene_assign(scene, i, i % 2);
    }
    scene->objects[1].epsilon = 0.05;
    scene_finish(scene);
    scene->facts.two_sided = true;
    free(f);
    return scene;
}

static size_t layers_of(const struct stp_image *image, size_t pixel)
{
    return image->deep->first[pixel + 1] - image->deep->first[pixel];
}

static float plane_at(const struct stp_image *image, const char *name, size_t pixel)
{
    return stp_image_find(image, name)->data.f[pixel];
}

/* Sums of n terms of float32 each: n roundings of a few units, of the largest value. */
static void expect_flat(const struct stp_image *image, size_t pixel, const char *what)
{
    static const char *const names[] = { "R", "G", "B", "A" };
    const struct stp_deep_layer *layer = image->deep->layer + image->deep->first[pixel];
    size_t layers = layers_of(image, pixel);
    double sum[4] = { 0 }, through = 1, most = 1;
    for (size_t i = 0; i < layers; i++) {
        for (int c = 0; c < 3; c++) {
            sum[c] += through * (double)layer[i].color[c];
            most = fmax(most, fabs((double)layer[i].color[c]));
        }
        sum[3] += through * (double)layer[i].alpha;
        through *= 1 - (double)layer[i].alpha;
    }
    for (int c = 0; c < 4; c++) {
        double flat = (double)plane_at(image, names[c], pixel);
        if (!(fabs(sum[c] - flat) <= 4e-7 * (double)(layers + 2) * most))
            fail_msg("%s, pixel %zu: %s is %.9g, %zu layers give %.9g", what, pixel, names[c], flat,
                     layers, sum[c]);
    }
}

/* Without a background. Returns the most layers of a pixel. */
static size_t expect_deep(const struct stp_image *image, const char *what)
{
    size_t most = 0;
    assert_non_null(image->deep);
    assert_int_equal(image->deep->first[0], 0);
    for (size_t i = 0; i < (size_t)image->width * image->height; i++) {
        const struct stp_deep_layer *layer = image->deep->layer + image->deep->first[i];
        size_t layers = layers_of(image, i);
        assert_true((float)layers == plane_at(image, "layers", i));
        for (size_t k = 0; k < layers; k++)
            assert_true(layer[k].alpha > 0 && layer[k].alpha <= 1 &&
                        (k == 0 || layer[k].z > layer[k - 1].z) &&
                        (k + 1 == layers || layer[k].alpha < 1));
        assert_true(plane_at(image, "Z", i) == (layers ? layer[0].z : INFINITY));
        expect_flat(image, i, what);
        most = layers > most ? layers : most;
    }
    return most;
}

static struct stp_image *render_reference(const struct stp_scene *scene,
                                          const struct stp_camera *camera,
                                          struct stp_render_params params)
{
    struct stp_image *image = NULL;
    params.transparency = STP_TRANSPARENCY_REFERENCE;
    assert_int_equal(reference_render(NULL, scene, camera, &params, &image), STP_OK);
    return image;
}

/* Where both have as many layers (the end of an epsilon may fall either way), those are alike. */
static void expect_same_layers(const struct stp_image *a, const struct stp_image *b, double least)
{
    size_t alike = 0, covered = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; i++) {
        const struct stp_deep_layer *p = a->deep->layer + a->deep->first[i];
        const struct stp_deep_layer *q = b->deep->layer + b->deep->first[i];
        size_t layers = layers_of(a, i);
        bool close = layers == layers_of(b, i);
        covered += layers > 0;
        for (size_t k = 0; close && k < layers; k++) {
            close = fabsf(p[k].z - q[k].z) < 2e-3f && fabsf(p[k].alpha - q[k].alpha) < 2e-3f;
            for (int c = 0; c < 3; c++)
                close = close && fabsf(p[k].color[c] - q[k].color[c]) < 5e-3f;
        }
        alike += layers > 0 && close;
    }
    if (!((double)alike >= least * (double)covered))
        fail_msg("%zu pixels of %zu have the reference's layers", alike, covered);
}

static const struct stp_render_params deep = { .min_splat = -1, .deep = true, .aovs = 127 };

/* More layers than one window has, in pixels that keep all their fragments. */
static void test_windows(void **state)
{
    for (int view = 0; view < 2; view++) {
        struct stp_scene *scene = cloud(500, view % 2 ? hard : faint);
        struct stp_camera camera = hard_view(view, 45, 33);
        struct stp_render_params p = deep;
        p.min_splat = 12;
        p.payload = view == 0 ? STP_PAYLOAD_AUTO : STP_PAYLOAD_ID;
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        struct stp_image *truth = render_reference(scene, &camera, p);
        size_t most = expect_deep(image, "device"), reference = expect_deep(truth, "reference");
        assert_true(view > 0 || (most > STP_DEEP_WINDOW && reference > STP_DEEP_WINDOW));
        expect_same_layers(image, truth, 0.9);
        stp_image_destroy(&image);
        stp_image_destroy(&truth);
        stp_scene_destroy(&scene);
    }
}

/* Rays that are mended, beside others that are not; a wall in the midst of them. */
static void test_many_layers(void **state)
{
    for (int wall = -1; wall < 100; wall += 78) {
        struct stp_scene *scene = scene_make(100 + 40, 1, 0.05);
        struct stp_camera camera = plain_camera(23, 17, 15);
        for (int i = 0; i < 140; i++) {
            double z = -2 - 0.06 * (i % 100), side = i < 100 ? 0 : 1.6;
            size_t at = scene_add(scene, v3(side, 0, z), v3(0, 0, 1), i < 100 ? 0.8 : 0.5);
            scene_fade(scene, at, i == wall ? 1 : 0.02f);
        }
        scene_finish(scene);
        struct stp_image *image = device_render(&device, scene, &camera, &deep);
        struct stp_image *truth = render_reference(scene, &camera, deep);
        assert_int_equal(expect_deep(image, "mended"), wall < 0 ? 100 : wall + 1);
        expect_deep(truth, "reference");
        expect_same_layers(image, truth, 0.95);
        stp_image_destroy(&image);
        stp_image_destroy(&truth);
        stp_scene_destroy(&scene);
    }
}

/* What glass mirrors, lets through and shows of the environment is in its layers. */
static void test_glass(void **state)
{
    const struct stp_optics o = { .ior = { 1.3f, 1.5f, 1.8f },
                                  .absorption = { 0.2f, 0.5f, 1 },
                                  .thickness = 0.5f };
    for (int k = 0; k < 3; k++) {
        struct stp_scene *scene = scene_make(210, 2, 0.05);
        struct stp_camera camera = plain_camera(25, 25, 32);
        struct stp_render_params p = deep;
        p.layers = k == 1 ? STP_LAYERS_SINGLE : STP_LAYERS_MULTI;
        for (size_t i = 0; i < 210; i++) {
            double z = 1 - (2 * (double)i + 1) / 210, angle = (double)i * 2.39996322972865332;
            struct vec3 n = v3(sqrt(1 - z * z) * cos(angle), sqrt(1 - z * z) * sin(angle), z);
            double radius = 1 - 0.2 * (double)(i % 3);
            size_t at = scene_add(scene, v3_add(v3_scale(n, radius), v3(0, 0, -3)), n, 0.3);
            scene_assign(scene, at, (unsigned)i % 2);
            scene_fade(scene, at, k == 2 && i % 7 == 0 ? 1 : 0.2f);
        }
        scene_finish(scene);
        set_optics(scene, 0, &o);
        set_optics(scene, 1, &o);
        surround(scene, 64, 32, smooth_sky, NULL);
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        struct stp_image *truth = render_reference(scene, &camera, p);
        expect_deep(image, "glass");
        expect_deep(truth, "glass, reference");
        stp_image_destroy(&image);
        stp_image_destroy(&truth);
        stp_scene_destroy(&scene);
    }
}

static void expect_same_deep(const struct stp_image *a, const struct stp_image *b)
{
    size_t pixels = (size_t)a->width * a->height, layers = a->deep->first[pixels];
    assert_memory_equal(a->deep->first, b->deep->first, (pixels + 1) * sizeof *a->deep->first);
    assert_memory_equal(a->deep->layer, b->deep->layer, layers * sizeof *a->deep->layer);
}

/* Tiles, a background and memory that the host does not see change no bit of the layers. */
static void test_same_bits(void **state)
{
    static const float background[4] = { 3, 2, 1, 0.5f };
    struct device other;
    struct stp_scene *scene = cloud(900, hard);
    struct stp_camera camera = hard_view(0, 50, 40);
    struct stp_render_params p = deep;
    p.min_splat = 24; /* some pixels overflow their slots */
    struct stp_image *first = device_render(&device, scene, &camera, &p), *again;
    p.background = background;
    p.memory_limit = 1 << 19;
    again = device_render(&device, scene, &camera, &p);
    expect_same_deep(first, again);
    stp_image_destroy(&again);
    device_open(&other, STP_FEATURE_SHARED_MEMORY);
    again = device_render(&other, scene, &camera, &p);
    expect_same_deep(first, again);
    stp_image_destroy(&again);
    device_close(&other);
    stp_image_destroy(&first);
    stp_scene_destroy(&scene);
}

/* Each allocation of a rendering fails in turn, by the reference and on the device. */
static void test_memory(void **state)
{
    struct stp_scene *scene = cloud(200, faint);
    struct stp_camera camera = hard_view(0, 17, 9);
    for (int k = 0; k < 2; k++) {
        struct stp_render_params p = deep;
        struct stp_plan *plan = NULL;
        bool done = false;
        p.transparency = k ? STP_TRANSPARENCY_EXACT : STP_TRANSPARENCY_REFERENCE;
        assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
        for (unsigned long n = 1; !done; n++) {
            struct stp_env env = { .threads = 1, .log = device.env.log, .user = &device };
            struct stp_image *image = NULL;
            unsigned lines = device.lines;
            mem_fail_at(n);
            enum stp_result result = stp_render(&env, device.context, scene, plan, 0, &image, NULL);
            done = mem_count() < n;
            mem_fail_at(0);
            assert_int_equal(result, done ? STP_OK : STP_ERROR_MEMORY);
            assert_int_equal(device.lines, lines + !done);
            assert_true((image != NULL) == done);
            stp_image_destroy(&image);
        }
        stp_plan_destroy(&plan);
    }
    stp_scene_destroy(&scene);
}

/* An opaque scene has no layers but its planes, and its plan is as it was. */
static void test_opaque(void **state)
{
    struct stp_scene *scene = scene_random(5, 300, 0.07);
    struct stp_camera camera = hard_view(0, 45, 33);
    struct stp_image *image = device_render(&device, scene, &camera, &deep);
    assert_null(image->deep);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_windows), cmocka_unit_test(test_many_layers),
        cmocka_unit_test(test_glass),   cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_opaque),  cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
