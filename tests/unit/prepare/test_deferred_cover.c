/* Groups that each cover the surface, against areas sampled by other code. */
#include "base/memory.h"
#include "overlap_clouds.h"
#include "prepare/prepare.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

static void count_lines(void *user, enum stp_log_level level, const char *line)
{
    unsigned *lines = user;
    assert_non_null(line);
    *lines += level == STP_LOG_ERROR;
}

static struct stp_scene scene_of(struct splats splats, double epsilon)
{
    struct stp_scene scene = { .prepared = true, .splats = splats, .object_count = 2 };
    scene.objects = calloc(2, sizeof *scene.objects);
    scene.objects[0].epsilon = scene.objects[1].epsilon = epsilon;
    return scene;
}

static void scene_free(struct stp_scene *scene)
{
    free(scene->objects);
    cover_groups_release(&scene->cover);
    cloud_free(&scene->splats);
}

/* Discs of up to 3:1 in radius over the unit square, in rows so that neighbours are near in order.
 */
static struct stp_scene sheet(size_t count, double density, uint64_t seed)
{
    struct dice d = { seed };
    struct splats s = cloud_make(count);
    double mean = sqrt(density / ((double)count * M_PI));
    for (size_t i = 0; i < count; i++) {
        s.position[i][0] = uniform(&d);
        s.position[i][1] = ((double)i + 0.5) / (double)count;
        s.normal[i][2] = 1;
        s.radius[i] = (float)(mean * (0.5 + uniform(&d)));
    }
    return scene_of(s, mean);
}

static struct stp_scene sphere(size_t count)
{
    struct dice d = { 11 };
    struct splats s = cloud_make(count);
    for (size_t i = 0; i < count; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)count, a = 2 * M_PI * uniform(&d);
        double r = sqrt(1 - z * z), p[3] = { r * cos(a), r * sin(a), z };
        for (int k = 0; k < 3; k++) {
            s.position[i][k] = p[k];
            s.normal[i][k] = (float)p[k];
        }
        s.radius[i] = (float)(4 / sqrt((double)count));
    }
    return scene_of(s, 4 / sqrt((double)count));
}

static uint64_t *memberships(const struct stp_scene *scene)
{
    uint64_t *in = calloc(scene->splats.count, sizeof *in);
    for (unsigned k = 0; k < scene->cover.groups; k++)
        for (uint32_t i = scene->cover.first[k]; i < scene->cover.first[k + 1]; i++) {
            assert_true(scene->cover.node[i].id < scene->splats.count);
            assert_false(in[scene->cover.node[i].id] >> k & 1);
            in[scene->cover.node[i].id] |= (uint64_t)1 << k;
        }
    return in;
}

/* Which groups, and bit 63 any disc, cover a place of the sheet. */
static uint64_t covering(const struct stp_scene *scene, const uint64_t *in, double x, double y)
{
    uint64_t bits = 0;
    double largest = 1;
    for (unsigned k = 0; k < scene->cover.groups; k++)
        largest = fmax(largest, scene->cover.factor[k]);
    for (size_t i = 0; i < scene->splats.count; i++) {
        double dx = scene->splats.position[i][0] - x, dy = scene->splats.position[i][1] - y;
        double r = scene->splats.radius[i], d2 = dx * dx + dy * dy;
        if (d2 > r * r * largest * largest)
            continue;
        bits |= d2 <= r * r ? (uint64_t)1 << 63 : 0;
        for (unsigned k = 0; k < scene->cover.groups; k++) {
            double e = r * scene->cover.factor[k];
            if (in[i] >> k & 1 && d2 <= e * e)
                bits |= (uint64_t)1 << k;
        }
    }
    return bits;
}

/* Shares of the union, by darts at the sheet and around it. */
static void throw_darts(const struct stp_scene *scene, double *share)
{
    struct dice d = { 77 };
    uint64_t *in = memberships(scene);
    double all = 0;
    memset(share, 0, STP_MAX_GROUPS * sizeof *share);
    for (unsigned n = 0; n < 40000; n++) {
        uint64_t bits = covering(scene, in, 1.2 * uniform(&d) - 0.1, 1.2 * uniform(&d) - 0.1);
        all += bits >> 63;
        for (unsigned k = 0; bits >> 63 && k < scene->cover.groups; k++)
            share[k] += bits >> k & 1;
    }
    for (unsigned k = 0; k < scene->cover.groups; k++)
        share[k] /= all;
    free(in);
}

