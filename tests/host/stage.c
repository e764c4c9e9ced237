#include "stage.h"

#include <math.h>

/* A bumpy ball of n points, with or without colours. */
struct stp_scene *stage_ball(struct engine *e, size_t n, bool colors, double size, float opacity)
{
    double(*position)[3] = malloc(n * sizeof *position);
    float(*color)[3] = malloc(n * sizeof *color);
    for (size_t i = 0; i < n; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)n, ring = sqrt(1 - z * z);
        double turn = (double)i * 2.399963, r = size * (1 + 0.05 * sin(5 * turn));
        memcpy(position[i], (double[3]){ r * ring * cos(turn), r * ring * sin(turn), r * z },
               sizeof *position);
        memcpy(color[i], (float[3]){ 0.2f, 0.5f, (float)(0.5 + 0.5 * z) }, sizeof *color);
    }
    struct stp_points points = { .count = n,
                                 .position = (const double(*)[3])position,
                                 .color = colors ? (const float(*)[3])color : NULL };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(&e->env, &scene), STP_OK);
    const struct stp_object_params object = { .opacity = opacity };
    assert_int_equal(stp_scene_add_points(&e->env, scene, &points, &object), STP_OK);
    assert_int_equal(stp_scene_prepare(&e->env, scene, NULL), STP_OK);
    free(position);
    free(color);
    return scene;
}

struct stp_camera stage_view(const struct stp_scene *scene, uint32_t width, uint32_t height,
                             double azimuth)
{
    struct stp_camera camera;
    struct stp_frame_params params = { .azimuth = azimuth, .width = width, .height = height };
    assert_int_equal(stp_camera_frame(NULL, scene, &params, &camera), STP_OK);
    return camera;
}

struct stp_plan *stage_plan(struct engine *e, struct stp_context *context, struct stp_scene *scene,
                            const struct stp_camera *camera, const struct stp_render_params *params)
{
    struct stp_plan *plan = NULL;
    if (params->method == STP_METHOD_DEFERRED)
        assert_int_equal(stp_scene_group(&e->env, scene, NULL), STP_OK);
    if (stp_plan_create(&e->env, scene, camera, params, stp_context_limits(context), &plan))
        fail_msg("no plan: %s", e->last);
    return plan;
}

struct stp_resident *stage_resident(struct engine *e, struct stp_context *context,
                                    const struct stp_scene *scene, const struct stp_plan *plan,
                                    const struct stp_resident_params *params)
{
    struct stp_resident *resident = NULL;
    if (stp_resident_create(&e->env, context, scene, plan, params, &resident))
        fail_msg("no resident: %s", e->last);
    VkCommandBuffer commands = engine_begin(e, 0);
    assert_int_equal(stp_resident_record_upload(&e->env, resident, commands, e->family), STP_OK);
    engine_submit(e, 0);
    engine_finish(e);
    stp_resident_release_staging(resident);
    return resident;
}

struct stp_frame *stage_frame(struct engine *e, struct stp_context *context,
                              const struct stp_plan *plan,
                              const struct stp_host_frame_params *params)
{
    struct stp_frame *frame = NULL;
    if (stp_frame_create(&e->env, context, plan, params, &frame))
        fail_msg("no frame: %s", e->last);
    return frame;
}

struct stp_image *stage_offline(struct engine *e, const struct stp_scene *scene,
                                const struct stp_camera *camera,
                                const struct stp_render_params *params)
{
    struct stp_context *own = NULL;
    struct stp_plan *plan = NULL;
    struct stp_image *image = NULL;
    assert_int_equal(stp_context_create(&e->env, &(struct stp_context_params){ 0 }, &own), STP_OK);
    assert_int_equal(
        stp_plan_create(&e->env, scene, camera, params, stp_context_limits(own), &plan), STP_OK);
    assert_int_equal(stp_render(&e->env, own, scene, plan, 0, &image, NULL), STP_OK);
    stp_plan_destroy(&plan);
    stp_context_destroy(&own);
    return image;
}

const float *stage_plane(const struct stp_image *image, const char *name)
{
    struct stp_channel *channel = stp_image_find(image, name);
    assert_non_null(channel);
    return channel->data.f;
}

void stage_same(const struct stp_image *image, const float *texels, const char *what)
{
    static const char *const names[] = { "R", "G", "B", "A" };
    for (int k = 0; k < 4; k++) {
        const float *expected = stage_plane(image, names[k]);
        for (size_t i = 0; i < (size_t)image->width * image->height; i++)
            if (memcmp(&texels[4 * i + (size_t)k], &expected[i], 4) != 0)
                fail_msg("%s: %s of pixel %zu is %g, offline %g", what, names[k], i,
                         (double)texels[4 * i + (size_t)k], (double)expected[i]);
    }
}

void stage_open(struct stage *s, VkFormat color, VkFormat depth, const char *masked)
{
    engine_open(&s->engine, masked);
    s->context = engine_context(&s->engine);
    s->scene = stage_ball(&s->engine, 900, true, 1, 1);
    s->camera = stage_view(s->scene, WIDTH, HEIGHT, 0.4);
    engine_image_open(&s->engine, color, WIDTH, HEIGHT, &s->color);
    engine_image_open(&s->engine, depth, WIDTH, HEIGHT, &s->depth);
}

void stage_close(struct stage *s)
{
    engine_image_close(&s->engine, &s->color);
    engine_image_close(&s->engine, &s->depth);
    stp_scene_destroy(&s->scene);
    stp_context_destroy(&s->context);
    engine_close(&s->engine);
}

struct stp_targets stage_targets(const struct stage *s)
{
    return (struct stp_targets){ .color = engine_target(&s->color),
                                 .depth = engine_target(&s->depth),
                                 .width = s->color.width,
                                 .height = s->color.height,
                                 .depth_near = 0.1,
                                 .depth_far = INFINITY };
}

void stage_clear(VkCommandBuffer commands, struct stage *s, const float *color, float depth)
{
    VkClearValue value = { 0 };
    if (color)
        memcpy(value.color.float32, color, sizeof value.color.float32);
    engine_clear(commands, &s->color, &value);
    value.depthStencil = (VkClearDepthStencilValue){ depth, 0 };
    engine_clear(commands, &s->depth, &value);
}
