/* What cannot be planned: the right result, one line that says why, and no plan. */
#include "plans.h"

#include "base/memory.h"

static void exact_raster(struct inputs *in)
{
    in->params.method = STP_METHOD_EXACT;
    in->params.path = STP_PATH_RASTER;
}
static void pyramid_raster(struct inputs *in)
{
    in->params.method = STP_METHOD_PYRAMID;
    in->params.path = STP_PATH_RASTER;
}
static void auto_raster(struct inputs *in)
{
    in->params.path = STP_PATH_RASTER;
}
static void deferred_without_atomics(struct inputs *in)
{
    in->params.method = STP_METHOD_DEFERRED;
    in->params.path = STP_PATH_COMPUTE;
    in->params.mask_features = STP_FEATURE_INT64_ATOMICS;
}
static void raster_without_blend(struct inputs *in)
{
    in->params.method = STP_METHOD_TWO_PASS;
    in->params.path = STP_PATH_RASTER;
    in->limits.features &= ~(unsigned)STP_FEATURE_FLOAT32_BLEND;
}
static void raster_without_formats(struct inputs *in)
{
    in->params.method = STP_METHOD_TWO_PASS;
    in->params.path = STP_PATH_RASTER;
    in->params.mask_features = STP_FEATURE_STORAGE_FORMATS;
}
static void deferred_without_any(struct inputs *in)
{
    in->params.method = STP_METHOD_DEFERRED;
    in->params.mask_features = STP_FEATURE_INT64_ATOMICS | STP_FEATURE_STORAGE_FORMATS;
}
static void no_groups(struct inputs *in)
{
    in->params.method = STP_METHOD_DEFERRED;
    in->scene->facts.grouping.groups = 0;
}
static void voronoi_exact_raster(struct inputs *in)
{
    in->params.method = STP_METHOD_DEFERRED;
    in->params.path = STP_PATH_RASTER;
    in->params.voronoi = STP_VORONOI_EXACT;
}
static void pyramid_of_ellipses(struct inputs *in)
{
    in->params.method = STP_METHOD_PYRAMID;
    in->scene->facts.phong = 1;
}
static void peel_of_ellipses(struct inputs *in)
{
    in->params.method = STP_METHOD_TWO_PASS;
    in->scene->facts.phong = 1;
    fade_inputs(in, false);
}
static void shared_ellipses(struct inputs *in)
{
    in->scene->facts.phong = 1;
    in->scene->share.count = 2;
}
static void exact_shades_splats(struct inputs *in)
{
    in->params.method = STP_METHOD_EXACT;
    in->params.shade = STP_SHADE_SPLAT;
}
static void flat_by_raster(struct inputs *in)
{
    in->params.path = STP_PATH_RASTER;
    in->params.shade = STP_SHADE_FLAT;
}
static void shaded_albedo(struct inputs *in)
{
    in->params.aovs = STP_AOV_ALBEDO;
    in->params.shade = STP_SHADE_SPLAT;
}
static void cube_of_near_lights(struct inputs *in)
{
    in->params.light_cube = STP_ON;
    in->scene->facts.positional_lights = true;
}
static void cube_of_local_viewer(struct inputs *in)
{
    in->params.light_cube = STP_ON;
    in->params.local_viewer = true;
}
static void no_width(struct inputs *in)
{
    in->camera.width = 0;
}
static void no_height(struct inputs *in)
{
    in->camera.height = 0;
}
static void too_wide(struct inputs *in)
{
    in->camera.width = 65537;
}
static void matrix_not_finite(struct inputs *in)
{
    in->camera.world_to_camera[6] = NAN;
}
static void place_not_finite(struct inputs *in)
{
    in->camera.world_to_camera[11] = INFINITY;
}
static void centre_not_finite(struct inputs *in)
{
    in->camera.cy = NAN;
}
static void focal_not_finite(struct inputs *in)
{
    in->camera.fx = INFINITY;
}
static void near_is_far(struct inputs *in)
{
    in->camera.far_depth = in->camera.near_depth;
}
static void near_beyond_far(struct inputs *in)
{
    in->camera.near_depth = INFINITY;
}
static void near_is_zero(struct inputs *in)
{
    in->camera.near_depth = 0;
}
static void near_is_nan(struct inputs *in)
{
    in->camera.near_depth = NAN;
}
static void no_focal_length(struct inputs *in)
{
    in->camera.fx = 0;
}
static void focal_length_nan(struct inputs *in)
{
    in->camera.fy = NAN;
}
static void samples_by_raster(struct inputs *in)
{
    in->params.method = STP_METHOD_TWO_PASS;
    in->params.path = STP_PATH_RASTER;
    in->params.samples = 4;
}
static void too_many_samples(struct inputs *in)
{
    in->params.samples = 65537;
}
static void transparent(struct inputs *in)
{
    in->scene->facts.transparent = true;
}
static void exact_for_peel(struct inputs *in)
{
    transparent(in);
    in->params.method = STP_METHOD_EXACT;
    in->params.transparency = STP_TRANSPARENCY_PEEL;
}
static void fast_without_cover(struct inputs *in)
{
    transparent(in);
    in->params.transparency = STP_TRANSPARENCY_FAST;
}
static void fast_by_compute(struct inputs *in)
{
    fast_without_cover(in);
    in->params.path = STP_PATH_COMPUTE;
}
static void nearest_with_samples(struct inputs *in)
{
    transparent(in);
    in->params.transparency = STP_TRANSPARENCY_NEAREST;
    in->params.samples = 4;
}
static void fast_counts_layers(struct inputs *in)
{
    fast_without_cover(in);
    in->params.aovs = STP_AOV_LAYERS;
}
static void fast_without_blends(struct inputs *in)
{
    fast_without_cover(in);
    in->params.mask_features = STP_FEATURE_INDEPENDENT_BLEND;
}
static void peel_with_glass(struct inputs *in)
{
    transparent(in);
    in->params.transparency = STP_TRANSPARENCY_PEEL;
    in->scene->facts.environment_levels = 1;
    in->scene->facts.environment_texels = 1000;
    in->scene->facts.reflects = true;
}
static void peel_without_atomics(struct inputs *in)
{
    transparent(in);
    in->params.transparency = STP_TRANSPARENCY_PEEL;
    in->params.path = STP_PATH_COMPUTE;
    in->params.mask_features = STP_FEATURE_INT64_ATOMICS;
}
static void peel_with_samples(struct inputs *in)
{
    transparent(in);
    in->params.transparency = STP_TRANSPARENCY_PEEL;
    in->params.samples = 4;
}
static void two_pass_for_fast(struct inputs *in)
{
    transparent(in);
    in->params.method = STP_METHOD_TWO_PASS;
    in->params.transparency = STP_TRANSPARENCY_FAST;
}
static void deep_by_peeling(struct inputs *in)
{
    transparent(in);
    in->params.transparency = STP_TRANSPARENCY_PEEL;
    in->params.deep = true;
}
static void deep_samples(struct inputs *in)
{
    in->params.deep = true;
    in->params.samples = 4;
}
static void deep_eye_dome(struct inputs *in)
{
    transparent(in);
    in->scene->facts.eye_dome = true;
    in->params.deep = true;
}
static void deep_volume(struct inputs *in)
{
    in->scene->facts.volume.dims[0] = 3;
    in->params.method = STP_METHOD_REFERENCE;
    in->params.deep = true;
}
static void little_memory(struct inputs *in)
{
    in->params.memory_limit = 1000;
}
static void little_heap(struct inputs *in)
{
    in->limits.heap_bytes = 3000; /* less than the scene */
    in->params.method = STP_METHOD_EXACT;
}
static void not_prepared(struct inputs *in)
{
    in->scene->prepared = false;
}
static void no_splats(struct inputs *in)
{
    in->scene->splats.count = 0;
}
static void too_many_splats(struct inputs *in)
{
    in->scene->splats.count = INT32_MAX / 3 + 1; /* gl_VertexIndex would be negative */
}

