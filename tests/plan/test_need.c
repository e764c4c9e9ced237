/* Only what a scene needs: without a feature a plan has no resource, pass or constant of it, and
 * with it exactly those. */
#include "plans.h"

enum { EXACT = 1, TWO_PASS = 2, TWO_PASS_RASTER = 4, KEYS = 8, LAYERS = 16, ALL = 31 };
#define WAYS 5

static void choose_way(struct inputs *in, int way)
{
    static const enum stp_method methods[WAYS] = { STP_METHOD_EXACT, STP_METHOD_TWO_PASS,
                                                   STP_METHOD_TWO_PASS, STP_METHOD_DEFERRED,
                                                   STP_METHOD_DEFERRED };
    static const enum stp_path paths[WAYS] = { STP_PATH_COMPUTE, STP_PATH_COMPUTE, STP_PATH_RASTER,
                                               STP_PATH_COMPUTE, STP_PATH_RASTER };
    in->params.method = methods[way];
    in->params.path = paths[way];
}

static void no_atomics(struct inputs *in)
{
    in->params.mask_features |= STP_FEATURE_INT64_ATOMICS;
}
static void two_objects(struct inputs *in)
{
    in->scene->facts.objects = 2;
}
static void unknown_normals(struct inputs *in)
{
    in->scene->facts.no_normal = 3;
}
static void floor_off(struct inputs *in)
{
    in->params.min_splat = -1;
}
static void background(struct inputs *in)
{
    static const float color[] = { 0, 0, 0, 0 };
    in->params.background = color;
}
static void albedo(struct inputs *in)
{
    in->params.aovs = STP_AOV_ALBEDO;
}
static void weight(struct inputs *in)
{
    in->params.aovs = STP_AOV_WEIGHT;
}
static void fragments(struct inputs *in)
{
    in->params.aovs = STP_AOV_FRAGMENTS;
}
static void position(struct inputs *in)
{
    in->params.aovs = STP_AOV_POSITION | STP_AOV_COVERAGE | STP_AOV_LAYERS;
}
static void two_lights(struct inputs *in)
{
    const struct stp_light lights[] = { { .at_eye = true, .color = { 1, 1, 1 } },
                                        { .direction = { 1, 1, 1 }, .color = { 1, 1, 1 } } };
    stp_scene_set_lights(NULL, in->scene, lights, 2);
}
static void dim_light(struct inputs *in)
{
    const struct stp_light light = { .at_eye = true, .color = { 1, 0.5f, 1 } };
    stp_scene_set_lights(NULL, in->scene, &light, 1);
}
static void two_sided(struct inputs *in)
{
    in->scene->facts.two_sided = true;
}
static void cull(struct inputs *in)
{
    in->params.cull = STP_CULL_BACK;
}
static void gauss(struct inputs *in)
{
    in->params.kernel = STP_KERNEL_GAUSS;
}
static void local_viewer(struct inputs *in)
{
    in->params.local_viewer = true;
}
static void flat(struct inputs *in)
{
    in->camera = flat_camera(64, 48, 20);
}
static void eye_dome(struct inputs *in)
{
    in->scene->facts.eye_dome = true;
}
static void voronoi_exact(struct inputs *in)
{
    in->params.voronoi = STP_VORONOI_EXACT;
}
static void samples(struct inputs *in)
{
    in->params.samples = 5;
}
static void around(struct inputs *in)
{
    in->scene->facts.environment_levels = 1;
    in->scene->facts.environment_texels = 1000;
}
static void mirrors(struct inputs *in)
{
    around(in);
    in->scene->facts.reflects = true;
}
static void all_mirrors(struct inputs *in)
{
    mirrors(in);
    in->scene->facts.environment_levels = 3;
    in->scene->facts.mirrors = in->scene->facts.between_levels = in->scene->facts.disperses = true;
}
static void behind(struct inputs *in)
{
    around(in);
    in->params.environment_behind = true;
}
static void faded(struct inputs *in)
{
    fade_inputs(in, false);
}
static void faded_colors(struct inputs *in)
{
    color_inputs(in);
    fade_inputs(in, false);
}
static void bright_colors(struct inputs *in)
{
    faded_colors(in);
    in->scene->facts.color_max = 1.01f;
}
static void dark_colors(struct inputs *in)
{
    faded_colors(in);
    in->scene->facts.color_min = -0.01f;
}
static void mixed(struct inputs *in)
{
    fade_inputs(in, true);
    in->params.aovs = STP_AOV_LAYERS;
}
static void glass(struct inputs *in)
{
    mirrors(in);
    fade_inputs(in, false);
}
static void all_glass(struct inputs *in)
{
    all_mirrors(in);
    fade_inputs(in, false);
    in->scene->facts.absorbs = true;
    in->params.layers = STP_LAYERS_SINGLE;
}
static void ellipses(struct inputs *in)
{
    in->scene->facts.phong = 7;
}
static void colored_ellipses(struct inputs *in)
{
    faded_colors(in);
    in->scene->facts.phong = 7;
}
static void clipped(struct inputs *in)
{
    in->scene->facts.phong = 7;
    in->scene->facts.clip_lines = 3;
}
static void shade_splats(struct inputs *in)
{
    in->params.shade = STP_SHADE_SPLAT;
}
static void shade_flat(struct inputs *in)
{
    in->params.shade = STP_SHADE_FLAT;
}
static void light_cube(struct inputs *in)
{
    in->params.light_cube = STP_ON;
}
static void deep(struct inputs *in)
{
    in->params.deep = true;
}
static void faded_deep(struct inputs *in)
{
    fade_inputs(in, false);
    in->params.deep = true;
}
static void large(struct inputs *in)
{
    in->scene->facts.radius_max = 2;
}
static void gpu(struct inputs *in)
{
    in->limits.processor = STP_PROCESSOR_GPU;
}

