/* The probe against the reference's whole picture, and against winners found by other code. */
#include "../pass/ellipses.h"
#include "plans.h"

#include "base/memory.h"
#include "plan/offer.h"

#define EPSILON 0.3

struct bed {
    struct stp_scene *scene;
    struct stp_camera camera;
    struct stp_render_params params;
    struct stp_limits limits;
    struct survey survey;
    struct probe probe;
};

static struct probe probe_with(const struct bed *bed, const struct probe_sample *sample)
{
    struct probe probe;
    assert_int_equal(
        probe_make(NULL, bed->scene, &bed->camera, &bed->params, &bed->survey, sample, &probe),
        STP_OK);
    return probe;
}

static struct probe probe_of(const struct bed *bed, unsigned cells, unsigned part)
{
    return probe_with(bed, &(const struct probe_sample){ .cells = cells, .part = part });
}

static struct bed bed_of(struct stp_scene *scene, unsigned cells,
                         const struct stp_render_params *params)
{
    struct bed bed = { .scene = scene, .camera = hard_view(0, 121, 75), .params = *params };
    size_t count = scene->splats.count;
    stp_limits_lavapipe(&bed.limits);
    bed.scene->splats.group = calloc(count, 1);
    bed.scene->facts.grouping = (struct stp_grouping){ .groups = 1, .overlap = 0.4 };
    assert_int_equal(survey_make(NULL, bed.scene, &bed.camera, &bed.params, &bed.survey), STP_OK);
    bed.probe = probe_of(&bed, cells, 0);
    return bed;
}

static struct bed bed_with(uint32_t seed, size_t count, unsigned cells, double epsilon)
{
    const struct stp_render_params params = { .min_splat = -1 };
    return bed_of(scene_random(seed, count, epsilon), cells, &params);
}

static struct bed bed_make(uint32_t seed, size_t count, unsigned cells)
{
    return bed_with(seed, count, cells, EPSILON);
}

static void bed_release(struct bed *bed)
{
    probe_release(&bed->probe);
    survey_release(&bed->survey);
    stp_scene_destroy(&bed->scene);
}

static size_t pixel_of(const struct bed *bed, size_t i)
{
    const struct vec3 d = bed->probe.ray[i].along;
    long x = lround(d.x * bed->camera.fx + bed->camera.cx - 0.5);
    long y = lround(-d.y * bed->camera.fy + bed->camera.cy - 0.5);
    return x < bed->camera.width && y < bed->camera.height
               ? (size_t)y * bed->camera.width + (size_t)x
               : SIZE_MAX;
}

/* Every probed pixel is the reference's, covered or not; every cell of a touched block is probed.
 */
static void expect_truth(const struct bed *bed)
{
    struct stp_image *image = NULL;
    bool behind = bed->params.background != NULL;
    assert_int_equal(reference_render(NULL, bed->scene, &bed->camera, &bed->params, &image),
                     STP_OK);
    assert_true(bed->probe.cells == bed->survey.touched / 16);
    for (size_t i = 0; i < bed->probe.pixels; i++) {
        size_t at = pixel_of(bed, i);
        bool covered = bed->probe.first[i + 1] > bed->probe.first[i];
        if (at == SIZE_MAX) {
            assert_false(covered);
            continue;
        }
        assert_true(behind || covered == (stp_image_find(image, "A")->data.f[at] > 0));
        for (int k = 0; k < 3; k++)
            assert_true(
                fabs(stp_image_find(image, (const char *[]){ "R", "G", "B" }[k])->data.f[at] -
                     bed->probe.truth[3 * i + k]) < 1e-6);
    }
    stp_image_destroy(&image);
}

static void test_truth(void **state)
{
    for (uint32_t seed = 1; seed <= 5; seed++) {
        struct bed bed = bed_make(seed, 400, 10000);
        expect_truth(&bed);
        bed_release(&bed);
    }
}

