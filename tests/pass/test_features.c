/* Devices that lack an optional feature: the pictures are still right, or the error names what is
 * missing. Validation would speak if a shader used a feature that was not enabled. */
#include "device.h"

static void expect_refused(struct device *device, const struct stp_scene *scene,
                           const struct stp_camera *camera, struct stp_render_params params,
                           const char *word)
{
    struct stp_plan *plan = NULL;
    unsigned lines = device->lines;
    assert_int_equal(device_plan(device, scene, camera, &params, &plan), STP_ERROR_FEATURE);
    assert_null(plan);
    assert_int_equal(device->lines, lines + 1);
    assert_non_null(strstr(device->last, word));
}

static void test_without_int64_atomics(void **state)
{
    struct device device;
    device_open(&device, STP_FEATURE_INT64_ATOMICS);
    struct stp_scene *scene = scene_random(31, 8, 0.05), *crowd = scene_random(32, 700, 0.3);
    struct stp_camera camera = hard_view(0, 33, 25);
    struct stp_render_params p = { .min_splat = 4, .method = STP_METHOD_DEFERRED };
    scene_own_groups(scene);
    p.path = STP_PATH_COMPUTE;
    expect_refused(&device, scene, &camera, p, "shaderBufferInt64Atomics");
    p.path = STP_PATH_AUTO; /* the rasteriser needs none */
    expect_reference(&device, scene, &camera, &p, &float_tolerance, "groups");
    p.method = STP_METHOD_TWO_PASS;
    expect_reference(&device, crowd, &camera, &p, &float_tolerance, "two 32-bit halves");
    p.method = STP_METHOD_EXACT; /* with repair */
    expect_reference(&device, crowd, &camera, &p, &packed_tolerance, "two 32-bit halves");
    stp_scene_destroy(&scene);
    stp_scene_destroy(&crowd);
    device_close(&device);
}

static void test_without_float32_blend(void **state)
{
    struct device device;
    device_open(&device, STP_FEATURE_FLOAT32_BLEND);
    struct stp_scene *scene = scene_random(33, 8, 0.05);
    struct stp_camera camera = hard_view(0, 33, 25);
    struct stp_render_params p = { .min_splat = 4,
                                   .method = STP_METHOD_TWO_PASS,
                                   .path = STP_PATH_RASTER };
    scene_own_groups(scene);
    expect_refused(&device, scene, &camera, p, "blend");
    p.path = STP_PATH_AUTO;
    expect_reference(&device, scene, &camera, &p, &float_tolerance, "sums by compute");
    p.method = STP_METHOD_DEFERRED;
    p.path = STP_PATH_RASTER;
    expect_reference(&device, scene, &camera, &p, &float_tolerance, "layers");
    stp_scene_destroy(&scene);
    device_close(&device);
}

/* Rasterised layers and sums are read as storage images; compute keeps its own in buffers. */
static void test_without_storage_formats(void **state)
{
    struct device device;
    device_open(&device, STP_FEATURE_STORAGE_FORMATS);
    struct stp_scene *scene = scene_random(37, 8, 0.05);
    struct stp_camera camera = hard_view(0, 33, 25);
    struct stp_render_params p = { .min_splat = 4 };
    scene_own_groups(scene);
    for (int m = STP_METHOD_DEFERRED; m <= STP_METHOD_EXACT; m++) {
        p.method = m;
        p.path = STP_PATH_AUTO;
        expect_reference(&device, scene, &camera, &p,
                         m == STP_METHOD_TWO_PASS ? &float_tolerance : &packed_tolerance,
                         "no storage formats");
        p.path = STP_PATH_RASTER;
        if (m != STP_METHOD_EXACT)
            expect_refused(&device, scene, &camera, p, "shaderStorageImageExtendedFormats");
    }
    stp_scene_destroy(&scene);
    device_close(&device);
}

/* Centres are projected in float32: outlines move, by less than a hundredth of a pixel here. */
static void test_without_float64(void **state)
{
    static const struct tolerance rough = {
        .color = 0.02, .normal = 0.03, .depth = 0.02, .psnr = 70, .fragile = 0.05
    };
    struct device device;
    device_open(&device, STP_FEATURE_FLOAT64);
    struct stp_scene *scene = scene_random(34, 120, 0.05);
    struct stp_camera camera = hard_view(0, 45, 33);
    struct stp_render_params p = { .min_splat = -1 };
    expect_everywhere(&device, scene, &camera, &p, "float32 centres");
    p.method = STP_METHOD_EXACT;
    camera = hard_view(3, 45, 33);
    expect_reference(&device, scene, &camera, &p, &rough, "float32 centres, 1 degree");
    stp_scene_destroy(&scene);
    device_close(&device);
}

static void test_without_int64(void **state)
{
    struct device device = { 0 };
    struct stp_context_params params = { .mask_features = STP_FEATURE_INT64 };
    assert_int_equal(stp_context_create(NULL, &params, &device.context), STP_ERROR_FEATURE);
    assert_null(device.context);
}

/* One layered pass, which plans choose for GPUs, against a pass a layer: the same bits, with slabs
 * and without. Where gl_Layer is masked a GPU takes a pass a layer too. */