/* What is reported is what darts find: within three standard errors of the darts, and our own. */
static void check_shares(const struct stp_scene *scene)
{
    const struct stp_cover *facts = &scene->facts.cover;
    double share[STP_MAX_GROUPS];
    throw_darts(scene, share);
    for (unsigned k = 0; k < facts->groups; k++) {
        double error = 3 * sqrt(share[k] * (1 - share[k]) / 25000) + 8 * facts->error;
        assert_true(facts->coverage[k] <= share[k] + error + 1e-3);
        assert_true(facts->coverage[k] >= share[k] - error - 1e-3);
    }
}

static void duplicates_cover(void **state)
{
    struct stp_scene scene = sheet(1500, 4, 3);
    struct stp_cover_params p = { .groups = 4 };
    assert_int_equal(stp_scene_cover(NULL, &scene, &p), STP_OK);
    const struct stp_cover *facts = &scene.facts.cover;
    assert_int_equal(facts->groups, 4);
    assert_int_equal(facts->extend, STP_EXTEND_BOTH);
    assert_int_equal(scene.cover.first[4], facts->members);
    for (unsigned k = 0; k < 4; k++) {
        assert_true(facts->before[k] < facts->coverage[k]);
        assert_true(facts->coverage[k] >= 0.978);
    }
    assert_true(facts->error > 0 && facts->error < 2e-3);
    check_shares(&scene);
    scene_free(&scene);
}

/* The default extension duplicates at most 45 % of the splats (stp_extend): of a closed surface,
 * four discs at a place. */
static void few_duplicates_on_a_sphere(void **state)
{
    struct stp_scene scene = sphere(20000);
    struct stp_cover_params p = { .groups = 4 };
    assert_int_equal(stp_scene_cover(NULL, &scene, &p), STP_OK);
    const struct stp_cover *facts = &scene.facts.cover;
    assert_true(facts->duplicates > 0.05 && facts->duplicates <= 0.4501);
    for (unsigned k = 0; k < 4; k++)
        assert_true(facts->coverage[k] >= 0.978 && facts->factor[k] < 1.1);
    scene_free(&scene);
}

static void as_if_nothing_is_asked(void **state)
{
    struct stp_scene scene = sphere(20000);
    assert_int_equal(stp_scene_cover(NULL, &scene, NULL), STP_OK);
    const struct stp_cover *facts = &scene.facts.cover;
    assert_int_equal(facts->groups, STP_DEFAULT_COVER_GROUPS);
    assert_int_equal(facts->extend, STP_EXTEND_BOTH);
    assert_true(facts->duplicates <= 0.4501);
    for (unsigned k = 0; k < facts->groups; k++)
        assert_true(facts->coverage[k] >= 0.978 && facts->factor[k] < 1.1);
    scene_free(&scene);
}

static void radii_cover(void **state)
{
    struct stp_scene scene = sheet(1500, 12, 4);
    struct stp_cover_params p = { .groups = 8 };
    assert_int_equal(stp_scene_cover(NULL, &scene, &p), STP_OK);
    const struct stp_cover *facts = &scene.facts.cover;
    assert_int_equal(facts->extend, STP_EXTEND_ENLARGE);
    assert_true(facts->duplicates == 0);
    for (unsigned k = 0; k < 8; k++) {
        assert_true(facts->factor[k] > 1 && facts->factor[k] <= 2);
        assert_true(facts->coverage[k] > facts->before[k]);
        assert_true(facts->coverage[k] > 0.975);
        assert_true(facts->coverage[k] < 0.99);
    }
    check_shares(&scene);
    scene_free(&scene);
}