static const struct {
    void (*set)(struct inputs *in);
    enum stp_result result;
    const char *word;
} cases[] = {
    { exact_raster, STP_ERROR_ARGUMENT, "raster" },
    { pyramid_raster, STP_ERROR_ARGUMENT, "raster" },
    { auto_raster, STP_ERROR_ARGUMENT, "raster" },
    { deferred_without_atomics, STP_ERROR_FEATURE, "shaderBufferInt64Atomics" },
    { raster_without_blend, STP_ERROR_FEATURE, "blending" },
    { raster_without_formats, STP_ERROR_FEATURE, "shaderStorageImageExtendedFormats" },
    { deferred_without_any, STP_ERROR_FEATURE, "shaderBufferInt64Atomics" },
    { no_groups, STP_ERROR_ARGUMENT, "stp_scene_group" },
    { voronoi_exact_raster, STP_ERROR_ARGUMENT, "slab" },
    { pyramid_of_ellipses, STP_ERROR_ARGUMENT, "draws discs" },
    { peel_of_ellipses, STP_ERROR_ARGUMENT, "peel draws discs" },
    { shared_ellipses, STP_ERROR_ARGUMENT, "several processes" },
    { exact_shades_splats, STP_ERROR_ARGUMENT, "two-pass or reference" },
    { flat_by_raster, STP_ERROR_ARGUMENT, "no raster path" },
    { shaded_albedo, STP_ERROR_ARGUMENT, "albedo" },
    { cube_of_near_lights, STP_ERROR_ARGUMENT, "lights that have a place" },
    { cube_of_local_viewer, STP_ERROR_ARGUMENT, "local viewer" },
    { no_width, STP_ERROR_ARGUMENT, "0 x 48" },
    { no_height, STP_ERROR_ARGUMENT, "64 x 0" },
    { too_wide, STP_ERROR_ARGUMENT, "65537 x 48" },
    { matrix_not_finite, STP_ERROR_ARGUMENT, "matrix element or the centre is not finite" },
    { place_not_finite, STP_ERROR_ARGUMENT, "matrix element or the centre is not finite" },
    { centre_not_finite, STP_ERROR_ARGUMENT, "matrix element or the centre is not finite" },
    { focal_not_finite, STP_ERROR_ARGUMENT, "focal" },
    { near_is_far, STP_ERROR_ARGUMENT, "near < far" },
    { near_beyond_far, STP_ERROR_ARGUMENT, "near < far" },
    { near_is_zero, STP_ERROR_ARGUMENT, "near < far" },
    { near_is_nan, STP_ERROR_ARGUMENT, "near < far" },
    { no_focal_length, STP_ERROR_ARGUMENT, "focal" },
    { focal_length_nan, STP_ERROR_ARGUMENT, "focal" },
    { samples_by_raster, STP_ERROR_ARGUMENT, "one sample" },
    { too_many_samples, STP_ERROR_ARGUMENT, "65537" },
    { exact_for_peel, STP_ERROR_ARGUMENT, "method two-pass does" },
    { two_pass_for_fast, STP_ERROR_ARGUMENT, "method deferred does" },
    { deep_by_peeling, STP_ERROR_ARGUMENT, "exact and reference" },
    { deep_samples, STP_ERROR_ARGUMENT, "samples" },
    { deep_eye_dome, STP_ERROR_ARGUMENT, "normals" },
    { deep_volume, STP_ERROR_ARGUMENT, "volume" },
    { fast_without_cover, STP_ERROR_ARGUMENT, "stp_scene_cover" },
    { fast_by_compute, STP_ERROR_ARGUMENT, "rasteriser" },
    { nearest_with_samples, STP_ERROR_ARGUMENT, "one sample" },
    { fast_counts_layers, STP_ERROR_ARGUMENT, "layers" },
    { fast_without_blends, STP_ERROR_FEATURE, "independentBlend" },
    { peel_with_glass, STP_ERROR_ARGUMENT, "glass" },
    { peel_without_atomics, STP_ERROR_FEATURE, "shaderBufferInt64Atomics" },
    { peel_with_samples, STP_ERROR_ARGUMENT, "one sample" },
    { little_memory, STP_ERROR_DEVICE_MEMORY, "tile" },
    { little_heap, STP_ERROR_DEVICE_MEMORY, "3000 bytes" },
    { not_prepared, STP_ERROR_ARGUMENT, "prepared" },
    { no_splats, STP_ERROR_ARGUMENT, "splats" },
    { too_many_splats, STP_ERROR_ARGUMENT, "715827883 splats: at most 715827882" },
};