static void test_vertex_layer(void **state)
{
    struct device device;
    device_open(&device, 0);
    struct stp_scene *scene = scene_random(35, 300, 0.1);
    struct stp_camera camera = hard_view(0, 61, 45);
    struct stp_limits gpu = *stp_context_limits(device.context);
    struct stp_group_params groups = { .overlap = 0.6 };
    gpu.processor = STP_PROCESSOR_GPU;
    assert_int_equal(stp_scene_group(&device.env, scene, &groups), STP_OK);
    for (int i = 0; i < 4; i++) {
        struct stp_plan *layered = NULL, *by_layer = NULL, *masked = NULL;
        struct stp_render_params p = { .method = STP_METHOD_DEFERRED,
                                       .path = STP_PATH_RASTER,
                                       .aovs = 127,
                                       .payload = i & 2 ? STP_PAYLOAD_PACKED : STP_PAYLOAD_ID,
                                       .voronoi = i & 1 ? STP_VORONOI_SLAB : STP_VORONOI_OFF };
        if (i & 2)
            p.aovs = 0, scene->facts.has_color = false;
        assert_int_equal(stp_plan_create(NULL, scene, &camera, &p, &gpu, &layered), STP_OK);
        assert_int_equal(device_plan(&device, scene, &camera, &p, &by_layer), STP_OK);
        p.mask_features = STP_FEATURE_VERTEX_LAYER;
        assert_int_equal(stp_plan_create(NULL, scene, &camera, &p, &gpu, &masked), STP_OK);
        assert_int_equal(layered->constant[PLAN_LAYERED], 1);
        assert_int_equal(by_layer->constant[PLAN_LAYERED], 0);
        assert_int_equal(masked->constant[PLAN_LAYERED], 0);
        assert_int_equal(by_layer->pass_count - layered->pass_count,
                         scene->facts.grouping.groups - 1);
        struct stp_image *a = device_render_plan(&device, scene, layered);
        struct stp_image *b = device_render_plan(&device, scene, by_layer);
        expect_same_bits(a, b, "one layered pass, a pass a layer");
        stp_image_destroy(&a);
        stp_image_destroy(&b);
        stp_plan_destroy(&layered);
        stp_plan_destroy(&by_layer);
        stp_plan_destroy(&masked);
    }
    stp_scene_destroy(&scene);
    device_close(&device);
}

/* Many groups: a pass for each by the rasteriser, and all of them composited. */
static void test_fifty_groups(void **state)
{
    struct device device;
    device_open(&device, 0);
    struct stp_scene *scene = scene_random(36, 50, 0.05);
    struct stp_camera camera = hard_view(0, 45, 33);
    static const float background[] = { 0, 0, 0.5f, 1 };
    struct stp_render_params p = { .method = STP_METHOD_DEFERRED,
                                   .path = STP_PATH_RASTER,
                                   .min_splat = 4,
                                   .background = background };
    struct stp_render_stats stats;
    struct stp_plan *plan = NULL;
    struct stp_image *image = NULL;
    scene_own_groups(scene);
    scene->facts.eye_dome = true;
    assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
    assert_int_equal(stp_render(&device.env, device.context, scene, plan, 1, &image, &stats),
                     STP_OK);
    assert_int_equal(stats.pass_count, plan->pass_count);
    struct verdict v = judge(scene, plan, image, &float_tolerance);
    assert_true(v.covered > 100 && v.off == 0 && v.psnr > 110);
    stp_image_destroy(&image);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    device_close(&device);
}

/* Opaque; transparent; every third splat opaque; opaque and painted. */
static struct stp_scene *veiled_cloud(int kind)
{
    const size_t count = 60;
    struct fixture *f = fixture_create(0.05);
    struct stp_scene *scene = scene_make(count, 1, 0.05);
    fill_randomly(f, 38, count);
    for (size_t i = 0; i < count; i++) {
        struct vec3 n = v3_loadf(f->normal[i]);
        scene_add(scene, v3_load(f->position[i]), v3_length(n) > 0 ? n : v3(0, 1, 0), f->radius[i]);
        if (kind == 3)
            scene_paint(scene, i, (float)(i % 7) / 7, 0.5f, 1);
        else if (kind > 0)
            scene_fade(scene, i, kind == 1 || i % 3 ? 0.4f : 1);
    }
    scene_finish(scene);
    free(f);
    return scene;
}

/* A picture with keys or slots read as texels has the same bits as one that reads them through
 * addresses. */
static void same_without_texels(struct device *device, const struct stp_scene *scene,
                                struct stp_render_params p)
{
    struct stp_camera camera = hard_view(0, 33, 25);
    struct stp_plan *fetched = NULL, *plain = NULL;
    assert_int_equal(device_plan(device, scene, &camera, &p, &fetched), STP_OK);
    p.mask_features = STP_FEATURE_TEXEL_BUFFERS;
    assert_int_equal(device_plan(device, scene, &camera, &p, &plain), STP_OK);
    assert_int_equal(fetched->resource[plan_find(fetched, PLAN_KEYS)].format, PLAN_TEXELS_RG32UI);
    assert_int_equal(plain->resource[plan_find(plain, PLAN_KEYS)].format, PLAN_BUFFER);
    struct stp_image *a = device_render_plan(device, scene, fetched);
    struct stp_image *b = device_render_plan(device, scene, plain);
    expect_same_bits(a, b, "read as texels, read by address");
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    stp_plan_destroy(&fetched);
    stp_plan_destroy(&plain);
}