/* Layers, some of them opaque, before a background or none; the layers of a pixel are counted. */
static void test_transparent_truth(void **state)
{
    static const float background[4] = { 0.3f, 0.9f, 0.1f, 0.5f };
    for (uint32_t seed = 1; seed <= 4; seed++) {
        struct stp_render_params params = { .min_splat = -1, .aovs = STP_AOV_LAYERS };
        struct stp_scene *scene = scene_make(300, 1, EPSILON);
        uint32_t state_of = seed;
        for (size_t i = 0; i < 300; i++) {
            struct vec3 p = random_point(&state_of, 1), n = random_point(&state_of, 1);
            scene_add(scene, p, n, 0.3 * uniform(&state_of) + 0.01);
            scene_fade(scene, i, seed % 2 && i % 7 == 0 ? 1 : (float)uniform(&state_of));
        }
        scene_finish(scene);
        params.background = seed > 2 ? background : NULL;
        struct bed bed = bed_of(scene, 10000, &params);
        assert_true(bed.scene->facts.transparent);
        expect_truth(&bed);
        assert_true(bed.probe.layers > 0.2 && bed.probe.layers < 20);
        bed_release(&bed);
    }
}

/* Ellipses, their fields of normals and their clip lines. */
static void test_phong_truth(void **state)
{
    for (uint32_t seed = 1; seed <= 4; seed++) {
        const struct stp_render_params params = { .min_splat = seed > 2 ? 2 : -1 };
        struct bed bed = bed_of(random_scene(seed, 300, seed % 2), 10000, &params);
        expect_truth(&bed);
        bed_release(&bed);
    }
}

static struct stp_plan *plan_for(const struct bed *bed, enum stp_method method,
                                 enum stp_payload payload, enum stp_voronoi voronoi)
{
    struct stp_plan *plan = NULL;
    struct stp_render_params params = bed->params;
    params.method = method;
    params.payload = payload;
    params.voronoi = voronoi;
    assert_int_equal(stp_plan_create(NULL, bed->scene, &bed->camera, &params, &bed->limits, &plan),
                     STP_OK);
    return plan;
}

static struct probe_error judge_of(const struct bed *bed, const struct stp_plan *plan)
{
    struct probe_error error;
    const struct plan_offer *offer = plan_offer_of(plan);
    assert_int_equal(
        probe_judge(NULL, &bed->probe, plan, offer->keep, bed->scene->splats.group, false, &error),
        STP_OK);
    return error;
}

/* Methods that keep everything differ by the bits that they keep. */
static void test_exact_methods(void **state)
{
    struct bed bed = bed_make(2, 400, 100);
    static const struct {
        enum stp_method method;
        enum stp_payload payload;
        double least, most;
    } cases[] = { { STP_METHOD_TWO_PASS, STP_PAYLOAD_AUTO, 0, 1e-12 },
                  { STP_METHOD_EXACT, STP_PAYLOAD_ID, 1e-9, 2e-5 },
                  { STP_METHOD_EXACT, STP_PAYLOAD_PACKED, 1e-6, 1e-4 } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct stp_plan *plan =
            plan_for(&bed, cases[i].method, cases[i].payload, STP_VORONOI_DEFAULT);
        struct probe_error error = judge_of(&bed, plan);
        assert_true(error.mean >= cases[i].least && error.mean <= cases[i].most);
        assert_true(error.pixels > 100 && error.spread <= error.mean);
        stp_plan_destroy(&plan);
    }
    bed_release(&bed);
}

/* One group for all: the survivor of each pixel, by its definition. */
static size_t winner(const struct probe_fragment *f, size_t count, double low,
                     enum stp_voronoi voronoi)
{
    size_t best = 0;
    double near = INFINITY;
    for (size_t i = 0; i < count; i++)
        near = fmin(near, f[i].depth);
    for (size_t i = 0; i < count; i++) {
        bool better;
        double slab = floor((f[i].depth - low) / EPSILON),
               slab_best = floor((f[best].depth - low) / EPSILON);
        if (voronoi == STP_VORONOI_OFF)
            better = f[i].depth < f[best].depth;
        else if (voronoi == STP_VORONOI_SLAB)
            better = slab < slab_best || (slab == slab_best && f[i].rho2 < f[best].rho2);
        else
            better = f[i].depth <= near + EPSILON &&
                     (f[best].depth > near + EPSILON || f[i].rho2 < f[best].rho2);
        best = better ? i : best;
    }
    return best;
}

