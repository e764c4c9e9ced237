/* Pictures in a host's frame: the same bits as stp_render's, hidden by triangles and hiding them,
 * in every format, with nothing allocated while they are recorded. */
#include "stage.h"

#include <math.h>

#include "base/memory.h"

/* One picture over black; the texels of the colour target. */
static float *embedded_at(struct stage *s, const struct stp_plan *plan,
                          const struct stp_resident *resident,
                          const struct stp_host_frame_params *params, struct stp_targets targets)
{
    struct engine *e = &s->engine;
    struct stp_frame *frame = stage_frame(e, s->context, plan, params);
    VkCommandBuffer commands = engine_begin(e, 0);
    stage_clear(commands, s, NULL, 0);
    if (stp_frame_record(&e->env, frame, resident, &s->camera, &targets, commands))
        fail_msg("not recorded: %s", e->last);
    engine_submit(e, 0);
    float *texels = engine_read(e, &s->color, 16);
    stp_frame_destroy(&frame);
    return texels;
}

static float *embedded(struct stage *s, const struct stp_plan *plan,
                       const struct stp_resident *resident,
                       const struct stp_host_frame_params *params)
{
    return embedded_at(s, plan, resident, params, stage_targets(s));
}

static const struct {
    struct stp_render_params params;
    const char *name;
} ways[] = {
    { { .method = STP_METHOD_EXACT }, "exact" },
    { { .method = STP_METHOD_EXACT, .samples = 4 }, "exact, samples" },
    { { .method = STP_METHOD_EXACT, .memory_limit = 1000000 }, "exact, tiles" },
    { { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE }, "two-pass compute" },
    { { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER }, "two-pass raster" },
    { { .method = STP_METHOD_DEFERRED, .path = STP_PATH_COMPUTE }, "deferred compute" },
    { { .method = STP_METHOD_DEFERRED, .path = STP_PATH_RASTER }, "deferred raster" },
};

static void test_same_bits(void **state)
{
    const struct stp_host_frame_params formats[] = {
        { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT },
        { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT,
          .depth_format = VK_FORMAT_D32_SFLOAT,
          .depth_reversed = true },
        { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT, .composite = STP_COMPOSITE_REPLACE },
    };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    for (unsigned i = 0; i < sizeof ways / sizeof *ways; i++) {
        struct stp_plan *plan =
            stage_plan(&s.engine, s.context, s.scene, &s.camera, &ways[i].params);
        struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
        unsigned count = i == 0 ? sizeof formats / sizeof *formats : 1;
        struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, &ways[i].params);
        for (unsigned f = 0; f < count; f++) {
            float *texels = embedded(&s, plan, resident, &formats[f]);
            stage_same(expected, texels, ways[i].name);
            free(texels);
        }
        stp_image_destroy(&expected);
        stp_resident_destroy(&resident);
        stp_plan_destroy(&plan);
    }
    stage_close(&s);
}

/* A plan that was made where neither plane cuts anything, then near goes through the ball, then
 * far. */
static void test_planes_that_come(void **state)
{
    const struct stp_host_frame_params format = { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct stp_camera from = s.camera;
    double middle = -from.world_to_camera[11]; /* the ball is round the origin */
    for (unsigned i = 0; i < 2 * sizeof ways / sizeof *ways; i++) {
        const struct stp_render_params *params = &ways[i / 2].params;
        s.camera = from;
        struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, params);
        struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
        struct stp_image *whole = stage_offline(&s.engine, s.scene, &s.camera, params);
        *(i % 2 ? &s.camera.far_depth : &s.camera.near_depth) = middle;
        struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, params);
        float *texels = embedded(&s, plan, resident, &format);
        stage_same(expected, texels, ways[i / 2].name);
        size_t bytes = sizeof(float) * expected->width * expected->height;
        if (i % 2 == 0)
            assert_memory_not_equal(stage_plane(whole, "Z"), stage_plane(expected, "Z"), bytes);
        free(texels);
        stp_image_destroy(&whole);
        stp_image_destroy(&expected);
        stp_resident_destroy(&resident);
        stp_plan_destroy(&plan);
    }
    stage_close(&s);
}

/* What was recorded with fewer features enabled, or through staging memory, or with the splats in a
 * buffer of the host's, is the same picture as offline with those features masked. */
/* A picture may lie anywhere: outside of the image nothing is drawn, however far outside. A size
 * that no int holds bounds nothing. */
