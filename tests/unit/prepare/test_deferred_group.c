/* Groups: bounds kept, heaps survived, nothing left to chance. */
#include "base/memory.h"
#include "overlap_clouds.h"
#include "prepare/prepare.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

struct heard {
    unsigned errors, warnings;
};

static void hear(void *user, enum stp_log_level level, const char *line)
{
    struct heard *heard = user;
    assert_non_null(line);
    heard->errors += level == STP_LOG_ERROR;
    heard->warnings += level == STP_LOG_WARNING;
}

/* Splats on a sphere, each about 16 neighbours. */
static struct stp_scene sphere(size_t count)
{
    struct stp_scene scene = { .prepared = true, .splats = cloud_make(count) };
    for (size_t i = 0; i < count; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)count, a = (double)i * 2.399963229728653;
        double r = sqrt(1 - z * z), p[3] = { r * cos(a), r * sin(a), z };
        for (int k = 0; k < 3; k++) {
            scene.splats.position[i][k] = p[k];
            scene.splats.normal[i][k] = (float)p[k];
        }
        scene.splats.radius[i] = (float)(4 / sqrt((double)count));
    }
    return scene;
}

static void scene_free(struct stp_scene *scene)
{
    mem_free(scene->splats.group);
    scene->splats.group = NULL;
    cloud_free(&scene->splats);
}

/* No two splats of a group overlap, at the c and relaxation that were used. */
static void check_proper(const struct stp_scene *scene)
{
    const struct splats *s = &scene->splats;
    const struct stp_grouping *g = &scene->facts.grouping;
    for (size_t i = 0; i < s->count; i++) {
        assert_true(s->group[i] < g->groups);
        for (size_t j = 0; j < i; j++) {
            double d2 = 0, t = g->overlap * ((double)s->radius[i] + s->radius[j]);
            for (int k = 0; k < 3; k++)
                d2 += pow(s->position[i][k] - s->position[j][k], 2);
            assert_true(s->group[i] != s->group[j] || d2 >= t * t ||
                        overlap_relaxed(s, g->relax, i, j));
        }
    }
}

static void defaults(void **state)
{
    struct stp_scene scene = sphere(3000);
    struct heard heard = { 0 };
    struct stp_env env = { .log = hear, .user = &heard };
    assert_int_equal(stp_scene_group(&env, &scene, NULL), STP_OK);
    const struct stp_grouping *g = &scene.facts.grouping;
    assert_true(g->overlap == STP_DEFAULT_OVERLAP && g->relax == STP_RELAX_OPPOSED);
    assert_in_range(g->groups, 5, g->max_degree + 1);
    assert_true(g->avg_degree > 8 && g->avg_degree < 16 && g->milliseconds > 0);
    assert_true(heard.errors + heard.warnings == 0 && g->crowded == 0);
    check_proper(&scene);
    scene_free(&scene);
}

static void lowers_overlap_for_few_groups(void **state)
{
    for (unsigned most = 2; most <= 8; most += 2) {
        struct stp_scene scene = sphere(2000);
        struct heard heard = { 0 };
        struct stp_env env = { .log = hear, .user = &heard };
        struct stp_group_params p = { 1, STP_RELAX_NONE, most };
        assert_int_equal(stp_scene_group(&env, &scene, &p), STP_OK);
        double used = scene.facts.grouping.overlap;
        assert_in_range(scene.facts.grouping.groups, 1, most);
        assert_true(used < 1 && used >= GROUP_MIN_OVERLAP && scene.facts.grouping.crowded == 0);
        assert_int_equal(heard.warnings, 1);
        check_proper(&scene);
        /* One step up is too much, and the c that was found is not lowered again. */
        p = (struct stp_group_params){ used + (1 - GROUP_MIN_OVERLAP) / 64, STP_RELAX_NONE, 0 };
        assert_int_equal(stp_scene_group(&env, &scene, &p), STP_OK);
        assert_true(scene.facts.grouping.groups > most);
        p = (struct stp_group_params){ used, STP_RELAX_NONE, most };
        assert_int_equal(stp_scene_group(&env, &scene, &p), STP_OK);
        assert_true(scene.facts.grouping.overlap == used);
        assert_int_equal(heard.warnings, 1);
        scene_free(&scene);
    }
}

