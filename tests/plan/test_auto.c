/* What auto decides, under prices that are made up. */
#include "plans.h"

#include "base/memory.h"
#include "plan/auto.h"

/* A wavy sheet of 40 x 40 discs that overlap: enough for errors and groups. */
static struct inputs wavy(void)
{
    struct inputs in = { .scene = scene_make(1600, 1, 0.06),
                         .camera = plain_camera(160, 120, 150) };
    for (int i = 0; i < 1600; i++) {
        double x = i % 40 * 0.05 - 1, y = i / 40 * 0.05 - 1;
        scene_add(in.scene, v3(x, y, -3 + 0.1 * sin(4 * x + y)), v3(-0.4 * cos(4 * x + y), 0.1, 1),
                  0.06);
    }
    scene_finish(in.scene);
    price_nothing(&in);
    return in;
}

/* So many milliseconds a frame, and of deferred also a little for every layer, so that fewer groups
 * are cheaper. */
static void price(struct inputs *in, enum plan_cost kind, double ms)
{
    price_frame(in, kind, ms);
    if (kind >= PLAN_COST_DEFERRED_PACKED && kind <= PLAN_COST_DEFERRED_RASTER_ID)
        in->limits.calibration.ns[kind][PLAN_TERM_DEEP] = 5.7; /* 0.11 ms a layer */
}

static void price_all(struct inputs *in, double deferred, double exact, double two_pass)
{
    price(in, PLAN_COST_DEFERRED_PACKED, deferred);
    price(in, PLAN_COST_EXACT_PACKED, exact);
    price(in, PLAN_COST_EXACT_ID, exact * 3);
    price(in, PLAN_COST_TWO_PASS, two_pass);
    price(in, PLAN_COST_TWO_PASS_RASTER, two_pass * 2);
}

#define EVERY 100000 /* cells */

/* The error of the plan's groups by so many cells; *most: what is then said to be the most. */
static struct probe_error error_by(const struct inputs *in, const struct stp_choice *choice,
                                   unsigned cells, double *most)
{
    struct survey survey;
    struct probe probe;
    struct auto_estimate e = { 0 };
    struct stp_plan *plan = NULL;
    assert_int_equal(survey_make(NULL, in->scene, &in->camera, &in->params, &survey), STP_OK);
    assert_int_equal(
        probe_make(NULL, in->scene, &in->camera, &in->params, &survey,
                   &(const struct probe_sample){ .cells = cells, .alone = cells == AUTO_CELLS },
                   &probe),
        STP_OK);
    assert_int_equal(
        stp_plan_create(NULL, in->scene, &in->camera, &choice->params, &in->limits, &plan), STP_OK);
    assert_int_equal(probe_judge(NULL, &probe, plan, plan_offer_of(plan)->keep,
                                 in->scene->splats.group, false, &e.error),
                     STP_OK);
    e.more = plan_rounding(plan);
    e.rare = plan_offer_of(plan)->rare;
    auto_conclude(&e);
    *most = e.high;
    stp_plan_destroy(&plan);
    probe_release(&probe);
    survey_release(&survey);
    return e.error;
}

/* The cheapest that meets the bound: deferred while it does, at the fewest groups; then exact; then
 * two-pass. */
static void test_bounds(void **state)
{
    static const struct {
        double bound;
        enum stp_method method;
    } cases[] = { { 0.1, STP_METHOD_DEFERRED },
                  { 0.005, STP_METHOD_DEFERRED },
                  { 6e-5, STP_METHOD_EXACT },
                  { 5e-6, STP_METHOD_TWO_PASS } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct inputs in = wavy();
        double most;
        price_all(&in, 1, 2, 5);
        in.params.max_error = cases[i].bound;
        struct stp_choice choice = choose(&in);
        assert_true(choice.met);
        assert_int_equal(choice.params.method, cases[i].method);
        assert_int_equal(in.scene->facts.grouping.groups > 0,
                         cases[i].method == STP_METHOD_DEFERRED);
        assert_true(error_by(&in, &choice, EVERY, &most).mean <= cases[i].bound);
        assert_true(choice.params.prediction.error <= cases[i].bound);
        assert_true(choice.params.prediction.bound == cases[i].bound);
        release_inputs(&in);
    }
}

