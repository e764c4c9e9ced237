/* What a host's frame does not draw is refused, by resident and frame alike, in one line that names
 * it; nothing is made, and the next frame is. */
#include "stage.h"

#include <stipple/volume.h>

static const struct stp_host_frame_params formats = { .color_format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                      .depth_format = VK_FORMAT_D32_SFLOAT };

static void one_line(const struct engine *e, unsigned before, const char *words)
{
    if (e->lines != before + 1 || !strstr(e->last, words))
        fail_msg("%u lines, the last \"%s\"; one with \"%s\" is wanted", e->lines - before, e->last,
                 words);
}

static void expect_refused(struct stage *s, const struct stp_scene *scene,
                           const struct stp_plan *plan, const char *words)
{
    struct engine *e = &s->engine;
    const struct stp_resident_params none = { 0 };
    struct stp_resident *resident = NULL;
    struct stp_frame *frame = NULL;
    VkMemoryRequirements needs = { .size = 77 };
    unsigned lines = e->lines;
    assert_int_equal(stp_resident_create(&e->env, s->context, scene, plan, &none, &resident),
                     STP_ERROR_ARGUMENT);
    one_line(e, lines, words);
    assert_int_equal(stp_frame_create(&e->env, s->context, plan, &formats, &frame),
                     STP_ERROR_ARGUMENT);
    one_line(e, lines + 1, words);
    assert_int_equal(stp_frame_scratch(&e->env, s->context, plan, &formats, &needs),
                     STP_ERROR_ARGUMENT);
    one_line(e, lines + 2, words);
    assert_null(resident);
    assert_null(frame);
    assert_int_equal(needs.size, 77);
}

/* The plan can be made, for pictures of our own. */
static void refuse(struct stage *s, struct stp_scene *scene, const struct stp_render_params *params,
                   const char *words)
{
    struct stp_camera camera = stage_view(scene, WIDTH, HEIGHT, 0.3);
    struct stp_plan *plan = stage_plan(&s->engine, s->context, scene, &camera, params);
    expect_refused(s, scene, plan, words);
    stp_plan_destroy(&plan);
}

static void test_methods(void **state)
{
    struct stage s;
    stage_open(&s, formats.color_format, formats.depth_format, NULL);
    refuse(&s, s.scene, &(struct stp_render_params){ .method = STP_METHOD_PYRAMID },
           "method pyramid is not drawn into a host's frame; use");
    refuse(&s, s.scene, &(struct stp_render_params){ .method = STP_METHOD_REFERENCE },
           "method reference draws on no device");
    stage_close(&s);
}

static void test_transparencies(void **state)
{
    static const struct {
        enum stp_transparency transparency;
        const char *words;
    } ways[] = { { STP_TRANSPARENCY_FAST,
                   "transparency fast is not drawn into a host's frame; use exact" },
                 { STP_TRANSPARENCY_NEAREST,
                   "transparency nearest is not drawn into a host's frame; use exact" },
                 { STP_TRANSPARENCY_PEEL,
                   "transparency peel is not drawn into a host's frame; use exact" } };
    struct stage s;
    stage_open(&s, formats.color_format, formats.depth_format, NULL);
    struct stp_scene *faded = stage_ball(&s.engine, 300, true, 1, 0.5f);
    assert_int_equal(stp_scene_cover(&s.engine.env, faded, NULL), STP_OK);
    for (unsigned i = 0; i < sizeof ways / sizeof *ways; i++)
        refuse(&s, faded, &(struct stp_render_params){ .transparency = ways[i].transparency },
               ways[i].words);
    stp_scene_destroy(&faded);
    stage_close(&s);
}