static void test_refused(void **state)
{
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct plan_log log = { 0 };
        struct stp_env env = { .log = plan_keep_line, .user = &log };
        struct inputs in = plain_inputs();
        struct stp_plan *plan = NULL;
        cases[i].set(&in);
        enum stp_result result =
            stp_plan_create(&env, in.scene, &in.camera, &in.params, &in.limits, &plan);
        if (result != cases[i].result || log.lines != 1 || !strstr(log.last, cases[i].word))
            fail_msg("%s: result %d, %u lines: %s", cases[i].word, result, log.lines, log.last);
        assert_null(plan);
        release_inputs(&in);
    }
}

/* An orthographic view may begin behind the eye. */
static void test_orthographic_near(void **state)
{
    struct inputs in = plain_inputs();
    in.camera = flat_camera(64, 48, 20);
    in.camera.near_depth = -5;
    struct stp_plan *plan = plan_of(&in);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static void test_out_of_memory(void **state)
{
    for (unsigned long n = 1;; n++) {
        struct plan_log log = { 0 };
        struct stp_env env = { .log = plan_keep_line, .user = &log };
        struct inputs in = plain_inputs();
        struct stp_plan *plan = NULL;
        mem_fail_at(n);
        enum stp_result result =
            stp_plan_create(&env, in.scene, &in.camera, &in.params, &in.limits, &plan);
        mem_fail_at(0);
        assert_true((result == STP_OK) == (plan != NULL));
        stp_plan_destroy(&plan);
        release_inputs(&in);
        if (result == STP_OK) {
            assert_true(n > 2); /* the plan and its tiles */
            break;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_int_equal(log.lines, 1);
    }
}

/* Numbers that no enum has, in each field of the params that is one. */
static void test_unknown_choices(void **state)
{
    const size_t field[] = {
        offsetof(struct stp_render_params, method),
        offsetof(struct stp_render_params, transparency),
        offsetof(struct stp_render_params, layers),
        offsetof(struct stp_render_params, path),
        offsetof(struct stp_render_params, payload),
        offsetof(struct stp_render_params, voronoi),
        offsetof(struct stp_render_params, kernel),
        offsetof(struct stp_render_params, shade),
        offsetof(struct stp_render_params, cull),
        offsetof(struct stp_render_params, light_cube),
        offsetof(struct stp_render_params, axis_merge),
    };
    const unsigned value[] = { 7, 99, UINT32_MAX };
    for (size_t i = 0; i < 3 * sizeof field / sizeof *field; i++) {
        struct inputs in = plain_inputs();
        struct plan_log log = { 0 };
        struct stp_env env = { .log = plan_keep_line, .user = &log };
        struct stp_plan *plan = NULL;
        struct stp_choice choice;
        memcpy((char *)&in.params + field[i / 3], &value[i % 3], sizeof *value);
        assert_int_equal(stp_plan_create(&env, in.scene, &in.camera, &in.params, &in.limits, &plan),
                         STP_ERROR_ARGUMENT);
        assert_null(plan);
        assert_int_equal(log.lines, 1);
        assert_int_equal(
            stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice),
            STP_ERROR_ARGUMENT);
        assert_int_equal(log.lines, 2);
        release_inputs(&in);
    }
}

static void test_names(void **state)
{
    assert_string_equal(stp_method_name(STP_METHOD_AXIS), "axis");
    assert_string_equal(stp_transparency_name(STP_TRANSPARENCY_REFERENCE), "reference");
    assert_string_equal(stp_path_name(STP_PATH_COMPUTE), "compute");
    assert_null(stp_method_name(STP_METHOD_AXIS + 1));
    assert_null(stp_transparency_name(STP_TRANSPARENCY_REFERENCE + 1));
    assert_null(stp_path_name(STP_PATH_COMPUTE + 1));
    assert_null(stp_method_name((enum stp_method) - 1));
}

/* NULL params are zeroed params. */
static void test_defaults(void **state)
{
    struct inputs in = plain_inputs();
    const struct stp_render_params zeroed = { 0 };
    struct stp_plan *plan[2] = { NULL };
    for (int i = 0; i < 2; i++)
        assert_int_equal(
            stp_plan_create(NULL, in.scene, &in.camera, i ? NULL : &zeroed, &in.limits, &plan[i]),
            STP_OK);
    char *text[2] = { stp_plan_print(plan[0]), stp_plan_print(plan[1]) };
    assert_string_equal(text[0], text[1]);
    for (int i = 0; i < 2; i++) {
        free(text[i]);
        stp_plan_destroy(&plan[i]);
    }
    const struct stp_facts *facts = stp_scene_facts(in.scene);
    assert_int_equal(stp_choose_estimates(facts, NULL), stp_choose_estimates(facts, &zeroed));
    assert_int_equal(stp_plan_needs_groups(facts, NULL, &in.limits),
                     stp_plan_needs_groups(facts, &zeroed, &in.limits));
    assert_int_equal(stp_plan_needs_cover(facts, NULL, &in.limits),
                     stp_plan_needs_cover(facts, &zeroed, &in.limits));
    release_inputs(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refused),       cmocka_unit_test(test_orthographic_near),
        cmocka_unit_test(test_out_of_memory), cmocka_unit_test(test_unknown_choices),
        cmocka_unit_test(test_names),         cmocka_unit_test(test_defaults),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