/* Radii of seven spacings, some 290 neighbours each: the graph is dropped unbuilt, and a lower c
 * found. */
static void lowers_overlap_for_huge_radii(void **state)
{
    struct stp_scene scene = sphere(20000);
    struct heard heard = { 0 };
    struct stp_env env = { .log = hear, .user = &heard };
    for (size_t i = 0; i < scene.splats.count; i++)
        scene.splats.radius[i] *= 6;
    struct stp_group_params p = { 1, 0, 0 };
    assert_int_equal(stp_scene_group(&env, &scene, &p), STP_OK);
    assert_in_range(scene.facts.grouping.groups, 32, 64);
    assert_true(scene.facts.grouping.overlap < 0.7 && scene.facts.grouping.crowded == 0);
    assert_int_equal(heard.warnings, 1);
    scene_free(&scene);
}

/* A heap in one place must not spoil c for the rest. */
static void a_heap_stays_local(void **state)
{
    struct stp_scene scene = sphere(2000);
    struct heard heard = { 0 };
    struct stp_env env = { .log = hear, .user = &heard };
    struct dice d = { 12 };
    for (size_t i = 1000; i < 1300; i++) {
        memcpy(scene.splats.position[i], scene.splats.position[1000], 3 * sizeof(double));
        memcpy(scene.splats.normal[i], scene.splats.normal[1000], 3 * sizeof(float));
        scene.splats.color[i][0] = (float)uniform(&d);
    }
    assert_int_equal(stp_scene_group(&env, &scene, NULL), STP_OK);
    const struct stp_grouping *g = &scene.facts.grouping;
    assert_true(g->overlap == STP_DEFAULT_OVERLAP);
    assert_int_equal(g->crowded, 300 - 32);
    assert_int_equal(heard.warnings, 1);
    assert_in_range(g->groups, 32, 64);
    scene_free(&scene);
}

static void duplicates_share_a_group(void **state)
{
    struct stp_scene scene = { .prepared = true, .splats = cloud_make(100000) };
    struct splats *s = &scene.splats;
    assert_int_equal(stp_scene_group(NULL, &scene, NULL), STP_OK);
    assert_int_equal(scene.facts.grouping.groups, 1);
    assert_int_equal(scene.facts.grouping.max_degree, 0);
    for (size_t i = 40000; i < s->count; i++)
        s->color[i][0] = i < 70000 ? 0.25f : 0.5f;
    assert_int_equal(stp_scene_group(NULL, &scene, NULL), STP_OK);
    assert_int_equal(scene.facts.grouping.groups, 3);
    assert_int_equal(scene.facts.grouping.crowded, 0);
    for (size_t i = 0; i < s->count; i++)
        assert_int_equal(s->group[i], i < 40000 ? 0 : i < 70000 ? 1 : 2);
    scene_free(&scene);
}

/* All in one place, no two alike: ends, and uses every group evenly. */
static void coincident_but_different(void **state)
{
    enum { COUNT = 40000 };
    for (int kind = 0; kind < 3; kind++) {
        struct stp_scene scene = { .prepared = true };
        struct heard heard = { 0 };
        struct stp_env env = { .log = hear, .user = &heard };
        size_t share[32] = { 0 };
        scene.splats = cloud_random(CLOUD_COINCIDENT, COUNT, 6);
        for (size_t i = 0; kind && i < COUNT; i++)
            scene.splats.radius[i] = kind == 1 ? 1 + (float)i * 1e-6f : 2 - (float)i * 1e-6f;
        struct stp_group_params p = { .relax = STP_RELAX_NONE };
        assert_int_equal(stp_scene_group(&env, &scene, &p), STP_OK);
        assert_int_equal(scene.facts.grouping.groups, 32);
        assert_int_equal(scene.facts.grouping.crowded, COUNT - 32);
        assert_true(heard.errors == 0 && heard.warnings > 0);
        for (size_t i = 0; i < COUNT; i++)
            share[scene.splats.group[i]]++;
        for (size_t k = 0; k < 32; k++)
            assert_in_range(share[k], COUNT / 32 - 1, COUNT / 32 + 1);
        scene_free(&scene);
    }
}