static void test_volumes(void **state)
{
    float value[4 * 4 * 4];
    for (unsigned i = 0; i < 64; i++)
        value[i] = (float)i;
    const struct stp_volume volume = { { 4, 4, 4 }, { 0.2, 0.2, 0.2 }, { 0 }, value };
    const struct stp_volume_params shown = { .transfer_function = "grey" };
    struct stp_scene *scene = NULL;
    struct stage s;
    stage_open(&s, formats.color_format, formats.depth_format, NULL);
    const struct stp_env *env = &s.engine.env;
    assert_int_equal(stp_scene_create(env, &scene), STP_OK);
    assert_int_equal(stp_scene_set_volume(env, scene, &volume, &shown), STP_OK);
    assert_int_equal(stp_scene_prepare(env, scene, NULL), STP_OK);
    refuse(&s, scene, &(struct stp_render_params){ .method = STP_METHOD_AXIS },
           "method axis is not drawn into a host's frame");
    stp_scene_destroy(&scene);
    stage_close(&s);
}

static struct stp_scene *ball_of(struct engine *e, const struct stp_material *material,
                                 const struct stp_optics *optics)
{
    static const double position[4][3] = {
        { 1, 1, 1 }, { 1, -1, -1 }, { -1, 1, -1 }, { -1, -1, 1 }
    };
    const struct stp_points points = { .count = 4, .position = position };
    const struct stp_object_params object = { .material = material, .optics = optics };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(&e->env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(&e->env, scene, &points, &object), STP_OK);
    assert_int_equal(stp_scene_prepare(&e->env, scene, NULL), STP_OK);
    return scene;
}

static enum stp_result record_with(struct stage *s, struct stp_scene *scene,
                                   const struct stp_resident *resident,
                                   const struct stp_render_params *params)
{
    struct stp_plan *plan = stage_plan(&s->engine, s->context, scene, &s->camera, params);
    struct stp_frame *frame = stage_frame(&s->engine, s->context, plan, &formats);
    struct stp_targets targets = stage_targets(s);
    VkCommandBuffer commands = engine_begin(&s->engine, 0);
    stage_clear(commands, s, NULL, 0);
    enum stp_result result =
        stp_frame_record(&s->engine.env, frame, resident, &s->camera, &targets, commands);
    engine_submit(&s->engine, 0);
    engine_finish(&s->engine);
    stp_frame_destroy(&frame);
    stp_plan_destroy(&plan);
    return result;
}

/* Every field of another scene's material, and another epsilon; the resident's own is drawn. */
static void test_materials(void **state)
{
    const struct stp_material own = { 0.1f, 0.7f, 0.2f, 32, { 0.8f, 0.8f, 0.8f }, 1 };
    struct stp_render_params params = { .method = STP_METHOD_EXACT };
    struct stage s;
    stage_open(&s, formats.color_format, formats.depth_format, NULL);
    struct stp_scene *scene = ball_of(&s.engine, &own, NULL);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, scene, &s.camera, &params);
    struct stp_resident *resident =
        stage_resident(&s.engine, s.context, scene, plan, &(struct stp_resident_params){ 0 });
    assert_int_equal(record_with(&s, scene, resident, &params), STP_OK);
    for (unsigned i = 0; i < 7; i++) {
        struct stp_material other = own;
        float *field[] = { &other.ambient,   &other.diffuse,   &other.specular, &other.shininess,
                           &other.albedo[0], &other.albedo[1], &other.albedo[2] };
        *field[i] *= 2;
        struct stp_scene *changed = ball_of(&s.engine, &other, NULL);
        assert_int_equal(record_with(&s, changed, resident, &params), STP_ERROR_ARGUMENT);
        assert_non_null(strstr(s.engine.last, "another material or epsilon"));
        stp_scene_destroy(&changed);
    }
    params.epsilon = 0.5;
    assert_int_equal(record_with(&s, scene, resident, &params), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(s.engine.last, "another material or epsilon"));
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    stage_close(&s);
}

static void expect_not_recorded(struct stage *s, struct stp_scene *scene,
                                const struct stp_resident *resident,
                                const struct stp_render_params *params, const char *words)
{
    assert_int_equal(record_with(s, scene, resident, params), STP_ERROR_ARGUMENT);
    if (!strstr(s->engine.last, words))
        fail_msg("\"%s\" is wanted: %s", words, s->engine.last);
}