static void check_winners(const struct bed *bed, enum stp_voronoi voronoi)
{
    struct stp_plan *plan = plan_for(bed, STP_METHOD_DEFERRED, STP_PAYLOAD_ID, voronoi);
    struct probe_fragment scratch[400];
    assert_int_equal(plan->voronoi, voronoi);
    size_t wrong = 0, seen = 0;
    double low = plan->frame.depth_low;
    for (size_t i = 0; i < bed->probe.pixels; i++) {
        size_t first = bed->probe.first[i], count = bed->probe.first[i + 1] - first;
        if (!count)
            continue;
        memcpy(scratch, &bed->probe.fragment[first], count * sizeof *scratch);
        plan_deferred_offer.keep(plan, scratch, count);
        size_t kept = 0;
        for (size_t k = 0; k < count; k++)
            kept += scratch[k].kept;
        assert_int_equal(kept, 1);
        seen++;
        wrong += !scratch[winner(&bed->probe.fragment[first], count, low, voronoi)].kept;
    }
    assert_true(seen > 500);
    assert_true(wrong <= seen / 100); /* rho of a slab has 14 bits: near ties may fall either way */
    stp_plan_destroy(&plan);
}

static void test_winners(void **state)
{
    struct bed bed = bed_make(3, 300, 10000);
    check_winners(&bed, STP_VORONOI_OFF);
    check_winners(&bed, STP_VORONOI_SLAB);
    check_winners(&bed, STP_VORONOI_EXACT);
    bed_release(&bed);
}

/* A group each: nothing is lost. All in one: much is, and more without Voronoi than with. */
static void test_groups(void **state)
{
    struct bed bed = bed_with(4, 60, 10000, 5);
    struct stp_plan *plan = plan_for(&bed, STP_METHOD_DEFERRED, STP_PAYLOAD_ID, STP_VORONOI_SLAB);
    double one = judge_of(&bed, plan).mean;
    for (size_t i = 0; i < 60; i++)
        bed.scene->splats.group[i] = (uint8_t)i;
    assert_true(judge_of(&bed, plan).mean < 1e-12);
    assert_true(one > 1e-4);
    stp_plan_destroy(&plan);
    bed_release(&bed);
}

/* What is sampled stands for all: within four standard errors of the whole. */
static void test_sampling(void **state)
{
    struct bed whole = bed_make(5, 2000, 10000), part = bed_make(5, 2000, 40);
    struct stp_plan *plan = plan_for(&whole, STP_METHOD_DEFERRED, STP_PAYLOAD_ID, STP_VORONOI_SLAB);
    struct probe_error all = judge_of(&whole, plan), some = judge_of(&part, plan);
    assert_true(part.probe.cells == 40 || part.probe.cells == 39);
    assert_true(all.spread == 0 && some.spread > 0);
    assert_true(fabs(some.mean - all.mean) < 4 * some.spread);
    stp_plan_destroy(&plan);
    bed_release(&whole);
    bed_release(&part);
}

/* Parts have no cell in common, leave out none, and joined they are the whole. */
static void test_parts(void **state)
{
    struct bed whole = bed_make(5, 2000, 10000);
    struct stp_plan *plan = plan_for(&whole, STP_METHOD_DEFERRED, STP_PAYLOAD_ID, STP_VORONOI_SLAB);
    struct probe_error all = judge_of(&whole, plan), sum = { 0 };
    uint8_t *seen = calloc(whole.probe.view.width * whole.probe.view.height, 1);
    struct bed bed = whole;
    unsigned cells = 0, parts = 1;
    double spread = INFINITY;
    for (unsigned k = 0; k < parts; k++) {
        bed.probe = probe_of(&whole, 40, k);
        parts = bed.probe.parts;
        for (size_t i = 0; i < bed.probe.pixels; i++) {
            size_t at = pixel_of(&bed, i);
            assert_true(at == SIZE_MAX || !seen[at]++);
        }
        struct probe_error error = judge_of(&bed, plan);
        if (k)
            probe_error_join(&sum, &error);
        else
            sum = error;
        assert_true(fabs(sum.mean - all.mean) <= 5 * sum.spread + 1e-15);
        cells += bed.probe.cells;
        spread = sum.spread;
        probe_release(&bed.probe);
    }
    assert_true(parts > 4 && cells == whole.probe.cells && spread == 0);
    assert_int_equal(sum.pixels, all.pixels);
    assert_true(fabs(sum.mean - all.mean) < 1e-12);
    assert_true(sum.rounding > 0 && sum.rounding < 0.1 * sum.mean);
    free(seen);
    stp_plan_destroy(&plan);
    bed_release(&whole);
}