static void test_far_places(void **state)
{
    const struct stp_host_frame_params format = { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT };
    const int32_t place[][2] = { { INT32_MAX, 0 },         { 0, INT32_MAX }, { INT32_MAX - 8, 3 },
                                 { 3, INT32_MAX - 8 },     { INT32_MIN, 0 }, { 0, INT32_MIN },
                                 { INT32_MAX, INT32_MIN }, { WIDTH, 0 },     { 0, -HEIGHT } };
    const uint32_t sizes[] = { (uint32_t)INT32_MAX + 1, UINT32_MAX };
    static const float nothing[4 * WIDTH * HEIGHT];
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &ways[0].params);
    struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
    for (unsigned i = 0; i < sizeof place / sizeof *place; i++) {
        struct stp_targets targets = stage_targets(&s);
        targets.x = place[i][0];
        targets.y = place[i][1];
        float *texels = embedded_at(&s, plan, resident, &format, targets);
        assert_memory_equal(texels, nothing, sizeof nothing);
        free(texels);
    }
    struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, &ways[0].params);
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct stp_targets targets = stage_targets(&s);
        targets.width = targets.height = sizes[i];
        float *texels = embedded_at(&s, plan, resident, &format, targets);
        stage_same(expected, texels, "a size that no int holds");
        free(texels);
    }
    stp_image_destroy(&expected);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

static void test_masked(void **state)
{
    const struct {
        const char *name;
        unsigned feature;
    } masked[] = { { "shaderBufferInt64Atomics", STP_FEATURE_INT64_ATOMICS },
                   { "shaderOutputLayer", STP_FEATURE_VERTEX_LAYER },
                   { "shaderFloat64", STP_FEATURE_FLOAT64 } };
    const struct stp_host_frame_params format = { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT };
    for (unsigned i = 0; i < sizeof masked / sizeof *masked; i++) {
        struct stage s;
        stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, masked[i].name);
        assert_int_equal(stp_context_limits(s.context)->features & masked[i].feature, 0);
        struct stp_render_params params = { .method = STP_METHOD_TWO_PASS };
        struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &params);
        struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
        params.mask_features = masked[i].feature;
        struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, &params);
        float *texels = embedded(&s, plan, resident, &format);
        stage_same(expected, texels, masked[i].name);
        free(texels);
        stp_image_destroy(&expected);
        stp_resident_destroy(&resident);
        stp_plan_destroy(&plan);
        stage_close(&s);
    }
}

static void test_staged(void **state)
{
    const struct stp_host_frame_params format = { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT };
    struct stp_render_params params = { .method = STP_METHOD_DEFERRED, .path = STP_PATH_RASTER };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    stp_context_destroy(&s.context);
    struct stp_import import = engine_import(&s.engine);
    import.mask_features = STP_FEATURE_SHARED_MEMORY;
    assert_int_equal(stp_context_import(&s.engine.env, &import, &s.context), STP_OK);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &params);
    struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
    struct stp_image *expected = stage_offline(&s.engine, s.scene, &s.camera, &params);
    float *texels = embedded(&s, plan, resident, &format);
    stage_same(expected, texels, "staged");
    VkCommandBuffer commands = engine_begin(&s.engine, 0);
    assert_int_equal(stp_resident_record_upload(&s.engine.env, resident, commands, s.engine.family),
                     STP_ERROR_ARGUMENT);
    engine_submit(&s.engine, 0);
    free(texels);
    stp_image_destroy(&expected);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

/* A triangle across the picture at eye depth z: everything nearer stays, the rest is hidden. */
static struct engine_triangle across(double z, double near, double far, bool reversed)
{
    double d = far < INFINITY ? far / (far - near) - near * far / (far - near) / z : 1 - near / z;
    float depth = (float)(reversed ? 1 - d : d);
    return (struct engine_triangle){
        .clip = { { -1, -1, depth, 1 }, { 3, -1, depth, 1 }, { -1, 3, depth, 1 } },
        .color = { 1, 0, 0, 1 }
    };
}

struct convention {
    VkFormat format;
    bool reversed;
    double far;
    double step; /* of eye depth, relative, that the format cannot tell */
};

/* The triangle drawn before or after the splats: either way each pixel shows what is nearer. */
static void expect_hidden(struct stage *s, struct stp_frame *frame,
                          const struct stp_resident *resident, const struct stp_image *picture,
                          const struct convention *c, bool triangle_first, double z)
{
    struct engine *e = &s->engine;
    struct stp_targets targets = stage_targets(s);
    VkPipeline pipeline = engine_pipeline(e, s->color.format, c->format, c->reversed);
    struct engine_triangle triangle = across(z, 0.1, c->far, c->reversed);
    targets.depth_far = c->far;
    VkCommandBuffer commands = engine_begin(e, 0);
    stage_clear(commands, s, NULL, c->reversed ? 0 : 1);
    if (triangle_first)
        engine_draw(e, commands, pipeline, &s->color, &s->depth, &triangle);
    assert_int_equal(stp_frame_record(&e->env, frame, resident, &s->camera, &targets, commands),
                     STP_OK);
    if (!triangle_first)
        engine_draw(e, commands, pipeline, &s->color, &s->depth, &triangle);
    engine_submit(e, 0);
    float *texels = engine_read(e, &s->color, 16);
    const float *depth = stage_plane(picture, "Z"), *red = stage_plane(picture, "R");
    size_t nearer = 0, behind = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
        if (fabs(depth[i] / z - 1) < c->step)
            continue;
        bool surface = (double)depth[i] < z;
        nearer += surface;
        behind += !surface;
        if (texels[4 * i] != (surface ? red[i] : 1))
            fail_msg("format %d%s, far %g, triangle %s at %g: pixel %zu at depth %g is %g",
                     c->format, c->reversed ? " reversed" : "", c->far,
                     triangle_first ? "first" : "last", z, i, (double)depth[i],
                     (double)texels[4 * i]);
    }
    assert_true(nearer > 100 && behind > 100);
    free(texels);
    vkDestroyPipeline(e->device, pipeline, NULL);
}