/* Too thin for any factor: stops at the largest, and says what it reached. */
static void radii_do_not_run_away(void **state)
{
    struct stp_scene scene = sheet(600, 0.8, 5);
    struct stp_cover_params p = { .groups = 16, .extend = STP_EXTEND_ENLARGE };
    assert_int_equal(stp_scene_cover(NULL, &scene, &p), STP_OK);
    for (unsigned k = 0; k < 16; k++) {
        assert_true(scene.facts.cover.factor[k] == 2);
        assert_true(scene.facts.cover.coverage[k] < 0.9);
    }
    check_shares(&scene);
    scene_free(&scene);
}

/* Discs that nothing overlaps must be in every group. */
static void apart(void **state)
{
    struct splats s = cloud_make(60);
    for (size_t i = 0; i < 60; i++) {
        s.position[i][0] = 3 * (double)i;
        s.normal[i][2] = 1;
    }
    struct stp_scene scene = scene_of(s, 1);
    struct stp_cover_params p = { .groups = 3, .coverage = 1 };
    assert_int_equal(stp_scene_cover(NULL, &scene, &p), STP_OK);
    assert_int_equal(scene.facts.cover.members, 180);
    assert_true(scene.facts.cover.duplicates == 2);
    for (unsigned k = 0; k < 3; k++)
        assert_true(scene.facts.cover.coverage[k] == 1);
    scene_free(&scene);
}

/* A second sheet beyond epsilon is a layer of its own: neither stands for the other. */
static void layers_are_apart(void **state)
{
    for (int far = 0; far < 2; far++) {
        struct splats s = cloud_make(2);
        s.normal[0][2] = s.normal[1][2] = 1;
        s.position[1][2] = far ? 0.6 : 0.4;
        struct stp_scene scene = scene_of(s, 0.5);
        struct stp_cover_params p = { .groups = 2, .coverage = 1 };
        assert_int_equal(stp_scene_cover(NULL, &scene, &p), STP_OK);
        assert_int_equal(scene.facts.cover.members, far ? 4 : 2);
        scene_free(&scene);
    }
}

static void one_group_holds_all(void **state)
{
    struct stp_scene scene = sheet(100, 4, 6);
    memcpy(scene.splats.position[50], scene.splats.position[49], sizeof *scene.splats.position);
    scene.splats.radius[50] = scene.splats.radius[49];
    scene.splats.opacity[7] = 0;
    assert_int_equal(stp_scene_cover(NULL, &scene, &(struct stp_cover_params){ .groups = 1 }),
                     STP_OK);
    assert_int_equal(scene.facts.cover.members, 98);
    assert_true(scene.facts.cover.coverage[0] == 1 && scene.facts.cover.duplicates == 0);
    scene_free(&scene);
}

static void nothing_is_seen(void **state)
{
    struct stp_scene scene = sheet(20, 4, 7);
    for (size_t i = 0; i < 20; i++)
        scene.splats.opacity[i] = 0;
    assert_int_equal(stp_scene_cover(NULL, &scene, NULL), STP_OK);
    assert_int_equal(scene.facts.cover.members, 0);
    assert_true(scene.facts.cover.duplicates == 0);
    scene_free(&scene);
}

/* Any cloud: every splat in a group, shares in [0, 1], the same for any number of threads. */
static void check_any(struct stp_scene *scene, const struct stp_cover_params *p)
{
    struct stp_cover facts;
    uint64_t *first = NULL;
    for (unsigned threads = 1; threads <= 3; threads += 2) {
        struct stp_env env = { .threads = threads };
        assert_int_equal(stp_scene_cover(&env, scene, p), STP_OK);
        uint64_t *in = memberships(scene);
        for (size_t i = 0; i < scene->splats.count; i++)
            assert_true(in[i] != 0 || splats_equal(&scene->splats, i - 1, i));
        if (first) {
            assert_memory_equal(in, first, scene->splats.count * sizeof *in);
            facts.milliseconds = scene->facts.cover.milliseconds;
            assert_memory_equal(&scene->facts.cover, &facts, sizeof facts);
        }
        facts = scene->facts.cover;
        free(first);
        first = in;
    }
    free(first);
    for (unsigned k = 0; k < facts.groups; k++)
        assert_true(facts.coverage[k] >= facts.before[k] - 1e-12 && facts.coverage[k] <= 1 + 1e-12);
}

