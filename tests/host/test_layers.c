/* Transparent splats in a host's frame. What a plane of the host's hides is what a far plane at its
 * depth would have cut, layer by layer; where the host draws nothing, the picture has the bits of
 * stp_render's. */
#include "stage.h"

#include <math.h>

#define NEAR 0.1

enum { OUTER = 900, INNER = 500 };

/* A bumpy ball that lets light through, around a smaller one that may be opaque; or that alone. */
static struct stp_scene *balls(struct engine *e, bool both, float inner)
{
    double(*position)[3] = malloc((OUTER + INNER) * sizeof *position);
    float *opacity = malloc((OUTER + INNER) * sizeof *opacity);
    size_t count = 0;
    for (int i = both ? 0 : OUTER; i < OUTER + INNER; i++, count++) {
        bool small = i >= OUTER;
        int n = small ? INNER : OUTER, at = small ? i - OUTER : i;
        double z = 1 - (2.0 * at + 1) / n, ring = sqrt(1 - z * z), turn = at * 2.399963;
        double r = small ? 0.45 : 1 + 0.05 * sin(5 * turn);
        memcpy(position[count], (double[3]){ r * ring * cos(turn), r * ring * sin(turn), r * z },
               sizeof *position);
        opacity[count] = small ? inner : 0.4f;
    }
    struct stp_points points = { .count = count,
                                 .position = (const double(*)[3])position,
                                 .opacity = opacity };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(&e->env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(&e->env, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(&e->env, scene, NULL), STP_OK);
    free(position);
    free(opacity);
    return scene;
}

/* What is drawn: a scene, its plan, and a frame of it. */
struct drawn {
    struct stp_scene *scene;
    struct stp_render_params params;
    struct stp_plan *plan;
    struct stp_resident *resident;
    struct stp_frame *frame;
    struct stp_frame *plain; /* of a host without depth; where a test asks for it */
};

static void make_frame(struct stage *s, struct drawn *d, const struct stp_host_frame_params *host)
{
    d->plan = stage_plan(&s->engine, s->context, d->scene, &s->camera, &d->params);
    d->resident = stage_resident(&s->engine, s->context, d->scene, d->plan, NULL);
    d->frame = stage_frame(&s->engine, s->context, d->plan, host);
}

static struct drawn draw_open(struct stage *s, struct stp_scene *scene,
                              const struct stp_render_params *params,
                              const struct stp_host_frame_params *host)
{
    struct drawn d = { .scene = scene, .params = *params };
    s->camera = stage_view(scene, WIDTH, HEIGHT, 0.4);
    make_frame(s, &d, host);
    return d;
}

static void draw_close(struct drawn *d)
{
    stp_frame_destroy(&d->frame);
    stp_frame_destroy(&d->plain);
    stp_resident_destroy(&d->resident);
    stp_plan_destroy(&d->plan);
    stp_scene_destroy(&d->scene);
}

/* Over black and a cleared depth, with a triangle across all of it before where there is one. */
static void draw(struct stage *s, struct stp_frame *frame, const struct drawn *d,
                 const struct stp_targets *targets, bool reversed,
                 const struct engine_triangle *triangle)
{
    struct engine *e = &s->engine;
    VkPipeline pipeline = engine_pipeline(e, s->color.format, s->depth.format, reversed);
    VkCommandBuffer commands = engine_begin(e, 0);
    stage_clear(commands, s, NULL, reversed ? 0 : 1);
    if (triangle)
        engine_draw(e, commands, pipeline, &s->color, &s->depth, triangle);
    if (stp_frame_record(&e->env, frame, d->resident, &s->camera, targets, commands))
        fail_msg("not recorded: %s", e->last);
    engine_submit(e, 0);
    engine_finish(e);
    vkDestroyPipeline(e->device, pipeline, NULL);
}

/* The picture that a far plane at z cuts; the colour target's texels. */
static float *draw_cut(struct stage *s, struct drawn *d, double z)
{
    const struct stp_host_frame_params plain = { .color_format = s->color.format };
    struct stp_camera camera = s->camera;
    struct stp_targets targets = stage_targets(s);
    if (!d->plain)
        d->plain = stage_frame(&s->engine, s->context, d->plan, &plain);
    s->camera.far_depth = z;
    draw(s, d->plain, d, &targets, false, NULL);
    s->camera = camera;
    return engine_read(&s->engine, &s->color, 16);
}

static void test_same_bits(void **state)
{
    const struct stp_host_frame_params hosts[] = {
        { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT },
        { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT,
          .depth_format = VK_FORMAT_D32_SFLOAT,
          .depth_reversed = true },
        { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT, .composite = STP_COMPOSITE_REPLACE },
        { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT,
          .depth_format = VK_FORMAT_D32_SFLOAT,
          .depth_reversed = true,
          .depth_read_only = true },
    };
    const struct stp_render_params ways[] = {
        { .method = STP_METHOD_EXACT },
        { .method = STP_METHOD_EXACT, .samples = 4 },
        { .method = STP_METHOD_EXACT, .memory_limit = 2000000 }, /* tiles */
    };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    for (unsigned w = 0; w < sizeof ways / sizeof *ways; w++) {
        unsigned first = w == 0 ? 0 : 1, end = w == 0 ? sizeof hosts / sizeof *hosts : 2;
        struct drawn d =
            draw_open(&s, balls(&s.engine, true, w % 2 ? 1 : 0.7f), &ways[w], &hosts[first]);
        struct stp_targets targets = stage_targets(&s);
        struct stp_image *expected = stage_offline(&s.engine, d.scene, &s.camera, &ways[w]);
        for (unsigned h = first; h < end; h++) {
            if (h > first) {
                stp_frame_destroy(&d.frame);
                d.frame = stage_frame(&s.engine, s.context, d.plan, &hosts[h]);
            }
            draw(&s, d.frame, &d, &targets, true, NULL);
            float *texels = engine_read(&s.engine, &s.color, 16);
            stage_same(expected, texels, "layers");
            free(texels);
        }
        stp_image_destroy(&expected);
        draw_close(&d);
    }
    stage_close(&s);
}

struct convention {
    VkFormat format;
    bool reversed;
    double far;
    double steps; /* of a normalised format; 0: float */
};

/* Hardware depth of eye depth z as the format keeps it, and back. */
static double hardware(const struct convention *c, double z)
{
    double d = c->far < INFINITY ? c->far / (c->far - NEAR) - NEAR * c->far / (c->far - NEAR) / z
                                 : 1 - NEAR / z;
    if (c->reversed)
        d = c->far < INFINITY ? 1 - d : NEAR / z;
    return c->steps > 0 ? round(d * c->steps) / c->steps : (double)(float)d;
}

static double eye(const struct convention *c, double d)
{
    double forward = c->reversed ? 1 - d : d;
    if (c->far < INFINITY)
        return NEAR * c->far / (c->far - forward * (c->far - NEAR));
    return NEAR / (c->reversed ? d : 1 - d);
}

static struct engine_triangle across(double d)
{
    float depth = (float)d;
    return (struct engine_triangle){
        .clip = { { -1, -1, depth, 1 }, { 3, -1, depth, 1 }, { -1, 3, depth, 1 } },
        .color = { 1, 0, 0, 1 }
    };
}

/* Texels against those that a far plane cuts, over the triangle's red. */
static void expect_over(const float *texels, const float *cut, const char *what)
{
    for (size_t i = 0; i < 4 * (size_t)WIDTH * HEIGHT; i++) {
        float alpha = cut[i / 4 * 4 + 3];
        float expected = i % 4 == 3 ? 1 : cut[i] + (i % 4 == 0 ? 1 - alpha : 0);
        if (!(fabsf(texels[i] - expected) <= 1e-6f))
            fail_msg("%s: channel %zu of pixel %zu is %g, not %g", what, i % 4, i / 4,
                     (double)texels[i], (double)expected);
    }
}

/* The plane hides some and not all: of the pixels that `whole` covers. */
static void expect_some(const float *cut, const float *whole)
{
    size_t changed = 0, left = 0;
    for (size_t i = 3; i < 4 * (size_t)WIDTH * HEIGHT; i += 4) {
        changed += cut[i] < whole[i] - 0.01f;
        left += cut[i] > 0;
    }
    assert_true(changed > 100 && left > 100);
}

static void expect_cut(struct stage *s, struct drawn *d, const struct convention *c, double at)
{
    double depth = hardware(c, at), z = eye(c, depth);
    struct stp_targets targets = stage_targets(s);
    struct engine_triangle triangle = across(depth);
    char what[100];
    snprintf(what, sizeof what, "format %d%s, far %g, plane at %g", c->format,
             c->reversed ? " reversed" : "", c->far, z);
    targets.depth_near = NEAR;
    targets.depth_far = c->far;
    draw(s, d->frame, d, &targets, c->reversed, &triangle);
    float *texels = engine_read(&s->engine, &s->color, 16);
    float *cut = draw_cut(s, d, z), *whole = draw_cut(s, d, INFINITY);
    expect_over(texels, cut, what);
    expect_some(cut, whole);
    free(texels);
    free(cut);
    free(whole);
}

static bool is_supported(const struct stage *s, VkFormat format)
{
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(s->engine.physical, format, &properties);
    if (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT)
        return true;
    /* Vulkan asks for one of each of these pairs only. */
    assert_true(format != VK_FORMAT_D32_SFLOAT && format != VK_FORMAT_D16_UNORM);
    return false;
}

/* A far plane cuts fragments; the payload that keeps depths as floats knows them as the plane
 * does. */
static const struct stp_render_params by_id = { .method = STP_METHOD_EXACT,
                                                .payload = STP_PAYLOAD_ID };

static void test_cut(void **state)
{
    const struct convention conventions[] = {
        { VK_FORMAT_D32_SFLOAT, true, INFINITY, 0 },
        { VK_FORMAT_D32_SFLOAT, false, INFINITY, 0 },
        { VK_FORMAT_D32_SFLOAT, false, 50, 0 },
        { VK_FORMAT_D16_UNORM, false, 50, 65535 },
        { VK_FORMAT_D16_UNORM, true, INFINITY, 65535 },
        { VK_FORMAT_D32_SFLOAT_S8_UINT, true, 50, 0 },
        { VK_FORMAT_D24_UNORM_S8_UINT, false, 50, 16777215 },
        { VK_FORMAT_X8_D24_UNORM_PACK32, true, 50, 16777215 },
    };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    const struct stp_host_frame_params plain = { .color_format = s.color.format };
    struct drawn d = draw_open(&s, balls(&s.engine, true, 1), &by_id, &plain);
    double middle = -s.camera.world_to_camera[11];
    for (unsigned i = 0; i < sizeof conventions / sizeof *conventions; i++) {
        const struct convention *c = &conventions[i];
        if (!is_supported(&s, c->format))
            continue;
        engine_image_close(&s.engine, &s.depth);
        engine_image_open(&s.engine, c->format, WIDTH, HEIGHT, &s.depth);
        struct stp_host_frame_params host = { .color_format = s.color.format,
                                              .depth_format = c->format,
                                              .depth_reversed = c->reversed };
        stp_frame_destroy(&d.frame);
        d.frame = stage_frame(&s.engine, s.context, d.plan, &host);
        expect_cut(&s, &d, c, middle - 0.7);
        expect_cut(&s, &d, c, middle + 0.05);
    }
    draw_close(&d);
    stage_close(&s);
}

/* Depth is written where something opaque ends the ray, and stays as it was elsewhere. */
static void expect_depth(struct stage *s, const struct stp_image *opaque,
                         const struct convention *c, double plane)
{
    bool wide = c->format == VK_FORMAT_D32_SFLOAT;
    void *words = engine_read(&s->engine, &s->depth, wide ? 4 : 2);
    const float *z = stage_plane(opaque, "Z");
    size_t solid = 0, kept = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
        double is = wide ? (double)((float *)words)[i] : ((uint16_t *)words)[i] / 65535.0;
        bool hit = (double)z[i] < plane;
        double expected = hardware(c, hit ? (double)z[i] : plane);
        /* Of a float, an averaged depth may differ in the last bits; of 16 bits, in the last. */
        double step = !hit ? 0 : wide ? 4e-7 * expected : 1 / 65535.0;
        if (!(fabs(is - expected) <= step))
            fail_msg("format %d: depth of pixel %zu is %.9g, not %.9g", c->format, i, is, expected);
        solid += hit;
        kept += !hit;
    }
    assert_true(solid > 100 && kept > 100);
    free(words);
}

