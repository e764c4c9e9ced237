/* Points that the device cannot hold at once, and devices without 64-bit atomics: the same bits as
 * all at once, with them. */
#include "group_device.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"

#define POINTS 60007

/* Two objects in front of each other, colours, and heaps of points that tie in every depth bit: on
 * the planes of constant depth only the id decides. */
static struct stp_scene *heap_scene(unsigned objects)
{
    struct stp_scene *scene = scene_make(POINTS, objects, 0.02);
    uint32_t seed = 11;
    for (int i = 0; i < POINTS; i++) {
        double x = 4 * uniform(&seed) - 2, y = 3 * uniform(&seed) - 1.5;
        double z = i % 3 == 0 ? -3.0 : -2.5 + 0.2 * sin(5 * x);
        size_t at = scene_add(scene, v3(x, y, z), v3(-cos(5 * x), 0, 1), 0.012);
        scene_paint(scene, at, (float)uniform(&seed), (float)uniform(&seed), 0.5f);
        if (objects > 1)
            scene_assign(scene, at, i % 3 == 0);
    }
    scene_finish(scene);
    return scene;
}

/* As if the device had so much memory: a quarter of it is a chunk. */
static struct stp_plan *plan_in(const struct stp_scene *scene, const struct stp_camera *camera,
                                const struct stp_render_params *params, uint64_t heap)
{
    struct stp_limits limits = *stp_context_limits(device.context);
    struct stp_plan *plan = NULL;
    limits.heap_bytes = heap ? heap : limits.heap_bytes;
    assert_int_equal(stp_plan_create(&device.env, scene, camera, params, &limits, &plan), STP_OK);
    return plan;
}

static void expect_as_whole(const struct stp_render_params *params, unsigned chunks,
                            const char *what)
{
    struct stp_camera camera = plain_camera(250, 190, 165);
    struct stp_scene *scene = heap_scene(2);
    struct stp_render_params whole = *params;
    whole.mask_features = 0;
    struct stp_plan *plan = plan_in(scene, &camera, &whole, 0);
    assert_int_equal(plan->chunk_count, 0);
    struct stp_image *truth = device_render_plan(&device, scene, plan);
    stp_plan_destroy(&plan);
    /* 37 bytes a point; chunks are whole runs. */
    uint64_t heap = chunks ? (uint64_t)4 * 37 * (POINTS / chunks + STP_POINT_RUN) : 0;
    plan = plan_in(scene, &camera, params, heap);
    assert_int_equal(plan->chunk_count, chunks);
    struct stp_image *image = device_render_plan(&device, scene, plan);
    expect_same_bits(image, truth, what);
    stp_image_destroy(&image);
    stp_image_destroy(&truth);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
}

static void chunks_are_as_one(void **state)
{
    struct stp_render_params p = { .method = STP_METHOD_PYRAMID, .min_splat = -1, .aovs = 127 };
    expect_as_whole(&p, 3, "3 chunks");
    p.samples = 4;
    expect_as_whole(&p, 3, "3 chunks, 4 samples");
}

static void without_atomics(void **state)
{
    struct stp_render_params p = { .method = STP_METHOD_PYRAMID, .aovs = 127 };
    p.mask_features = STP_FEATURE_INT64_ATOMICS;
    expect_as_whole(&p, 0, "32 bits");
    p.samples = 4;
    expect_as_whole(&p, 0, "32 bits, 4 samples");
    p.samples = 1;
    expect_as_whole(&p, 3, "32 bits, 3 chunks");
}

/* Discs of many pixels: the rim is splatted. */
static void rim_without_atomics(void **state)
{
    struct stp_camera camera = plain_camera(160, 120, 120);
    struct stp_render_params p = { .method = STP_METHOD_PYRAMID };
    struct stp_scene *scene = scene_random(5, 300, 0.1);
    struct stp_image *image[2];
    for (int masked = 0; masked < 2; masked++) {
        p.mask_features = masked ? STP_FEATURE_INT64_ATOMICS : 0;
        struct stp_plan *plan = plan_in(scene, &camera, &p, 0);
        assert_true(plan->rim_far);
        image[masked] = device_render_plan(&device, scene, plan);
        stp_plan_destroy(&plan);
    }
    expect_same_bits(image[1], image[0], "rim");
    stp_image_destroy(&image[0]);
    stp_image_destroy(&image[1]);
    stp_scene_destroy(&scene);
}