/* The discs lie 3 before the eye, 0.1 wide. */
static void near_cuts(struct inputs *in)
{
    in->camera.near_depth = 2.95;
}
static void far_cuts(struct inputs *in)
{
    in->camera.far_depth = 3.05;
}
static void planes_beside(struct inputs *in)
{
    in->camera.near_depth = 2.6;
    in->camera.far_depth = 3.4;
}

/* What appears ("+name") or goes ("-name"); NULL: nothing. constant -1: none changes. */
static const struct feature {
    const char *name;
    void (*set)(struct inputs *in);
    unsigned ways;
    const char *resource, *pass;
    int constant;
    uint32_t value;
} features[] = {
    { "colours", color_inputs, EXACT, "+traits", NULL, PLAN_KEY_IDS, 1 },
    { "colours", color_inputs, EXACT, NULL, NULL, PLAN_COLOR_CODES, 0 },
    { "colours, transparent", faded_colors, EXACT, "+traits", NULL, PLAN_COLOR_CODES, 1 },
    { "colours above 1", bright_colors, EXACT, "+traits", NULL, PLAN_COLOR_CODES, 0 },
    { "colours below 0", dark_colors, EXACT, "+traits", NULL, PLAN_COLOR_CODES, 0 },
    { "ellipses with colours", colored_ellipses, EXACT, "+slot ids", NULL, PLAN_COLOR_CODES, 0 },
    { "colours", color_inputs, ALL, "+colors", NULL, PLAN_HAS_COLOR, 1 },
    { "colours", color_inputs, TWO_PASS_RASTER, "+color sum", NULL, -1, 0 },
    { "colours", color_inputs, KEYS, NULL, NULL, PLAN_PACKED, 0 },
    { "objects", two_objects, ALL, "+materials", NULL, PLAN_HAS_OBJECTS, 1 },
    { "objects", two_objects, EXACT, "+traits", NULL, PLAN_KEY_IDS, 1 },
    { "unknown normals", unknown_normals, ALL, NULL, NULL, PLAN_HAS_UNKNOWN, 1 },
    { "no floor", floor_off, ALL, NULL, NULL, PLAN_FLOOR, 0 },
    { "background", background, ALL, NULL, "+background", PLAN_BACKGROUND, 1 },
    { "albedo", albedo, ALL, "+albedo", NULL, PLAN_AOVS, 1 },
    { "weight", weight, ALL, "+albedo", NULL, PLAN_AOVS, 1 },
    { "fragments", fragments, ALL, "+id", NULL, PLAN_AOVS, 2 },
    { "P, coverage, layers", position, ALL, NULL, NULL, PLAN_AOVS, 0 },
    { "two lights", two_lights, ALL, NULL, NULL, PLAN_HEAD_LIGHT, 0 },
    { "coloured light", dim_light, ALL, NULL, NULL, PLAN_HEAD_LIGHT, 0 },
    { "two-sided", two_sided, ALL, NULL, NULL, PLAN_TWO_SIDED, 1 },
    { "culling", cull, ALL, NULL, NULL, PLAN_CULL_BACK, 1 },
    { "gauss", gauss, ALL, NULL, NULL, PLAN_GAUSS, 1 },
    { "local viewer", local_viewer, ALL, NULL, NULL, PLAN_LOCAL_VIEWER, 1 },
    { "orthographic", flat, ALL, NULL, NULL, PLAN_ORTHOGRAPHIC, 1 },
    { "near through splats", near_cuts, ALL, NULL, NULL, PLAN_CUTS, 1 },
    { "far through splats", far_cuts, ALL, NULL, NULL, PLAN_CUTS, 1 },
    { "near and far beside them", planes_beside, ALL, NULL, NULL, PLAN_CUTS, 0 },
    { "eye dome", eye_dome, ALL, NULL, "+eye dome", -1, 0 },
    { "exact Voronoi", voronoi_exact, KEYS, "+nearest", "+nearest", PLAN_VORONOI, 2 },
    { "samples", samples, EXACT | TWO_PASS | KEYS, NULL, NULL, PLAN_SAMPLE_GRID, 3 },
    { "an environment that nothing meets", around, ALL, NULL, NULL, PLAN_OPTICS, 0 },
    { "mirrors", mirrors, ALL, "+environment", NULL, PLAN_OPTICS, STP_OPTICS_SURFACE },
    { "mirrors", mirrors, ALL, "+optics", NULL, PLAN_BACKGROUND, 0 },
    { "mirrors, rough", all_mirrors, ALL, "+optics", NULL, PLAN_OPTICS,
      STP_OPTICS_SURFACE | STP_OPTICS_ROUGH | STP_OPTICS_BETWEEN | STP_OPTICS_MIRRORS },
    { "glass", glass, EXACT, "+environment", "+layers", PLAN_OPTICS,
      STP_OPTICS_SURFACE | STP_OPTICS_GLASS | STP_OPTICS_MULTI },
    { "glass, all of it", all_glass, EXACT, "+optics", "+mend layer", PLAN_OPTICS,
      STP_OPTICS_SURFACE | STP_OPTICS_ROUGH | STP_OPTICS_BETWEEN | STP_OPTICS_MIRRORS |
          STP_OPTICS_GLASS | STP_OPTICS_DISPERSE | STP_OPTICS_ABSORBS },
    { "no glass", faded, EXACT, NULL, NULL, PLAN_OPTICS, 0 },
    { "an environment behind", behind, ALL, "+environment", NULL, PLAN_OPTICS, STP_OPTICS_BEHIND },
    { "an environment behind", behind, EXACT | TWO_PASS | KEYS, NULL, "+background",
      PLAN_BACKGROUND, 1 },
    { "one opacity", faded, EXACT, NULL, "+layers", PLAN_OPACITY, 1 },
    { "one opacity", faded, EXACT, NULL, "-resolve", PLAN_MIXED, 0 },
    { "one opacity", faded, TWO_PASS | TWO_PASS_RASTER, "+peeled", "+nothing peeled", PLAN_OPACITY,
      1 },
    { "one opacity", faded, TWO_PASS | TWO_PASS_RASTER, NULL, NULL, PLAN_MIXED, 0 },
    { "opacities", mixed, TWO_PASS | TWO_PASS_RASTER, "+opaque", "+opaque", PLAN_MIXED, 1 },
    { "opacities", mixed, TWO_PASS, NULL, "+opaque large", -1, 0 },
    { "opacities", mixed, TWO_PASS_RASTER, NULL, "+opaque ends", -1, 0 },
    { "opacities", mixed, TWO_PASS_RASTER, "+color sum", NULL, PLAN_MIXED, 1 },
    { "opacities", mixed, TWO_PASS, "+opacities", NULL, PLAN_OPACITY, 2 },
    { "opacities", mixed, EXACT, "+opacities", "+mend layer", PLAN_OPACITY, 2 },
    { "opacities", mixed, EXACT, "+traits", "-repair sum", PLAN_MIXED, 1 },
    { "layers", mixed, EXACT, "+id", NULL, PLAN_AOVS, PLAN_AOVS_ID | PLAN_AOVS_LAYERS },
    { "ellipses", ellipses, ALL, "+ellipses", NULL, PLAN_PHONG, 1 },
    { "clip lines", clipped, ALL, "+ellipses", NULL, PLAN_PHONG, 2 },
    { "clip lines", clipped, ALL, "+clip lines", NULL, -1, 0 },
    { "splats that are shaded", shade_splats, TWO_PASS, NULL, NULL, PLAN_SHADE, 1 },
    { "splats that are shaded", shade_splats, TWO_PASS_RASTER, "+color sum", NULL, PLAN_SHADE, 1 },
    { "flat splats", shade_flat, TWO_PASS, NULL, "-sum", PLAN_SHADE, 2 },
    { "large splats", large, TWO_PASS, "+bins", "+bin", PLAN_BINS, 1 },
    { "large splats", large, TWO_PASS, "+records", "+sum binned", -1, 0 },
    { "large splats", large, ALL & ~TWO_PASS, NULL, NULL, PLAN_BINS, 0 },
    { "ellipses", ellipses, TWO_PASS, NULL, "+resolve vanished", -1, 0 },
    { "light cube", light_cube, ALL, "+light cube", "+light cube", PLAN_LIGHT_CUBE, 1 },

    { "deep, opaque", deep, ALL, NULL, NULL, PLAN_DEEP, 0 },
    { "deep", faded_deep, EXACT, "+deep layers", "+clear deep counts", PLAN_DEEP, 1 },
    { "deep", faded_deep, EXACT, "+deep counts", NULL, PLAN_DEEP, 1 },
    { "a GPU", gpu, LAYERS, "-order", "-layer 3", PLAN_LAYERED, 1 },
    { "a GPU", gpu, EXACT | TWO_PASS | TWO_PASS_RASTER | KEYS, NULL, NULL, PLAN_LAYERED, 0 },
    { "no atomics", no_atomics, TWO_PASS, NULL, "+nearest id", PLAN_ATOMIC64, 0 },
    { "no atomics", no_atomics, EXACT, NULL, "+repair id", PLAN_ATOMIC64, 0 },
};