static void test_depth_of_what_is_opaque(void **state)
{
    const struct convention conventions[] = { { VK_FORMAT_D32_SFLOAT, true, INFINITY, 0 },
                                              { VK_FORMAT_D16_UNORM, false, 50, 65535 } };
    struct stp_render_params params = by_id;
    struct stage s;
    params.epsilon = 0.05;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    for (unsigned i = 0; i < 2; i++) {
        const struct convention *c = &conventions[i];
        engine_image_close(&s.engine, &s.depth);
        engine_image_open(&s.engine, c->format, WIDTH, HEIGHT, &s.depth);
        struct stp_host_frame_params host = { .color_format = s.color.format,
                                              .depth_format = c->format,
                                              .depth_reversed = c->reversed };
        struct drawn d = draw_open(&s, balls(&s.engine, true, 1), &params, &host);
        struct stp_scene *inner = balls(&s.engine, false, 1);
        struct stp_image *opaque = stage_offline(&s.engine, inner, &s.camera, &params);
        double plane = -s.camera.world_to_camera[11] + 0.3;
        struct engine_triangle triangle = across(hardware(c, plane));
        struct stp_targets targets = stage_targets(&s);
        targets.depth_near = NEAR;
        targets.depth_far = c->far;
        draw(&s, d.frame, &d, &targets, c->reversed, &triangle);
        expect_depth(&s, opaque, c, plane);
        stp_image_destroy(&opaque);
        stp_scene_destroy(&inner);
        draw_close(&d);
    }
    stage_close(&s);
}