static void any_cloud(void **state)
{
    const struct stp_cover_params params[] = { { 0 },
                                               { .groups = 7 },
                                               { .groups = 64, .extend = STP_EXTEND_DUPLICATE } };
    for (enum cloud_kind kind = 0; kind < CLOUD_KINDS; kind++)
        for (unsigned p = 0; p < 3; p++) {
            struct stp_scene scene = scene_of(cloud_random(kind, 400, 20 + (uint64_t)kind), 0.7);
            check_any(&scene, &params[p]);
            scene_free(&scene);
        }
    struct stp_scene one = scene_of(cloud_make(1), 1);
    check_any(&one, NULL);
    scene_free(&one);
}

/* A heap of very many, and one disc a thousand times too large. */
static void heaps_and_outliers(void **state)
{
    struct splats s = cloud_random(CLOUD_COINCIDENT, 20000, 3);
    for (size_t i = 10000; i < 20000; i++)
        s.position[i][0] = (double)i;
    s.radius[15000] = 1000;
    struct stp_scene scene = scene_of(s, 1);
    assert_int_equal(stp_scene_cover(NULL, &scene, NULL), STP_OK);
    assert_true(scene.facts.cover.members >= 20000);
    scene_free(&scene);
}

static void refuses_what_means_nothing(void **state)
{
    struct stp_scene scene = sheet(10, 4, 8);
    unsigned lines = 0;
    struct stp_env env = { .log = count_lines, .user = &lines };
    const struct stp_cover_params wrong[] = {
        { .groups = 65 },    { .coverage = -1 }, { .coverage = 1.1 },
        { .coverage = NAN }, { .extend = 4 },
    };
    for (unsigned i = 0; i < 5; i++)
        assert_int_equal(stp_scene_cover(&env, &scene, &wrong[i]), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_cover(&env, NULL, NULL), STP_ERROR_ARGUMENT);
    scene.prepared = false;
    assert_int_equal(stp_scene_cover(&env, &scene, NULL), STP_ERROR_ARGUMENT);
    assert_int_equal(lines, 7);
    assert_int_equal(scene.cover.groups, 0);
    scene_free(&scene);
}

static void every_allocation_may_fail(void **state)
{
    const struct stp_cover_params params[] = { { 0 }, { .groups = 5 } };
    struct stp_scene scene = sheet(300, 4, 9);
    unsigned lines = 0;
    struct stp_env env = { .threads = 1, .log = count_lines, .user = &lines };
    for (unsigned p = 0; p < 2; p++) {
        assert_int_equal(stp_scene_cover(&env, &scene, NULL), STP_OK);
        const struct bsp_node *node = scene.cover.node;
        struct stp_cover before = scene.facts.cover;
        unsigned long n = 0, refused = 0;
        for (bool failed = true; failed;) {
            mem_fail_at(++n);
            lines = 0;
            enum stp_result result = stp_scene_cover(&env, &scene, &params[p]);
            failed = mem_count() >= n;
            mem_fail_at(0);
            if (result == STP_OK) { /* giving memory back may fail unseen; start again */
                node = scene.cover.node;
                before = scene.facts.cover;
                continue;
            }
            refused++;
            assert_int_equal(result, STP_ERROR_MEMORY);
            assert_int_equal(lines, 1);
            assert_ptr_equal(scene.cover.node, node);
            assert_memory_equal(&scene.facts.cover, &before, sizeof before);
        }
        assert_true(refused > 12);
    }
    scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(duplicates_cover),          cmocka_unit_test(few_duplicates_on_a_sphere),
        cmocka_unit_test(as_if_nothing_is_asked),    cmocka_unit_test(radii_cover),
        cmocka_unit_test(radii_do_not_run_away),     cmocka_unit_test(apart),
        cmocka_unit_test(layers_are_apart),          cmocka_unit_test(one_group_holds_all),
        cmocka_unit_test(nothing_is_seen),           cmocka_unit_test(any_cloud),
        cmocka_unit_test(heaps_and_outliers),        cmocka_unit_test(refuses_what_means_nothing),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