/* A frame that reads a buffer of the scene that the resident has not would read address 0. */
static void test_missing_buffers(void **state)
{
    const struct stp_render_params exact = { .method = STP_METHOD_EXACT };
    const struct stp_render_params raster = { .method = STP_METHOD_DEFERRED,
                                              .path = STP_PATH_RASTER };
    const struct stp_render_params sky = { .method = STP_METHOD_EXACT, .environment_behind = true };
    const struct stp_optics dull = { .ior = { 1, 1, 1 } }; /* it mirrors no environment */
    const float texel[2][3] = { { 1, 2, 3 }, { 2, 1, 0 } };
    struct stage s;
    stage_open(&s, formats.color_format, formats.depth_format, NULL);
    const struct stp_env *env = &s.engine.env;
    struct stp_scene *scene = ball_of(&s.engine, NULL, &dull);
    assert_int_equal(stp_scene_set_environment(env, scene, 2, 1, texel, NULL), STP_OK);
    assert_int_equal(stp_scene_group(env, scene, NULL), STP_OK);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, scene, &s.camera, &exact);
    struct stp_resident *resident = stage_resident(&s.engine, s.context, scene, plan, NULL);
    assert_int_equal(record_with(&s, scene, resident, &exact), STP_OK);
    expect_not_recorded(&s, scene, resident, &raster, "the frame reads the buffer \"");
    expect_not_recorded(&s, scene, resident, &sky, "the frame reads the buffer \"");
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    plan = stage_plan(&s.engine, s.context, scene, &s.camera, &raster);
    resident = stage_resident(&s.engine, s.context, scene, plan, NULL);
    assert_int_equal(record_with(&s, scene, resident, &raster), STP_OK);
    assert_int_equal(record_with(&s, scene, resident, &exact), STP_OK); /* it has all of these */
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    stage_close(&s);
}

/* The scene may go on while a resident stays as it was: what then does not fit is refused. */
static void test_other_states(void **state)
{
    const struct stp_render_params exact = { .method = STP_METHOD_EXACT };
    const struct stp_render_params deferred = { .method = STP_METHOD_DEFERRED };
    struct stage s;
    stage_open(&s, formats.color_format, formats.depth_format, NULL);
    const struct stp_env *env = &s.engine.env;
    const struct stp_group_params few = { .overlap = 0.1 };
    assert_int_equal(stp_scene_group(env, s.scene, &few), STP_OK);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &exact);
    struct stp_resident *resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
    /* record_with groups it by other params */
    expect_not_recorded(&s, s.scene, resident, &deferred, "another grouping than the resident");
    assert_int_equal(record_with(&s, s.scene, resident, &exact), STP_OK);
    stp_resident_destroy(&resident);
    resident = stage_resident(&s.engine, s.context, s.scene, plan, NULL);
    assert_int_equal(record_with(&s, s.scene, resident, &deferred), STP_OK);
    struct stp_scene *other = stage_ball(&s.engine, 900, true, 1, 1);
    expect_not_recorded(&s, other, resident, &exact, "another scene than the resident");
    struct stp_resident *none = NULL;
    assert_int_equal(stp_resident_create(env, s.context, other, plan, NULL, &none),
                     STP_ERROR_ARGUMENT);
    assert_null(none);
    assert_non_null(strstr(s.engine.last, "another scene"));
    stp_scene_destroy(&other);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

/* None of it is left behind: a frame that is drawn can be made after. */
static void test_next_is_drawn(void **state)
{
    struct stage s;
    stage_open(&s, formats.color_format, formats.depth_format, NULL);
    const struct stp_render_params exact = { .method = STP_METHOD_EXACT };
    refuse(&s, s.scene, &(struct stp_render_params){ .method = STP_METHOD_PYRAMID }, "pyramid");
    struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &exact);
    struct stp_resident *resident =
        stage_resident(&s.engine, s.context, s.scene, plan, &(struct stp_resident_params){ 0 });
    struct stp_frame *frame = stage_frame(&s.engine, s.context, plan, &formats);
    stp_frame_destroy(&frame);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods),         cmocka_unit_test(test_transparencies),
        cmocka_unit_test(test_volumes),         cmocka_unit_test(test_materials),
        cmocka_unit_test(test_missing_buffers), cmocka_unit_test(test_other_states),
        cmocka_unit_test(test_next_is_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
