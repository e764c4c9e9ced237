/* What auto decides of transparent scenes, under prices that are made up: three sheets that face
 * the eye, whose layers' errors are known beforehand. */
#include "plans.h"

#include "base/memory.h"

#define SHEET 48   /* discs a side */
#define LIGHT 0.84 /* of a sheet: 0.8 (0.1 + 0.7) + 0.2 */
#define ALPHA 0.4

/* opaque: the second sheet is. */
static struct inputs sheets(bool opaque)
{
    size_t count = 3 * SHEET * SHEET;
    struct inputs in = { .scene = scene_make(count, 1, 0.06), .camera = plain_camera(48, 40, 60) };
    for (int s = 0; s < 3; s++)
        for (int i = 0; i < SHEET * SHEET; i++) {
            struct vec3 at = v3(i % SHEET * 0.1 - 2.35, i / SHEET * 0.1 - 2.35, -3 - 0.5 * s);
            size_t id = scene_add(in.scene, at, v3(0, 0, 1), 0.1);
            scene_fade(in.scene, id, opaque && s == 1 ? 1 : (float)ALPHA);
        }
    scene_finish(in.scene);
    price_nothing(&in);
    return in;
}

/* A peeled layer costs as much as said. */
static void price_all(struct inputs *in, double exact, double layer)
{
    price_frame(in, PLAN_COST_LAYERS_PACKED, exact);
    price_frame(in, PLAN_COST_LAYERS_PACKED_IDS, exact);
    price_frame(in, PLAN_COST_LAYERS_ID, exact * 2);
    price_frame(in, PLAN_COST_PEEL, layer);
    price_frame(in, PLAN_COST_PEEL_RASTER, layer * 3);
}

/* Light that the layers behind the first `layers` of three would add, before what is behind. */
static double missing(unsigned layers, double behind)
{
    return fabs(LIGHT - behind) * (pow(1 - ALPHA, layers) - pow(1 - ALPHA, 3));
}

static const struct stp_considered *find(const struct stp_choice *choice, unsigned layers)
{
    for (unsigned i = 0; i < choice->count; i++)
        if (choice->considered[i].peel_layers == layers &&
            choice->considered[i].path == STP_PATH_COMPUTE)
            return &choice->considered[i];
    return NULL;
}

static void expect_error(const struct stp_choice *choice, unsigned layers, double error)
{
    const struct stp_considered *c = find(choice, layers);
    assert_non_null(c);
    if (!(fabs(c->error - error) < 1e-5))
        fail_msg("%u layers: %g, not %g", layers, c->error, error);
}

/* The fewest layers that do, while they cost less than exact. */
static void test_bounds(void **state)
{
    static const struct {
        double bound, exact;
        unsigned layers; /* 0: exact */
    } cases[] = { { 0.4, 10, 1 },   { 0.15, 10, 2 },  { 0.01, 10, 4 },
                  { 0.01, 3.5, 0 }, { 0.15, 1.5, 0 }, { 0.4, 1.5, 1 } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct inputs in = sheets(false);
        price_all(&in, cases[i].exact, 1);
        in.params.max_error = cases[i].bound;
        struct stp_choice choice = choose(&in);
        assert_true(choice.met && choice.params.prediction.error <= cases[i].bound);
        assert_int_equal(choice.params.transparency,
                         cases[i].layers ? STP_TRANSPARENCY_PEEL : STP_TRANSPARENCY_EXACT);
        assert_int_equal(choice.params.method,
                         cases[i].layers ? STP_METHOD_TWO_PASS : STP_METHOD_EXACT);
        assert_int_equal(choice.params.peel_layers, cases[i].layers);
        assert_true(fabs(choice.params.prediction.milliseconds -
                         (cases[i].layers ? cases[i].layers : cases[i].exact)) < 1e-9);
        release_inputs(&in);
    }
}

static void test_errors(void **state)
{
    static const float background[4] = { 0.5f, 0.5f, 0.5f, 1 };
    for (int behind = 0; behind < 2; behind++) {
        struct inputs in = sheets(false);
        price_all(&in, 100, 1);
        in.params.max_error = 0.01;
        in.params.background = behind ? background : NULL;
        struct stp_choice choice = choose(&in);
        expect_error(&choice, 1, missing(1, behind * 0.5));
        expect_error(&choice, 2, missing(2, behind * 0.5));
        expect_error(&choice, 4, 0);
        release_inputs(&in);
    }
}