/* A depth that is only tested keeps every bit, and what is clear alone writes none. */
static void test_depth_is_kept(void **state)
{
    const struct convention c = { VK_FORMAT_D32_SFLOAT, true, INFINITY, 0 };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    for (unsigned i = 0; i < 2; i++) {
        struct stp_host_frame_params host = { .color_format = s.color.format,
                                              .depth_format = c.format,
                                              .depth_reversed = true,
                                              .depth_read_only = i == 1 };
        struct drawn d = draw_open(&s, balls(&s.engine, true, i == 1 ? 1 : 0.5f), &by_id, &host);
        struct stp_targets targets = stage_targets(&s);
        float plane = (float)hardware(&c, -s.camera.world_to_camera[11]);
        struct engine_triangle triangle = across((double)plane);
        draw(&s, d.frame, &d, &targets, true, &triangle);
        float *depth = engine_read(&s.engine, &s.depth, 4);
        for (size_t p = 0; p < (size_t)WIDTH * HEIGHT; p++)
            assert_memory_equal(&depth[p], &plane, sizeof plane);
        free(depth);
        draw_close(&d);
    }
    stage_close(&s);
}

/* The picture hangs over the edges of the host's image, in tiles: what is inside of it is right. */
static void test_placed(void **state)
{
    const struct convention c = { VK_FORMAT_D32_SFLOAT, false, INFINITY, 0 };
    const int32_t corners[][2] = { { 9, 5 }, { -17, -23 }, { 30, -9 }, { 300, 0 } };
    struct stp_render_params params = by_id;
    params.memory_limit = 2000000;
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct stp_host_frame_params host = { .color_format = s.color.format,
                                          .depth_format = c.format };
    struct drawn d = draw_open(&s, balls(&s.engine, true, 0.7f), &params, &host);
    double depth = hardware(&c, -s.camera.world_to_camera[11]);
    float *cut = draw_cut(&s, &d, eye(&c, depth));
    for (unsigned i = 0; i < sizeof corners / sizeof *corners; i++) {
        struct engine_triangle triangle = across(depth);
        struct stp_targets targets = stage_targets(&s);
        targets.x = corners[i][0];
        targets.y = corners[i][1];
        draw(&s, d.frame, &d, &targets, false, &triangle);
        float *texels = engine_read(&s.engine, &s.color, 16);
        for (int32_t y = 0; y < HEIGHT; y++)
            for (int32_t x = 0; x < WIDTH; x++) {
                int32_t u = x - targets.x, v = y - targets.y;
                bool inside = u >= 0 && v >= 0 && u < WIDTH && v < HEIGHT;
                float expected = inside ? cut[4 * (v * WIDTH + u) + 1] : 0;
                assert_float_equal(texels[4 * (y * WIDTH + x) + 1], expected, 1e-6);
            }
        free(texels);
    }
    free(cut);
    draw_close(&d);
    stage_close(&s);
}