static void expect_change(const char *name, int way, const char *change, bool before, bool after)
{
    bool appears = change[0] == '+';
    if (before != !appears || after != appears)
        fail_msg("%s, way %d: %s (was there: %d, is there: %d)", name, way, change, before, after);
}

static void check_feature(const struct feature *feature, int way)
{
    struct inputs without = plain_inputs(), with = plain_inputs();
    choose_way(&without, way);
    choose_way(&with, way);
    feature->set(&with);
    struct stp_plan *a = plan_of(&without), *b = plan_of(&with);
    if (feature->resource)
        expect_change(feature->name, way, feature->resource,
                      resource_named(a, feature->resource + 1) != NULL,
                      resource_named(b, feature->resource + 1) != NULL);
    if (feature->pass)
        expect_change(feature->name, way, feature->pass, pass_named(a, feature->pass + 1) != NULL,
                      pass_named(b, feature->pass + 1) != NULL);
    if (feature->constant >= 0 && b->constant[feature->constant] != feature->value)
        fail_msg("%s, way %d: constant %d is %u", feature->name, way, feature->constant,
                 b->constant[feature->constant]);
    stp_plan_destroy(&a);
    stp_plan_destroy(&b);
    release_inputs(&without);
    release_inputs(&with);
}

static void test_features(void **state)
{
    for (unsigned i = 0; i < sizeof features / sizeof *features; i++)
        for (int way = 0; way < WAYS; way++)
            if (features[i].ways >> way & 1)
                check_feature(&features[i], way);
}