/* Slots: opaque, in layers, with some of the splats opaque, packed and by id. */
static void test_slots_without_texel_buffers(void **state)
{
    struct device device;
    device_open(&device, 0);
    for (int i = 0; i < 6; i++) {
        struct stp_scene *scene = veiled_cloud(i / 2);
        struct stp_render_params p = { .aovs = 127,
                                       .min_splat = 4,
                                       .method = STP_METHOD_EXACT,
                                       .payload = i & 1 ? STP_PAYLOAD_ID : STP_PAYLOAD_PACKED };
        same_without_texels(&device, scene, p);
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* The pyramid's keys: without attributes, with colours, with ids. */
static void test_keys_without_texel_buffers(void **state)
{
    struct device device;
    device_open(&device, 0);
    for (int i = 0; i < 3; i++) {
        struct stp_scene *scene = veiled_cloud(i == 1 ? 3 : 0);
        struct stp_render_params p = { .aovs = i == 2 ? STP_AOV_ID : 0,
                                       .min_splat = 4,
                                       .method = STP_METHOD_PYRAMID };
        same_without_texels(&device, scene, p);
        stp_scene_destroy(&scene);
    }
    device_close(&device);
}

/* A plan that was made for a device with a feature, on one without: refused, by its name. */
static void expect_named(struct device *device, const struct stp_scene *scene,
                         const struct stp_camera *camera, const struct stp_render_params *params,
                         const char *name)
{
    struct stp_limits limits;
    struct stp_plan *plan = NULL;
    struct stp_image *image = NULL;
    unsigned lines = device->lines;
    stp_limits_lavapipe(&limits);
    assert_int_equal(stp_plan_create(&device->env, scene, camera, params, &limits, &plan), STP_OK);
    assert_int_equal(stp_render(&device->env, device->context, scene, plan, 0, &image, NULL),
                     STP_ERROR_FEATURE);
    assert_null(image);
    assert_int_equal(device->lines, lines + 1);
    assert_non_null(strstr(device->last, name));
    stp_plan_destroy(&plan);
}

static void test_plans_for_others(void **state)
{
    struct device device;
    struct stp_camera camera = hard_view(0, 33, 25);
    struct stp_scene *scene = scene_random(33, 8, 0.05);
    struct stp_render_params p = { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER };
    device_open(&device, STP_FEATURE_FLOAT32_BLEND | STP_FEATURE_TEXEL_BUFFERS);
    expect_named(&device, scene, &camera, &p, "float32-blend");
    p = (struct stp_render_params){ .method = STP_METHOD_EXACT };
    expect_named(&device, scene, &camera, &p, "texel-buffers");
    p.method = STP_METHOD_PYRAMID;
    expect_named(&device, scene, &camera, &p, "texel-buffers");
    p = (struct stp_render_params){ .method = STP_METHOD_TWO_PASS };
    expect_reference(&device, scene, &camera, &p, &float_tolerance, "neither blended nor fetched");
    stp_scene_destroy(&scene);
    device_close(&device);
}

/* Nothing to draw and nothing to copy, through staging: a copy of no bytes is no command. */
static void test_nothing_to_stage(void **state)
{
    struct device device;
    struct stp_camera camera = hard_view(0, 33, 25);
    struct stp_scene *scene = scene_make(9, 1, 0.05);
    device_open(&device, STP_FEATURE_SHARED_MEMORY);
    for (int i = 0; i < 9; i++)
        scene_fade(scene, scene_add(scene, v3(0.1 * i, 0, 0), v3(0, 0, 1), 0.1), 0);
    scene_finish(scene);
    assert_int_equal(stp_scene_cover(NULL, scene, NULL), STP_OK);
    for (int t = STP_TRANSPARENCY_FAST; t <= STP_TRANSPARENCY_EXACT; t++) {
        struct stp_render_params p = { .transparency = t };
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        struct stp_channel *alpha = stp_image_find(image, "A");
        for (size_t i = 0; i < (size_t)image->width * image->height; i++)
            assert_true(alpha->data.f[i] == 0);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
    device_close(&device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_without_int64_atomics),
        cmocka_unit_test(test_without_float32_blend),
        cmocka_unit_test(test_without_float64),
        cmocka_unit_test(test_without_int64),
        cmocka_unit_test(test_without_storage_formats),
        cmocka_unit_test(test_vertex_layer),
        cmocka_unit_test(test_fifty_groups),
        cmocka_unit_test(test_slots_without_texel_buffers),
        cmocka_unit_test(test_keys_without_texel_buffers),
        cmocka_unit_test(test_plans_for_others),
        cmocka_unit_test(test_nothing_to_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