/* Sheets of one splat each, one behind the other: every ray through them has `count` fragments. */
static struct stp_scene *sheets(struct engine *e, size_t count)
{
    double(*position)[3] = malloc(count * sizeof *position);
    float(*normal)[3] = malloc(count * sizeof *normal);
    float *radius = malloc(count * sizeof *radius);
    for (size_t i = 0; i < count; i++) {
        memcpy(position[i], (double[3]){ 0, 0, -0.01 * (double)i }, sizeof *position);
        memcpy(normal[i], (float[3]){ 0, 0, 1 }, sizeof *normal);
        radius[i] = 0.5f;
    }
    struct stp_points points = { .count = count,
                                 .position = (const double(*)[3])position,
                                 .normal = (const float(*)[3])normal,
                                 .radius = radius };
    struct stp_object_params object = { .opacity = 0.1f };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(&e->env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(&e->env, scene, &points, &object), STP_OK);
    assert_int_equal(stp_scene_prepare(&e->env, scene, NULL), STP_OK);
    free(position);
    free(normal);
    free(radius);
    return scene;
}

/* More fragments than slots: alone too many layers for a frame, and before the plane few enough;
 * and, with eight sheets a layer, more than the slots in what the plane leaves. */
static void test_many_fragments(void **state)
{
    const struct convention c = { VK_FORMAT_D32_SFLOAT, true, INFINITY, 0 };
    const double epsilons[] = { 0.001, 0.0751 }, places[] = { 0.105, 0.905 };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct stp_host_frame_params host = { .color_format = s.color.format,
                                          .depth_format = c.format,
                                          .depth_reversed = true };
    for (unsigned i = 0; i < 2; i++) {
        struct stp_render_params params = by_id;
        params.epsilon = epsilons[i];
        struct drawn d = draw_open(&s, sheets(&s.engine, 150), &params, &host);
        s.camera = stage_view(d.scene, WIDTH, HEIGHT, 0); /* head on: equal depths in a sheet */
        expect_cut(&s, &d, &c, -s.camera.world_to_camera[11] + places[i]);
        draw_close(&d);
    }
    stage_close(&s);
}