static void test_hidden(void **state)
{
    /* Steps: twice that of the format at depths of 3 with the near plane at 0.1. */
    const struct convention conventions[] = {
        { VK_FORMAT_D32_SFLOAT, true, INFINITY, 1e-5 },
        { VK_FORMAT_D32_SFLOAT, false, INFINITY, 1e-5 },
        { VK_FORMAT_D32_SFLOAT, true, 50, 1e-5 },
        { VK_FORMAT_D32_SFLOAT, false, 50, 1e-5 },
        { VK_FORMAT_D16_UNORM, false, 50, 2e-3 },
        { VK_FORMAT_D16_UNORM, true, INFINITY, 2e-3 },
        { VK_FORMAT_D32_SFLOAT_S8_UINT, true, INFINITY, 1e-5 },
        { VK_FORMAT_D24_UNORM_S8_UINT, false, 50, 1e-5 },
    };
    for (unsigned i = 0; i < sizeof conventions / sizeof *conventions; i++) {
        struct stage s;
        struct stp_render_params params = { .method = STP_METHOD_EXACT };
        stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
        VkFormatProperties properties;
        vkGetPhysicalDeviceFormatProperties(s.engine.physical, conventions[i].format, &properties);
        if (!(properties.optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT)) {
            /* Vulkan asks for one of D24S8 and D32S8 only. */
            assert_true(conventions[i].format == VK_FORMAT_D24_UNORM_S8_UINT ||
                        conventions[i].format == VK_FORMAT_D32_SFLOAT_S8_UINT);
            stage_close(&s);
            continue;
        }
        engine_image_close(&s.engine, &s.depth);
        engine_image_open(&s.engine, conventions[i].format, WIDTH, HEIGHT, &s.depth);
        struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &params);
        struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
        struct stp_image *picture = stage_offline(&s.engine, s.scene, &s.camera, &params);
        const float *depth = stage_plane(picture, "Z");
        double z = (double)depth[(size_t)WIDTH * (HEIGHT / 2) + WIDTH / 2] + 0.3;
        struct stp_host_frame_params format = { .color_format = s.color.format,
                                                .depth_format = conventions[i].format,
                                                .depth_reversed = conventions[i].reversed };
        struct stp_frame *frame = stage_frame(&s.engine, s.context, plan, &format);
        expect_hidden(&s, frame, resident, picture, &conventions[i], true, z);
        expect_hidden(&s, frame, resident, picture, &conventions[i], false, z);
        stp_frame_destroy(&frame);
        stp_image_destroy(&picture);
        stp_resident_destroy(&resident);
        stp_plan_destroy(&plan);
        stage_close(&s);
    }
}

/* Recording allocates nothing, by any method. */
static void test_record_allocates_nothing(void **state)
{
    struct stage s;
    stage_open(&s, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    for (unsigned i = 0; i < sizeof ways / sizeof *ways; i++) {
        struct stp_plan *plan =
            stage_plan(&s.engine, s.context, s.scene, &s.camera, &ways[i].params);
        struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
        struct stp_host_frame_params params = { .color_format = s.color.format,
                                                .depth_format = s.depth.format };
        struct stp_frame *frame = stage_frame(&s.engine, s.context, plan, &params);
        struct stp_targets targets = stage_targets(&s);
        VkCommandBuffer commands = engine_begin(&s.engine, 0);
        stage_clear(commands, &s, NULL, 1);
        mem_fail_at(1); /* the next allocation would fail */
        enum stp_result result =
            stp_frame_record(&s.engine.env, frame, resident, &s.camera, &targets, commands);
        unsigned long count = mem_count();
        mem_fail_at(0);
        assert_int_equal(result, STP_OK);
        assert_int_equal(count, 0);
        engine_submit(&s.engine, 0);
        engine_finish(&s.engine);
        stp_frame_destroy(&frame);
        stp_resident_destroy(&resident);
        stp_plan_destroy(&plan);
    }
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_planes_that_come),
        cmocka_unit_test(test_far_places),
        cmocka_unit_test(test_masked),
        cmocka_unit_test(test_staged),
        cmocka_unit_test(test_hidden),
        cmocka_unit_test(test_record_allocates_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