/* A bound so near the error that no sample tells: all cells are looked at, unless another way takes
 * hardly longer. */
static void test_close(void **state)
{
    struct inputs in = wavy();
    double most, sampled;
    in.camera = plain_camera(400, 300, 375);
    price_all(&in, 100, 2, 5);
    in.params.max_error = 1;
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_EXACT);
    assert_int_equal(choice.params.payload, STP_PAYLOAD_PACKED);
    struct probe_error error = error_by(&in, &choice, EVERY, &most);
    error_by(&in, &choice, AUTO_CELLS, &sampled);
    assert_true(error.spread == 0 && error.mean > 1e-5 && most < 1.1 * error.mean);
    assert_true(sampled > 1.001 * most);
    in.params.max_error = (most + sampled) / 2;
    choice = choose(&in);
    assert_true(choice.met);
    assert_int_equal(choice.params.payload, STP_PAYLOAD_PACKED);
    assert_true(choice.params.prediction.error < sampled);
    price(&in, PLAN_COST_TWO_PASS, 2.2);
    assert_int_equal(choose(&in).params.method, STP_METHOD_TWO_PASS);
    price(&in, PLAN_COST_TWO_PASS, 5);
    in.params.max_error = 0.999 * error.mean;
    assert_int_equal(choose(&in).params.method, STP_METHOD_TWO_PASS);
    release_inputs(&in);
}

/* Edge-on through the eye, so that nothing of it shows, and cut by the near plane: it may touch
 * many blocks. What does show is so small that no sample of their cells holds enough of it: nothing
 * is promised before it has been seen. */
static void test_small(void **state)
{
    struct inputs in = { .scene = scene_make(1601, 1, 0.06),
                         .camera = plain_camera(1024, 1024, 1000) };
    for (int i = 0; i < 1600; i++) {
        double x = i % 40 * 0.05 - 1, y = i / 40 * 0.05 - 1;
        scene_add(in.scene, v3(x, y, -150 + 0.1 * sin(4 * x + y)),
                  v3(-0.4 * cos(4 * x + y), 0.1, 1), 0.06);
    }
    scene_add(in.scene, v3(0, 0, -in.camera.near_depth), v3(1, 0.4, 0), 40 * in.camera.near_depth);
    scene_finish(in.scene);
    price_nothing(&in);
    price_all(&in, 1, 2, 5);
    in.params.max_error = 1e-3;
    struct stp_choice choice = choose(&in);
    double most;
    struct probe_error error = error_by(&in, &choice, EVERY, &most);
    assert_true(choice.met && error.pixels > 50 && error.spread == 0);
    assert_true(error.mean <= in.params.max_error);
    assert_true(choice.params.prediction.error >= error.mean);
    in.params.max_error = 0;
    choice = choose(&in);
    assert_true(choice.met && error_by(&in, &choice, EVERY, &most).mean <= STP_DEFAULT_MAX_ERROR);
    release_inputs(&in);
}

/* Where discs pile up a look at all cells would take minutes: what samples leave open is refused.
 */
static void test_piled(void **state)
{
    struct inputs in = { .scene = scene_make(90, 1, 4), .camera = plain_camera(1400, 1000, 1375) };
    for (int i = 0; i < 90; i++)
        scene_add(in.scene, v3(0, 0, -3), v3(0.002 * i, 0.3, 1), 4);
    scene_finish(in.scene);
    price_nothing(&in);
    price_all(&in, 100, 2, 5);
    in.params.method = STP_METHOD_EXACT;
    in.params.max_error = 1;
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.payload, STP_PAYLOAD_PACKED);
    double most;
    in.params.max_error = error_by(&in, &choice, AUTO_CELLS, &most).mean;
    assert_int_equal(choose(&in).params.payload, STP_PAYLOAD_ID);
    release_inputs(&in);
}

/* Prices do not tell ways apart that are about as dear: then groups are not sought. */
static void test_doubt(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 0.6, 1, 5);
    in.params.max_error = 0.1;
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_DEFERRED);
    double deferred = choice.params.prediction.milliseconds;
    price(&in, PLAN_COST_EXACT_PACKED, 1.04 * deferred);
    assert_int_equal(choose(&in).params.method, STP_METHOD_EXACT);
    price(&in, PLAN_COST_EXACT_PACKED, 1.06 * deferred);
    assert_int_equal(choose(&in).params.method, STP_METHOD_DEFERRED);
    release_inputs(&in);
}