/* Nothing but the constants that every plan has to name: what is on, the squarings of 32. */
static void test_the_least(void **state)
{
    struct inputs in = plain_inputs();
    in.params.min_splat = -1;
    struct stp_plan *plan = plan_of(&in);
    const uint32_t expected[PLAN_CONSTANTS] = {
        [PLAN_GROUPS] = 1,   [PLAN_PACKED] = 1,  [PLAN_HEAD_LIGHT] = 1, [PLAN_SQUARINGS] = 5,
        [PLAN_ATOMIC64] = 1, [PLAN_FLOAT64] = 1, [PLAN_SAMPLE_GRID] = 1
    };
    assert_memory_equal(plan->constant, expected, sizeof expected);
    assert_int_equal(plan_bytes(plan, PLAN_SCENE), 100 * 32);
    assert_int_equal(resource_named(plan, "splats")->bytes, 100 * 32);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* An environment that no surface meets and nobody asked to see leaves the plan as it was. */
static void test_unmet_environment(void **state)
{
    struct inputs in = plain_inputs();
    struct stp_plan *without = plan_of(&in);
    around(&in);
    struct stp_plan *with = plan_of(&in);
    assert_memory_equal(with->resource, without->resource, sizeof with->resource);
    assert_memory_equal(with->pass, without->pass, sizeof with->pass);
    assert_memory_equal(with->constant, without->constant, sizeof with->constant);
    assert_memory_equal(&with->frame, &without->frame, sizeof with->frame);
    stp_plan_destroy(&with);
    stp_plan_destroy(&without);
    release_inputs(&in);
}

/* Groups that each cover the surface leave an opaque scene's plan as it was; without glass the
 * plans that take them have nothing of an environment, and only nearest has a mask. */
static void test_covers(void **state)
{
    for (int i = 0; i < 8; i++) {
        struct inputs in = plain_inputs();
        cover_inputs(&in);
        in.params.transparency = i & 1 ? STP_TRANSPARENCY_NEAREST : STP_TRANSPARENCY_FAST;
        if (i & 2)
            glass(&in);
        else if (i & 4)
            faded(&in);
        struct stp_plan *plan = plan_of(&in);
        bool covers = (i & 6) != 0;
        assert_true(plan_covers(plan) == covers);
        assert_true((resource_named(plan, "blended") != NULL) == covers);
        assert_true((resource_named(plan, "order") != NULL) == covers);
        assert_true((resource_named(plan, "mask") != NULL) == (covers && (i & 1)));
        assert_true((resource_named(plan, "environment") != NULL) == ((i & 2) != 0));
        assert_true((resource_named(plan, "optics") != NULL) == ((i & 2) != 0));
        assert_true((plan->constant[PLAN_OPTICS] != 0) == ((i & 2) != 0));
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* auto: exact, where the device has 64-bit atomics. An opaque scene takes no notice. */
static void test_transparency(void **state)
{
    for (int i = 0; i < 4; i++) {
        struct inputs in = plain_inputs();
        if (i & 1)
            fade_inputs(&in, false);
        if (i & 2)
            no_atomics(&in);
        struct stp_plan *plan = plan_of(&in);
        struct stp_plan_summary summary;
        stp_plan_summarize(plan, &summary);
        assert_int_equal(summary.transparency, i == 1   ? STP_TRANSPARENCY_EXACT
                                               : i == 3 ? STP_TRANSPARENCY_REFERENCE
                                                        : STP_TRANSPARENCY_AUTO);
        assert_int_equal(summary.method, i == 3 ? STP_METHOD_REFERENCE : STP_METHOD_EXACT);
        assert_int_equal(plan->loop_first != 0, i == 1);
        stp_plan_destroy(&plan);
        in.params.transparency = STP_TRANSPARENCY_EXACT;
        in.params.method = STP_METHOD_EXACT;
        enum stp_result result =
            stp_plan_create(NULL, in.scene, &in.camera, &in.params, &in.limits, &plan);
        assert_int_equal(result, i == 3 ? STP_ERROR_FEATURE : STP_OK);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* Of a plain scene, every way has these resources and constants, and not one more. */
static void test_the_least_of_all(void **state)
{
    static const char *const resources[WAYS] = {
        "splats color normal depth work large slots counts ",
        "splats color normal depth work large sums ",
        "splats color normal depth work nearest depth test sum depth sum ",
        "splats color normal depth work large keys ",
        "splats color normal depth work winners depth test order ",
    };
    static const char *const constants[WAYS] = {
        "0=1 2=1 11=1 15=5 18=1 20=1 21=1 ",     "0=1 11=1 15=5 18=1 20=1 21=1 ",
        "0=1 11=1 15=5 18=1 20=1 21=1 ",         "0=4 1=1 2=1 11=1 15=5 18=1 20=1 21=1 ",
        "0=4 1=1 2=1 11=1 15=5 18=1 20=1 21=1 ",
    };
    for (int way = 0; way < WAYS; way++) {
        struct inputs in = plain_inputs();
        char named[512] = "", numbered[512] = "", part[64];
        choose_way(&in, way);
        in.params.min_splat = -1;
        struct stp_plan *plan = plan_of(&in);
        for (uint32_t i = 0; i < plan->resource_count; i++) {
            strcat(named, plan->resource[i].name);
            strcat(named, " ");
        }
        for (int i = 0; i < PLAN_CONSTANTS; i++) {
            snprintf(part, sizeof part, "%d=%u ", i, plan->constant[i]);
            strcat(numbered, plan->constant[i] ? part : "");
        }
        assert_string_equal(named, resources[way]);
        assert_string_equal(numbered, constants[way]);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* Each channel alone: what carries it, and nothing for those that depth and normal already say. */
static void test_channels(void **state)
{
    static const struct {
        unsigned aov;
        bool albedo, id;
    } cases[] = { { 0, false, false },
                  { STP_AOV_ALBEDO, true, false },
                  { STP_AOV_WEIGHT, true, false },
                  { STP_AOV_FRAGMENTS, false, true },
                  { STP_AOV_ID, false, true },
                  { STP_AOV_POSITION, false, false },
                  { STP_AOV_COVERAGE, false, false },
                  { STP_AOV_LAYERS, false, false } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int way = 0; way < WAYS; way++) {
            struct inputs in = plain_inputs();
            choose_way(&in, way);
            in.params.aovs = cases[i].aov;
            struct stp_plan *plan = plan_of(&in);
            assert_int_equal(plan_find(plan, PLAN_OUT_ALBEDO) != PLAN_NONE, cases[i].albedo);
            assert_int_equal(plan_find(plan, PLAN_OUT_ID) != PLAN_NONE, cases[i].id);
            assert_int_equal(pass_named(plan, "clear id") != NULL, cases[i].id);
            assert_int_equal(plan->constant[PLAN_AOVS],
                             (cases[i].albedo ? 1 : 0) | (cases[i].id ? 2 : 0));
            stp_plan_destroy(&plan);
            release_inputs(&in);
        }
    }
}

/* By default: slabs where c < 1 and by the rasteriser, else the exact way. */
static void test_voronoi(void **state)
{
    for (int i = 0; i < 4; i++) {
        struct inputs in = plain_inputs();
        in.params.method = STP_METHOD_DEFERRED;
        in.params.path = i & 1 ? STP_PATH_RASTER : STP_PATH_COMPUTE;
        in.scene->facts.grouping.overlap = i & 2 ? 1 : 0.9;
        struct stp_plan *plan = plan_of(&in);
        assert_int_equal(plan->constant[PLAN_VORONOI], i == 2 ? 2 : 1);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* As many layers, keys and passes as there are groups. */
static void test_groups(void **state)
{
    for (unsigned groups = 1; groups <= STP_MAX_GROUPS; groups += 9) {
        struct inputs in = plain_inputs();
        in.params.method = STP_METHOD_DEFERRED;
        in.params.payload = STP_PAYLOAD_ID;
        in.params.voronoi = STP_VORONOI_OFF;
        in.scene->facts.grouping = (struct stp_grouping){ .groups = groups, .overlap = 1 };
        for (size_t i = 0; i < in.scene->splats.count; i++)
            in.scene->splats.group[i] = (uint8_t)(i % groups);
        struct stp_plan *plan = plan_of(&in);
        assert_int_equal(plan->constant[PLAN_GROUPS], groups);
        assert_int_equal(plan->constant[PLAN_VORONOI], 0);
        assert_int_equal(resource_named(plan, "keys")->bytes, 64 * 48 * 8 * groups);
        stp_plan_destroy(&plan);
        in.params.path = STP_PATH_RASTER;
        plan = plan_of(&in);
        assert_int_equal(plan->resource[plan_find(plan, PLAN_IMAGE_DEPTH)].layers, groups);
        assert_int_equal(plan->pass_count,
                         groups + 7); /* three fills; what was touched; composite */
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* The shininess as squarings: 1 is none, 2^16 is sixteen, anything else takes pow. */
static void test_squarings(void **state)
{
    static const struct {
        float shininess;
        uint32_t squarings;
    } cases[] = { { 1, 0 },       { 2, 1 },   { 32, 5 },    { 65536, 16 },
                  { 131072, 32 }, { 33, 32 }, { 0.5f, 32 }, { 0, 32 } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct inputs in = plain_inputs();
        in.scene->objects[0].material.shininess = cases[i].shininess;
        struct stp_plan *plan = plan_of(&in);
        assert_int_equal(plan->constant[PLAN_SQUARINGS], cases[i].squarings);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

/* Packed depth has 24 bits: ids where the range is too many epsilons, or are wanted. */
static void test_payload(void **state)
{
    struct inputs in = plain_inputs();
    in.scene->objects[0].epsilon = 1e-6;
    struct stp_plan *plan = plan_of(&in);
    assert_int_equal(plan->payload, STP_PAYLOAD_ID);
    stp_plan_destroy(&plan);
    in.scene->objects[0].epsilon = 0.1;
    in.params.payload = STP_PAYLOAD_ID;
    plan = plan_of(&in);
    assert_int_equal(plan->constant[PLAN_PACKED], 0);
    stp_plan_destroy(&plan);
    in.params.payload = STP_PAYLOAD_AUTO;
    in.params.method = STP_METHOD_DEFERRED;
    in.params.aovs = STP_AOV_ID;
    plan = plan_of(&in);
    assert_int_equal(plan->constant[PLAN_PACKED], 0);
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_features),
        cmocka_unit_test(test_the_least),
        cmocka_unit_test(test_covers),
        cmocka_unit_test(test_transparency),
        cmocka_unit_test(test_voronoi),
        cmocka_unit_test(test_groups),
        cmocka_unit_test(test_squarings),
        cmocka_unit_test(test_payload),
        cmocka_unit_test(test_unmet_environment),
        cmocka_unit_test(test_the_least_of_all),
        cmocka_unit_test(test_channels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