/* Where fragments would be too many cells are fewer, to a least number, and parts still make up the
 * whole. */
static void test_fragments(void **state)
{
    struct bed whole = bed_make(5, 2000, 10000);
    const size_t all = whole.probe.first[whole.probe.pixels];
    static const double shares[] = { 0.5, 0.25, 1e-6 };
    for (unsigned i = 0; i < 3; i++) {
        struct probe_sample sample = { .cells = 10000, .fragments = shares[i] * all };
        size_t fragments = 0;
        unsigned cells = 0, parts = 1;
        for (; sample.part < parts; sample.part++) {
            struct probe probe = probe_with(&whole, &sample);
            size_t here = probe.first[probe.pixels];
            parts = probe.parts;
            assert_true(here < 1.3 * sample.fragments || probe.cells <= PROBE_LEAST_CELLS);
            cells += probe.cells;
            fragments += here;
            probe_release(&probe);
        }
        assert_true(cells == whole.probe.cells && fragments == all);
        assert_true(parts >= 1 / shares[i] || parts == (cells + 63) / PROBE_LEAST_CELLS);
    }
    bed_release(&whole);
}

/* What fragments are made of, rounded to floats: the picture is not farther from the exact one than
 * is said. */
static void test_rounding(void **state)
{
    for (uint32_t seed = 1; seed <= 5; seed++) {
        struct bed bed = bed_make(seed, 1500, 10000);
        struct stp_plan *plan =
            plan_for(&bed, STP_METHOD_TWO_PASS, STP_PAYLOAD_AUTO, STP_VORONOI_DEFAULT);
        struct probe_error error = judge_of(&bed, plan), rounded;
        for (size_t i = 0; i < bed.probe.first[bed.probe.pixels]; i++) {
            struct probe_fragment *f = &bed.probe.fragment[i];
            f->depth = (double)(float)f->depth;
            f->weight = (double)(float)f->weight;
            f->normal = v3((double)(float)f->normal.x, (double)(float)f->normal.y,
                           (double)(float)f->normal.z);
        }
        rounded = judge_of(&bed, plan);
        assert_true(error.mean < 1e-12 && rounded.mean > 1e-10);
        assert_true(rounded.mean <= error.rounding);
        if (!(error.rounding > 1e-8 && error.rounding < 1e-4))
            fail_msg("%g", error.rounding);
        stp_plan_destroy(&plan);
        bed_release(&bed);
    }
}

/* How many of so many happen: by inversion. */
static double poisson(double expected, uint32_t *state)
{
    double u = uniform(state), exactly = exp(-expected), count = 0;
    for (double sum = exactly; sum < u && count < 1000; sum += exactly)
        exactly *= expected / ++count;
    return count;
}

#define COVERED 5e5
#define SAMPLED 4096.0
#define TIMES   1024.0
#define CHANGE  0.8

/* Of pictures in which this many pixels are expected to change sides, the share whose error is
 * above what a sample says of them, with those that it cannot see and without. */