/* Where another is cheaper, no groups are sought though they would do. */
static void test_prices(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 3, 2, 5);
    in.params.max_error = 0.1;
    assert_int_equal(choose(&in).params.method, STP_METHOD_EXACT);
    assert_null(in.scene->splats.group);
    price_all(&in, 3, 2, 1.5);
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_TWO_PASS);
    assert_int_equal(choice.params.path, STP_PATH_COMPUTE);
    price(&in, PLAN_COST_TWO_PASS_RASTER, 0.5);
    assert_int_equal(choose(&in).params.path, STP_PATH_RASTER);
    in.params.path = STP_PATH_COMPUTE; /* asked for */
    assert_int_equal(choose(&in).params.path, STP_PATH_COMPUTE);
    in.params.samples = 4; /* which the rasteriser has not */
    in.params.path = STP_PATH_AUTO;
    choice = choose(&in);
    assert_int_equal(choice.params.path, STP_PATH_COMPUTE);
    assert_true(fabs(choice.params.prediction.milliseconds - 4 * 1.5) < 1e-9);
    release_inputs(&in);
}

/* What has colours has prices of its own, by the rasteriser and by ids too. */
static void test_colored(void **state)
{
    struct inputs in = wavy();
    color_inputs(&in);
    in.params.max_error = 0.1;
    price(&in, PLAN_COST_TWO_PASS_RASTER, 1); /* of scenes without */
    price(&in, PLAN_COST_EXACT_ID, 1);
    price(&in, PLAN_COST_TWO_PASS_RASTER_COLOR, 3);
    price(&in, PLAN_COST_EXACT_ID_COLOR, 2);
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_EXACT);
    assert_int_equal(choice.params.payload, STP_PAYLOAD_ID);
    assert_true(fabs(choice.params.prediction.milliseconds - 2) < 1e-9);
    in.params.path = STP_PATH_RASTER;
    choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_TWO_PASS);
    assert_true(fabs(choice.params.prediction.milliseconds - 3) < 1e-9);
    release_inputs(&in);
}

/* Without a bound, groups cost more than a picture, however cheap it would be with them. */
static void test_one_picture(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 0.001, 2, 5);
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_EXACT);
    assert_true(choice.params.prediction.bound == STP_DEFAULT_MAX_ERROR);
    for (unsigned i = 0; i < choice.count; i++)
        assert_int_equal(choice.considered[i].overlap, 0);
    release_inputs(&in);
}

/* Every way that was considered, by price; one of them chosen; what is beyond the bound is so. */
static void test_considered(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 1, 2, 5);
    in.params.max_error = 6e-5;
    struct stp_choice choice = choose(&in);
    unsigned chosen = 0, inexact = 0;
    for (unsigned i = 0; i < choice.count; i++) {
        const struct stp_considered *c = &choice.considered[i];
        assert_true(i == 0 || c->milliseconds >= choice.considered[i - 1].milliseconds);
        chosen += c->verdict == STP_VERDICT_CHOSEN;
        inexact += c->verdict == STP_VERDICT_INEXACT;
        assert_true(c->verdict != STP_VERDICT_INEXACT || c->error > 6e-5);
    }
    assert_int_equal(chosen, 1);
    assert_true(inexact >= 2);
    release_inputs(&in);
}

static void test_fixed(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 1, 2, 5);
    in.params.max_error = 0.1;
    in.params.method = STP_METHOD_TWO_PASS;
    assert_int_equal(choose(&in).params.method, STP_METHOD_TWO_PASS);
    in.params.method = STP_METHOD_DEFERRED;
    struct stp_group_params group = { .overlap = 0.7 };
    struct stp_choice choice;
    assert_int_equal(
        stp_choose(NULL, in.scene, &in.camera, &group, &in.params, &in.limits, &choice), STP_OK);
    assert_true(in.scene->facts.grouping.overlap == 0.7);
    assert_int_equal(choice.params.method, STP_METHOD_DEFERRED);
    assert_in_range(choice.count, 2, STP_MAX_CONSIDERED);
    for (unsigned i = 0; i < choice.count; i++) {
        const struct stp_considered *a = &choice.considered[i], *b = a + 1;
        assert_true(a->overlap == 0.7);
        for (; b < choice.considered + choice.count; b++)
            assert_false(a->path == b->path && a->payload == b->payload &&
                         a->voronoi == b->voronoi);
    }
    release_inputs(&in);
}