/* Orthographic depth is affine. */
static void test_orthographic(void **state)
{
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    const struct stp_host_frame_params host = { .color_format = s.color.format,
                                                .depth_format = VK_FORMAT_D32_SFLOAT };
    const struct stp_frame_params flat = { .width = WIDTH, .height = HEIGHT, .orthographic = true };
    struct drawn d = { .scene = balls(&s.engine, true, 1), .params = by_id };
    assert_int_equal(stp_camera_frame(NULL, d.scene, &flat, &s.camera), STP_OK);
    make_frame(&s, &d, &host);
    struct stp_targets targets = stage_targets(&s);
    double z = -s.camera.world_to_camera[11] - 0.2;
    targets.depth_near = -1;
    targets.depth_far = 31;
    float depth = (float)((z + 1) / 32);
    struct engine_triangle triangle = across((double)depth);
    draw(&s, d.frame, &d, &targets, false, &triangle);
    float *texels = engine_read(&s.engine, &s.color, 16);
    float *cut = draw_cut(&s, &d, (double)depth * 32 - 1);
    expect_over(texels, cut, "orthographic");
    free(texels);
    free(cut);
    draw_close(&d);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_cut),
        cmocka_unit_test(test_depth_of_what_is_opaque),
        cmocka_unit_test(test_depth_is_kept),
        cmocka_unit_test(test_placed),
        cmocka_unit_test(test_many_fragments),
        cmocka_unit_test(test_orthographic),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
