/* Extra channels against the reference's, and what their definitions promise. */
#include "group_device.h"

static float at(const struct stp_image *image, const char *name, size_t i)
{
    return stp_image_find(image, name)->data.f[i];
}

/* Where the neighbourhood agrees about the nearest splat and the fragments, everything must. */
static void compare_pixel(const struct stp_image *seen, const struct stp_image *truth, size_t i,
                          size_t *same)
{
    static const char *const names[] = { "albedo.R", "albedo.G", "albedo.B", "P.X",
                                         "P.Y",      "P.Z",      "weight" };
    assert_true(at(seen, "coverage", i) == (float)isfinite(at(seen, "Z", i)));
    assert_true(at(seen, "layers", i) == at(seen, "coverage", i));
    if (stp_image_find(seen, "id")->data.u[i] != stp_image_find(truth, "id")->data.u[i] ||
        at(seen, "fragments", i) != at(truth, "fragments", i))
        return;
    ++*same;
    for (unsigned k = 0; k < sizeof names / sizeof *names; k++)
        close_to(at(seen, names[k], i), at(truth, names[k], i), 0.01);
}

/* P, seen by the camera, is the centre of its pixel at depth Z. */
static void reproject(const struct stp_image *image, size_t i)
{
    const struct stp_camera *c = &image->camera;
    struct vec3 p = v3(at(image, "P.X", i), at(image, "P.Y", i), at(image, "P.Z", i));
    struct vec3 e = m4_point(c->world_to_camera, v3_add(p, v3_load(image->origin)));
    double scale = c->orthographic ? 1 : -e.z;
    if (!isfinite(at(image, "Z", i)))
        return;
    close_to(-e.z, at(image, "Z", i), 1e-5);
    close_to(c->cx + c->fx * e.x / scale, (double)(i % image->width) + 0.5, 2e-3);
    close_to(c->cy - c->fy * e.y / scale, (double)(i / image->width) + 0.5, 2e-3);
}

static void check(const struct stp_scene *scene, const struct stp_camera *camera,
                  struct stp_render_params params)
{
    params.aovs = 127;
    struct stp_image *seen = device_render(&device, scene, camera, &params);
    params.method = STP_METHOD_REFERENCE;
    params.path = STP_PATH_AUTO;
    struct stp_image *truth = device_render(&device, scene, camera, &params);
    size_t count = (size_t)camera->width * camera->height, same = 0;
    assert_int_equal(seen->channel_count, truth->channel_count);
    for (size_t i = 0; i < count; i++) {
        compare_pixel(seen, truth, i, &same);
        reproject(seen, i);
    }
    assert_true(same > count - count / 50);
    stp_image_destroy(&seen);
    stp_image_destroy(&truth);
}

static void test_every_way(void **state)
{
    static const struct {
        enum stp_method method;
        enum stp_path path;
    } ways[] = { { STP_METHOD_EXACT, STP_PATH_AUTO },
                 { STP_METHOD_TWO_PASS, STP_PATH_COMPUTE },
                 { STP_METHOD_TWO_PASS, STP_PATH_RASTER },
                 { STP_METHOD_DEFERRED, STP_PATH_COMPUTE },
                 { STP_METHOD_DEFERRED, STP_PATH_RASTER } };
    struct stp_scene *scene = scene_random(51, 10, 0.1);
    scene_own_groups(scene);
    for (unsigned i = 0; i < sizeof ways / sizeof *ways; i++)
        for (int flat = 0; flat < 2; flat++) {
            struct stp_camera camera = hard_view(flat ? 6 : 0, 41, 33);
            struct stp_render_params p = { .method = ways[i].method,
                                           .path = ways[i].path,
                                           .min_splat = -1 };
            check(scene, &camera, p);
        }
    stp_scene_destroy(&scene);
}

/* Fragments and weights beyond the slots of `exact`, and far from the world's origin. */
static void test_piled_up_and_far_away(void **state)
{
    struct stp_scene *scene = scene_make(60, 1, 0.1);
    struct stp_camera camera = plain_camera(20, 20, 20);
    struct stp_render_params p = { .method = STP_METHOD_EXACT, .min_splat = -1 };
    uint32_t seed = 3;
    for (int i = 0; i < 60; i++) {
        size_t s =
            scene_add(scene, v3(1e6 + 0.1 * uniform(&seed), 2e6, -3e6 - 2), v3(0, 0, 1), 0.4);
        scene_paint(scene, s, 0.5f, 0.25f, 1);
    }
    scene_finish(scene);
    camera.world_to_camera[3] = -1e6;
    camera.world_to_camera[7] = -2e6;
    camera.world_to_camera[11] = 3e6;
    check(scene, &camera, p);
    p.aovs = STP_AOV_FRAGMENTS | STP_AOV_WEIGHT;
    struct stp_image *image = device_render(&device, scene, &camera, &p);
    size_t middle = 10 * 20 + 10;
    assert_true(at(image, "fragments", middle) == 60);
    assert_true(at(image, "weight", middle) > 50);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

/* A channel is there when asked for, and only then. */
static void test_each_alone(void **state)
{
    static const struct {
        unsigned aov;
        const char *name;
        unsigned planes;
    } table[] = { { 0, "Z", 0 },
                  { STP_AOV_ALBEDO, "albedo.G", 3 },
                  { STP_AOV_POSITION, "P.Z", 3 },
                  { STP_AOV_WEIGHT, "weight", 1 },
                  { STP_AOV_FRAGMENTS, "fragments", 1 },
                  { STP_AOV_COVERAGE, "coverage", 1 },
                  { STP_AOV_ID, "id", 1 },
                  { STP_AOV_LAYERS, "layers", 1 } };
    struct stp_scene *scene = scene_random(52, 30, 0.1);
    struct stp_camera camera = hard_view(0, 16, 16);
    struct stp_image *all, *one;
    struct stp_render_params p = { .aovs = 127 };
    all = device_render(&device, scene, &camera, &p);
    for (unsigned i = 0; i < sizeof table / sizeof *table; i++) {
        p.aovs = table[i].aov;
        one = device_render(&device, scene, &camera, &p);
        assert_int_equal(one->channel_count, 8 + table[i].planes);
        assert_non_null(stp_image_find(one, table[i].name));
        for (unsigned c = 0; c < one->channel_count; c++)
            assert_memory_equal(one->channels[c].data.u,
                                stp_image_find(all, one->channels[c].name)->data.u, 16 * 16 * 4);
        stp_image_destroy(&one);
    }
    stp_image_destroy(&all);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_way),
        cmocka_unit_test(test_piled_up_and_far_away),
        cmocka_unit_test(test_each_alone),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