/* The same for any number of threads, and again for a scene that is grouped already. */
static void test_same(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 1, 2, 5);
    in.params.max_error = 0.01;
    struct stp_choice first = choose(&in);
    for (unsigned threads = 1; threads < 5; threads++) {
        struct stp_env env = { .threads = threads };
        struct stp_choice again;
        memset(&again, 0, sizeof again);
        assert_int_equal(
            stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &again), STP_OK);
        assert_int_equal(again.count, first.count);
        assert_true(again.params.prediction.error == first.params.prediction.error);
        assert_true(again.params.prediction.milliseconds == first.params.prediction.milliseconds);
        assert_int_equal(again.params.voronoi, first.params.voronoi);
    }
    release_inputs(&in);
}

static void test_sentence(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 1, 2, 5);
    in.params.max_error = 0.0125;
    struct stp_choice choice = choose(&in);
    struct stp_plan *plan = NULL;
    assert_int_equal(stp_plan_create(NULL, in.scene, &in.camera, &choice.params, &in.limits, &plan),
                     STP_OK);
    assert_non_null(strstr(plan->why, "the cheapest within an error of 0.0125"));
    assert_non_null(strstr(plan->why, " ms, error at most "));
    stp_plan_destroy(&plan);
    release_inputs(&in);
}

/* All that methods offer has room in a choice, whatever the scene. */
static void test_room(void **state)
{
    unsigned all = 0;
    for (unsigned o = 0; o < plan_offer_count; o++) {
        struct plan_candidate way[PLAN_MAX_OFFERED];
        unsigned count = plan_offers[o]->candidates(way);
        assert_in_range(count, 1, PLAN_MAX_OFFERED);
        all += count;
    }
    assert_in_range(all, 1, STP_MAX_CONSIDERED);
}

/* Nothing meets it: the most exact, and a line that says so. */
static void test_unmet(void **state)
{
    struct inputs in = wavy();
    struct plan_log log = { 0 };
    struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct stp_choice choice;
    price_all(&in, 1, 2, 5);
    in.params.max_error = 1e-9;
    assert_int_equal(stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice),
                     STP_OK);
    assert_false(choice.met);
    assert_int_equal(choice.params.method, STP_METHOD_TWO_PASS);
    assert_int_equal(log.lines, 1);
    assert_non_null(strstr(log.last, "1e-09"));
    assert_int_equal(choice.params.path, STP_PATH_COMPUTE);
    price(&in, PLAN_COST_TWO_PASS_RASTER, 4); /* no less exact, and cheaper */
    assert_int_equal(choose(&in).params.path, STP_PATH_RASTER);
    release_inputs(&in);
}

/* A scene in HDR: what is little of its colours is much in absolute terms. */
static void test_bright(void **state)
{
    struct inputs in = wavy();
    color_inputs(&in);
    price_all(&in, 1, 2, 5);
    price(&in, PLAN_COST_EXACT_PACKED_IDS, 2);
    price(&in, PLAN_COST_TWO_PASS_COLOR, 5);
    for (int i = 0; i < 1600; i++)
        scene_paint(in.scene, (size_t)i, 30, 20, 10);
    in.scene->facts.color_max = 30;
    in.params.max_error = 6e-5;
    assert_int_equal(choose(&in).params.method, STP_METHOD_TWO_PASS);
    release_inputs(&in);
}