static void threads_make_no_difference(void **state)
{
    struct stp_scene scene = sphere(20000);
    uint8_t *first = malloc(scene.splats.count);
    for (unsigned most = 0; most <= 6; most += 6) {
        struct heard heard = { 0 };
        struct stp_env one = { .threads = 1, .log = hear, .user = &heard }, many = one;
        struct stp_group_params p = { 0.9, 0, most };
        many.threads = 4;
        assert_int_equal(stp_scene_group(&one, &scene, &p), STP_OK);
        memcpy(first, scene.splats.group, scene.splats.count);
        double overlap = scene.facts.grouping.overlap;
        assert_int_equal(stp_scene_group(&many, &scene, &p), STP_OK);
        assert_true(overlap == scene.facts.grouping.overlap);
        assert_memory_equal(first, scene.splats.group, scene.splats.count);
    }
    free(first);
    scene_free(&scene);
}

static void refuses_what_means_nothing(void **state)
{
    struct stp_scene scene = sphere(10);
    struct heard heard = { 0 };
    struct stp_env env = { .log = hear, .user = &heard };
    const struct stp_group_params wrong[] = {
        { 1.5, 0, 0 }, { -0.1, 0, 0 }, { NAN, 0, 0 }, { 0.5, 8, 0 }, { 0.5, 5, 0 }, { 0.5, 0, 65 },
    };
    for (unsigned i = 0; i < 6; i++) {
        assert_int_equal(stp_scene_group(&env, &scene, &wrong[i]), STP_ERROR_ARGUMENT);
        assert_int_equal(heard.errors, i + 1);
    }
    assert_int_equal(stp_scene_group(&env, NULL, NULL), STP_ERROR_ARGUMENT);
    scene.prepared = false;
    assert_int_equal(stp_scene_group(&env, &scene, NULL), STP_ERROR_ARGUMENT);
    assert_int_equal(heard.errors, 8);
    assert_null(scene.splats.group);
    scene_free(&scene);
}

/* The old grouping stays whole, whatever fails on the way, heaps and bisection included. */
static void every_allocation_may_fail(void **state)
{
    struct stp_scene scene = sphere(300);
    struct heard heard = { 0 };
    struct stp_env env = { .threads = 2, .log = hear, .user = &heard };
    for (size_t i = 100; i < 120; i++)
        memcpy(scene.splats.position[i], scene.splats.position[100], 3 * sizeof(double));
    struct stp_group_params p = { 1, 0, 4 };
    assert_int_equal(stp_scene_group(&env, &scene, &(struct stp_group_params){ .overlap = 0.3 }),
                     STP_OK);
    const uint8_t *group = scene.splats.group;
    struct stp_grouping before = scene.facts.grouping;
    unsigned long n = 0, refused = 0;
    for (bool failed = true; failed; refused += failed) {
        mem_fail_at(++n);
        heard = (struct heard){ 0 };
        enum stp_result result = stp_scene_group(&env, &scene, &p);
        failed = mem_count() >= n;
        mem_fail_at(0);
        if (result == STP_OK) { /* giving memory back may fail unseen; start again */
            assert_int_equal(heard.errors, 0);
            group = scene.splats.group;
            before = scene.facts.grouping;
            continue;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_int_equal(heard.errors, 1);
        assert_ptr_equal(scene.splats.group, group);
        assert_memory_equal(&scene.facts.grouping, &before, sizeof before);
    }
    assert_true(refused > 30);
    scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults),
        cmocka_unit_test(lowers_overlap_for_few_groups),
        cmocka_unit_test(lowers_overlap_for_huge_radii),
        cmocka_unit_test(a_heap_stays_local),
        cmocka_unit_test(duplicates_share_a_group),
        cmocka_unit_test(coincident_but_different),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(refuses_what_means_nothing),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