/* Behind something opaque nothing is missed. */
static void test_mixed(void **state)
{
    struct inputs in = sheets(true);
    price_all(&in, 100, 1);
    in.params.max_error = 0.01;
    struct stp_choice choice = choose(&in);
    expect_error(&choice, 1, LIGHT * (1 - ALPHA));
    expect_error(&choice, 2, 0);
    assert_int_equal(choice.params.peel_layers, 2);
    assert_true(fabs(choice.params.prediction.milliseconds - 2.5) < 1e-9);
    release_inputs(&in);
}

static void test_fixed(void **state)
{
    struct inputs in = sheets(false);
    price_all(&in, 1, 5);
    in.params.max_error = 0.4;
    in.params.transparency = STP_TRANSPARENCY_PEEL;
    assert_int_equal(choose(&in).params.peel_layers, 1);
    in.params.peel_layers = 3;
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.peel_layers, 3);
    assert_int_equal(choice.count, 2); /* both paths */
    in.params.transparency = STP_TRANSPARENCY_EXACT;
    assert_int_equal(choose(&in).params.method, STP_METHOD_EXACT);
    in.params.transparency = STP_TRANSPARENCY_AUTO;
    in.params.path = STP_PATH_RASTER; /* which exact has not */
    assert_int_equal(choose(&in).params.transparency, STP_TRANSPARENCY_PEEL);
    release_inputs(&in);
}

/* Without a bound nothing is decided; what needs groups that cover the surface is not judged. */
static void test_left_alone(void **state)
{
    struct inputs in = sheets(false);
    struct plan_log log = { 0 };
    struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct stp_choice choice = choose(&in);
    assert_true(choice.count == 0 && choice.met);
    assert_int_equal(choice.params.transparency, STP_TRANSPARENCY_AUTO);
    in.params.max_error = 0.1;
    in.params.transparency = STP_TRANSPARENCY_FAST;
    assert_int_equal(stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice),
                     STP_OK);
    assert_true(choice.count == 0 && !choice.met);
    assert_int_equal(log.lines, 1);
    assert_non_null(strstr(log.last, "fast"));
    release_inputs(&in);
}

static void test_sentence(void **state)
{
    struct inputs in = sheets(false);
    struct stp_plan *plan = NULL;
    price_all(&in, 100, 1);
    in.params.max_error = 0.15;
    struct stp_choice choice = choose(&in);
    assert_int_equal(stp_plan_create(NULL, in.scene, &in.camera, &choice.params, &in.limits, &plan),
                     STP_OK);
    assert_non_null(strstr(plan->why, "peel is the cheapest within an error of 0.15"));
    assert_non_null(strstr(plan->why, "the 2 nearest layers"));
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

static double error_with(struct inputs *in, enum stp_payload payload)
{
    in->params.payload = payload;
    return choose(in).params.prediction.error;
}

/* Fragments fall into this layer or the next by how their depths are rounded: with fewer bits, as a
 * deep scene leaves packed slots, more of them do. */
static void test_packing(void **state)
{
    struct inputs in = sheets(false);
    uint32_t seed = 7;
    price_all(&in, 1, 100);
    in.params.max_error = 0.4;
    in.scene->facts.bounds[2] = -2000;
    double few = error_with(&in, STP_PAYLOAD_PACKED);
    for (size_t i = 0; i < in.scene->splats.count; i++)
        in.scene->splats.position[i][2] -= 0.1 * uniform(&seed);
    double packed = error_with(&in, STP_PAYLOAD_PACKED), id = error_with(&in, STP_PAYLOAD_ID);
    if (!(packed > 2 * few && packed > 2 * id && packed < 1e-2))
        fail_msg("apart %g, mingled %g, with ids %g", few, packed, id);
    release_inputs(&in);
}

static void test_no_memory(void **state)
{
    enum stp_result result = STP_ERROR_MEMORY;
    struct inputs in = sheets(true);
    price_all(&in, 100, 1);
    in.params.max_error = 0.4;
    for (unsigned long n = 1; result != STP_OK; n++) {
        struct plan_log log = { 0 };
        struct stp_env env = { .threads = 1, .log = plan_keep_line, .user = &log };
        struct stp_choice choice = { .count = 77 };
        mem_fail_at(n);
        result = stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice);
        mem_fail_at(0);
        assert_true(result == STP_OK || result == STP_ERROR_MEMORY);
        assert_true(result == STP_OK || (log.lines == 1 && choice.count == 77));
    }
    release_inputs(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds),     cmocka_unit_test(test_errors),
        cmocka_unit_test(test_mixed),      cmocka_unit_test(test_fixed),
        cmocka_unit_test(test_left_alone), cmocka_unit_test(test_sentence),
        cmocka_unit_test(test_packing),    cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