/* One pixel a point: where the bound is loose, and only with a bound. */
static void test_pyramid(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 3, 2, 5);
    price(&in, PLAN_COST_PYRAMID, 0.5);
    in.params.max_error = 0.2;
    struct stp_choice choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_PYRAMID);
    assert_true(choice.met && choice.params.prediction.error > 1e-4);
    double error = choice.params.prediction.error;
    in.params.max_error = error / 2;
    choice = choose(&in);
    assert_int_equal(choice.params.method, STP_METHOD_EXACT);
    assert_int_equal(choice.considered[0].method, STP_METHOD_PYRAMID);
    assert_int_equal(choice.considered[0].verdict, STP_VERDICT_INEXACT);
    in.params.max_error = 0;
    choice = choose(&in);
    for (unsigned i = 0; i < choice.count; i++)
        assert_int_not_equal(choice.considered[i].method, STP_METHOD_PYRAMID);
    in.scene->facts.eye_dome = true; /* which is not the probe's */
    in.params.max_error = 0.2;
    assert_int_equal(choose(&in).params.method, STP_METHOD_EXACT);
    release_inputs(&in);
}

static void test_refused(void **state)
{
    struct plan_log log = { 0 };
    struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct stp_choice choice = { .count = 77 };
    struct inputs in = wavy();
    in.params.method = STP_METHOD_EXACT; /* which has no raster path */
    in.params.path = STP_PATH_RASTER;
    assert_int_equal(stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice),
                     STP_OK);
    assert_int_equal(choice.count, 0); /* the plan says why */
    assert_int_equal(choice.params.method, STP_METHOD_EXACT);
    choice.count = 77;
    in.params = (struct stp_render_params){ .max_error = NAN };
    assert_int_equal(stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice),
                     STP_ERROR_ARGUMENT);
    in.params = (struct stp_render_params){ .method = STP_METHOD_REFERENCE };
    assert_int_equal(stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(log.lines, 2);
    assert_int_equal(choice.count, 77);
    in.params = (struct stp_render_params){ .method = STP_METHOD_AXIS, .max_error = 1e-6 };
    assert_int_equal(stp_choose(&env, in.scene, &in.camera, NULL, &in.params, &in.limits, &choice),
                     STP_OK);
    assert_true(choice.count == 0 && !choice.met && log.lines == 3);
    assert_non_null(strstr(log.last, "not looked at"));
    release_inputs(&in);
}

/* Every allocation of a choice fails in turn: one line, and nothing is touched. */
static void fail_each(const struct inputs *in)
{
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        struct plan_log log = { 0 };
        struct stp_env env = { .threads = 1, .log = plan_keep_line, .user = &log };
        struct stp_choice choice = { .count = 77 };
        mem_fail_at(n);
        result = stp_choose(&env, in->scene, &in->camera, NULL, &in->params, &in->limits, &choice);
        mem_fail_at(0);
        assert_true(result == STP_OK || result == STP_ERROR_MEMORY);
        if (result != STP_OK) {
            assert_int_equal(log.lines, 1);
            assert_int_equal(choice.count, 77);
            assert_null(in->scene->splats.group);
        }
    }
}

static void test_no_memory(void **state)
{
    struct inputs in = wavy();
    price_all(&in, 1, 2, 5);
    price(&in, PLAN_COST_PYRAMID, 0.1);
    in.params.max_error = 0.001; /* the pyramid is judged, then groups are made */
    fail_each(&in);
    release_inputs(&in);
}

/* And while all cells are looked at. */
static void test_close_no_memory(void **state)
{
    struct inputs in = wavy();
    double most;
    in.camera = plain_camera(220, 165, 206);
    price_all(&in, 100, 2, 5);
    in.params.max_error = 1;
    struct stp_choice choice = choose(&in);
    in.params.method = STP_METHOD_EXACT;
    in.params.payload = STP_PAYLOAD_PACKED;
    in.params.max_error = error_by(&in, &choice, EVERY, &most).mean;
    fail_each(&in);
    release_inputs(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_close),
        cmocka_unit_test(test_small),
        cmocka_unit_test(test_piled),
        cmocka_unit_test(test_doubt),
        cmocka_unit_test(test_prices),
        cmocka_unit_test(test_colored),
        cmocka_unit_test(test_one_picture),
        cmocka_unit_test(test_considered),
        cmocka_unit_test(test_fixed),
        cmocka_unit_test(test_room),
        cmocka_unit_test(test_same),
        cmocka_unit_test(test_sentence),
        cmocka_unit_test(test_unmet),
        cmocka_unit_test(test_bright),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_pyramid),
        cmocka_unit_test(test_no_memory),
        cmocka_unit_test(test_close_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