static void draw_lots(double expected, double beyond[2])
{
    const int trials = 20000;
    uint32_t state = (uint32_t)(1000 * expected) + 1;
    beyond[0] = beyond[1] = 0;
    for (int i = 0; i < trials; i++) {
        double seen = poisson(expected * SAMPLED * TIMES / COVERED, &state);
        const struct probe_tally tally = { .cells = SAMPLED / 16,
                                           .all_cells = COVERED / 16,
                                           .n = SAMPLED,
                                           .growth = seen * CHANGE / TIMES,
                                           .growth2 = seen * CHANGE * CHANGE / TIMES,
                                           .tossed = SAMPLED * TIMES,
                                           .bright = { CHANGE, CHANGE, CHANGE } };
        double error = poisson(expected, &state) * CHANGE / COVERED;
        double said = probe_rounding(&tally);
        beyond[0] += error > said;
        beyond[1] += error > said + probe_flips(&tally);
    }
    beyond[0] /= trials;
    beyond[1] /= trials;
}

/* However often pixels change sides, hardly a picture has more of them than is said; the roundings
 * that were seen alone miss what happens in one of ten pictures. */
static void test_flips(void **state)
{
    static const double expected[] = { 0.001, 0.01, 0.03, 0.1, 0.2, 0.4, 1, 3, 10, 30 };
    double worst = 0;
    for (unsigned i = 0; i < sizeof expected / sizeof *expected; i++) {
        double beyond[2];
        draw_lots(expected[i], beyond);
        worst = fmax(worst, beyond[0]);
        if (beyond[1] > 0.01)
            fail_msg("%g expected: %g of the pictures beyond", expected[i], beyond[1]);
    }
    assert_true(worst > 0.03);
}

/* Where every pixel is seen none is unseen; what little is left counts less than the much. */
static void test_flips_left(void **state)
{
    struct probe_tally tally = { .cells = 256, .all_cells = 256, .n = 4096, .tossed = 4096 };
    tally.bright[0] = 3;
    assert_true(probe_flips(&tally) == 0);
    tally.all_cells = 257; /* 3 times 16 of 4096 */
    assert_true(fabs(probe_flips(&tally) * 4096 * 257 / 256 - 1) < 1e-9);
    for (double all = 512; all < 1e9; all *= 8) {
        tally.all_cells = all;
        double most = probe_flips(&tally) * all * 16, expected = 3 * (all * 16 - 4096) / 4096;
        assert_true(most >= expected && most <= expected + 3 * sqrt(expected) + 1);
    }
    tally.tossed = 0; /* nothing was perturbed */
    assert_true(probe_flips(&tally) == 0);
}

static void ignore(void *user, enum stp_log_level level, const char *line)
{
}

static void test_no_memory(void **state)
{
    struct bed bed = bed_make(6, 100, 10);
    struct stp_env env = { .threads = 1, .log = ignore };
    struct stp_plan *plan = plan_for(&bed, STP_METHOD_EXACT, STP_PAYLOAD_ID, STP_VORONOI_DEFAULT);
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        struct probe probe = { 0 };
        struct probe_error error;
        struct stp_group_params group = { .overlap = 0.6 };
        struct stp_grouping facts;
        const struct probe_sample sample = { .cells = 10, .alone = true };
        uint8_t *groups = NULL;
        mem_fail_at(n);
        result =
            probe_make(&env, bed.scene, &bed.camera, &bed.params, &bed.survey, &sample, &probe);
        if (result == STP_OK)
            result = probe_judge(&env, &probe, plan, plan_exact_offer.keep, NULL, false, &error);
        if (result == STP_OK)
            result = probe_group(&env, &probe, &group, &groups, &facts);
        mem_fail_at(0);
        assert_true(result == STP_OK || result == STP_ERROR_MEMORY);
        mem_free(groups);
        probe_release(&probe);
    }
    stp_plan_destroy(&plan);
    bed_release(&bed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_truth),       cmocka_unit_test(test_transparent_truth),
        cmocka_unit_test(test_phong_truth), cmocka_unit_test(test_exact_methods),
        cmocka_unit_test(test_winners),     cmocka_unit_test(test_groups),
        cmocka_unit_test(test_sampling),    cmocka_unit_test(test_parts),
        cmocka_unit_test(test_rounding),    cmocka_unit_test(test_no_memory),
        cmocka_unit_test(test_flips),       cmocka_unit_test(test_flips_left),
        cmocka_unit_test(test_fragments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