/* Chunks and tiles, many of both, and no pixel of another chunk's leavings: the last chunk hides
 * all that came before, then the first one does. */
static void near_last_and_first(void **state)
{
    struct stp_camera camera = plain_camera(96, 96, 96);
    struct stp_render_params p = { .method = STP_METHOD_PYRAMID, .min_splat = -1 };
    for (int near_last = 0; near_last < 2; near_last++) {
        struct stp_scene *scene = scene_make(160000, 1, 0.01);
        for (int sheet = 0; sheet < 4; sheet++)
            for (int i = 0; i < 40000; i++) {
                int order = near_last ? 3 - sheet : sheet;
                size_t at = scene_add(
                    scene, v3(i % 200 * 0.01 - 0.995, i / 200 * 0.01 - 0.995, -2 - order * 0.1),
                    v3(0, 0, 1), 0.011);
                scene_paint(scene, at, order == 0, order > 0, 0);
            }
        scene_finish(scene);
        struct stp_plan *plan = plan_in(scene, &camera, &p, (uint64_t)5 << 20);
        assert_true(plan->chunk_count >= 4);
        struct stp_image *image = device_render_plan(&device, scene, plan);
        for (uint32_t y = 8; y < 88; y++)
            for (uint32_t x = 8; x < 88; x++)
                assert_true(value(image, "G", x, y) < value(image, "R", x, y));
        stp_image_destroy(&image);
        stp_plan_destroy(&plan);
        stp_scene_destroy(&scene);
    }
}

static struct stp_scene *load(const char *path, size_t chunk)
{
    struct stp_load_params params = { .stream_above = chunk ? 1 : 0, .stream_chunk = chunk };
    struct stp_prepare_params prepare = { .two_sided = STP_ON };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_load(&device.env, path, &params, &scene), STP_OK);
    assert_int_equal(stp_scene_prepare(&device.env, scene, &prepare), STP_OK);
    return scene;
}

/* A scene that stays in its file, through a device that holds all of it, and one that does not. */
static void from_the_file(void **state)
{
    struct stp_camera camera = plain_camera(250, 190, 165);
    struct stp_render_params p = { .method = STP_METHOD_PYRAMID,
                                   .min_splat = -1,
                                   .aovs = 127 & ~STP_AOV_ID };
    char path[] = "/tmp/stipple_chunks_XXXXXX";
    assert_true(mkstemp(path) >= 0);
    struct stp_scene *made = heap_scene(1);
    assert_int_equal(stp_scene_save(&device.env, made, path), STP_OK);
    struct stp_scene *whole = load(path, 0), *stream = load(path, 40000);
    assert_non_null(stream->stream);
    struct stp_plan *plan = plan_in(whole, &camera, &p, 0);
    struct stp_image *truth = device_render_plan(&device, whole, plan);
    stp_plan_destroy(&plan);
    static const uint64_t heaps[] = { 0, 2 << 20 };
    for (unsigned i = 0; i < 2; i++) {
        plan = plan_in(stream, &camera, &p, heaps[i]);
        assert_true(plan->chunk_count >= stream->stream->chunk_count + i);
        struct stp_image *image = device_render_plan(&device, stream, plan);
        expect_same_bits(image, truth, i ? "from the file, in pieces" : "from the file");
        stp_image_destroy(&image);
        stp_plan_destroy(&plan);
    }
    p.method = STP_METHOD_EXACT;
    assert_int_equal(device_plan(&device, stream, &camera, &p, &plan), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(device.last, "--stream off"));
    p.method = STP_METHOD_PYRAMID;
    p.aovs = STP_AOV_ID;
    assert_int_equal(device_plan(&device, stream, &camera, &p, &plan), STP_ERROR_ARGUMENT);
    stp_image_destroy(&truth);
    stp_scene_destroy(&made);
    stp_scene_destroy(&whole);
    stp_scene_destroy(&stream);
    remove(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chunks_are_as_one),   cmocka_unit_test(without_atomics),
        cmocka_unit_test(rim_without_atomics), cmocka_unit_test(near_last_and_first),
        cmocka_unit_test(from_the_file),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
