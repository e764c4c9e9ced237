/* What a sweep is made of: the list of configurations, and one scene in several groupings. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "base/memory.h"
#include "scene/scene.h"
#include "study/study.h"

static bool same(const struct study_config *a, const struct study_config *b)
{
    return a->method == b->method && a->path == b->path &&
           (a->payload == b->payload || a->payload == STP_PAYLOAD_AUTO) &&
           a->voronoi == b->voronoi && a->overlap == b->overlap &&
           a->epsilon_scale == b->epsilon_scale && a->transparency == b->transparency &&
           a->peel_layers == b->peel_layers && a->merge == b->merge && a->axis_h == b->axis_h;
}

/* None twice, a baseline among them, and quick is a part of the whole. */
static unsigned check_configs(const struct stp_facts *facts,
                              struct study_config all[STUDY_MAX_CONFIGS])
{
    struct study_config quick[STUDY_MAX_CONFIGS];
    unsigned count = study_configs(facts, false, all), few = study_configs(facts, true, quick);
    bool baseline = false;
    assert_true(count < STUDY_MAX_CONFIGS && count < REPORT_MAX_ROWS);
    assert_true(few < count);
    for (unsigned i = 0; i < count; i++) {
        struct report_row row = { 0 };
        study_describe(&all[i], &row);
        baseline |= row.is_baseline;
        for (unsigned k = 0; k < i; k++)
            assert_false(same(&all[i], &all[k]));
    }
    assert_true(baseline);
    for (unsigned i = 0; i < few; i++) {
        bool found = false;
        for (unsigned k = 0; k < count; k++)
            found |= same(&quick[i], &all[k]);
        assert_true(found);
    }
    return count;
}

static void configurations(void **state)
{
    struct study_config all[STUDY_MAX_CONFIGS];
    const struct stp_facts facts = { 0 };
    unsigned count = check_configs(&facts, all), deferred = 0, baseline = 0;
    assert_int_equal(count, 2 + 2 + 2 + 1 + 5 * 9);
    for (unsigned i = 0; i < count; i++) {
        deferred += all[i].method == STP_METHOD_DEFERRED;
        baseline += all[i].method == STP_METHOD_TWO_PASS;
        assert_int_equal(all[i].overlap > 0, all[i].method == STP_METHOD_DEFERRED);
        assert_int_equal(all[i].transparency, STP_TRANSPARENCY_AUTO);
    }
    struct study_config quick[STUDY_MAX_CONFIGS];
    assert_true(study_configs(&facts, true, quick) < count / 2);
    assert_int_equal(deferred, 45);
    assert_int_equal(baseline, 2);
}

/* Peeling at 1, 2, 4, 8 and 16 layers by both paths, and each of the others. */
static void of_transparent_scenes(void **state)
{
    struct study_config all[STUDY_MAX_CONFIGS];
    const struct stp_facts facts = { .transparent = true };
    unsigned count = check_configs(&facts, all), seen[STP_TRANSPARENCY_REFERENCE + 1] = { 0 };
    for (unsigned i = 0; i < count; i++) {
        seen[all[i].transparency]++;
        assert_int_equal(all[i].peel_layers > 0, all[i].transparency == STP_TRANSPARENCY_PEEL);
    }
    assert_int_equal(seen[STP_TRANSPARENCY_AUTO], 0);
    assert_int_equal(seen[STP_TRANSPARENCY_FAST], 1);
    assert_int_equal(seen[STP_TRANSPARENCY_NEAREST], 1);
    assert_int_equal(seen[STP_TRANSPARENCY_EXACT], 2);
    assert_int_equal(seen[STP_TRANSPARENCY_PEEL], 10);
}

static void of_volumes(void **state)
{
    struct study_config all[STUDY_MAX_CONFIGS];
    const struct stp_facts facts = { .volume.dims = { 4, 4, 4 } };
    unsigned count = check_configs(&facts, all), seen[STP_AXIS_SORT + 1] = { 0 };
    for (unsigned i = 0; i < count; i++) {
        assert_int_equal(all[i].method, STP_METHOD_AXIS);
        seen[all[i].merge]++;
    }
    assert_int_equal(seen[STP_AXIS_BLEND], 8);
    for (unsigned merge = STP_AXIS_CLIP; merge <= STP_AXIS_SORT; merge++)
        assert_int_equal(seen[merge], 2);
}

static void described(void **state)
{
    struct study_config config = { .method = STP_METHOD_DEFERRED,
                                   .path = STP_PATH_COMPUTE,
                                   .payload = STP_PAYLOAD_PACKED,
                                   .voronoi = STP_VORONOI_SLAB,
                                   .overlap = 0.6,
                                   .epsilon_scale = 1 };
    struct report_row row = { 0 };
    char name[REPORT_NAME_SIZE];
    study_describe(&config, &row);
    assert_string_equal(report_row_name(&row, name),
                        "deferred compute, c 0.6, Voronoi slab, packed");
}

static struct stp_scene *plane_scene(void)
{
    enum { SIDE = 20 };
    static double position[SIDE * SIDE][3];
    static float normal[SIDE * SIDE][3], radius[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; i++) {
        position[i][0] = i % SIDE;
        position[i][1] = i / SIDE;
        normal[i][2] = 1;
        radius[i] = 1.5f;
    }
    struct stp_points points = {
        .count = SIDE * SIDE, .position = position, .normal = normal, .radius = radius
    };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    return scene;
}

/* Each overlap is grouped once, each is shown as asked, and the scene ends as it began. */
static void groupings(void **state)
{
    struct stp_scene *scene = plane_scene();
    struct stp_group_params before = { .overlap = 0.7 }, params = { 0 };
    struct groupings groups;
    assert_int_equal(stp_scene_group(NULL, scene, &before), STP_OK);
    const uint8_t *group = scene->splats.group;
    struct stp_grouping facts = scene->facts.grouping;
    groupings_begin(&groups, scene);
    assert_int_equal(groupings_use(NULL, &groups, &params, 1), STP_OK);
    const uint8_t *whole = scene->splats.group;
    unsigned many = scene->facts.grouping.groups;
    assert_int_equal(groupings_use(NULL, &groups, &params, 0.4), STP_OK);
    assert_true(scene->facts.grouping.overlap == 0.4);
    assert_true(scene->facts.grouping.groups < many);
    assert_int_equal(groupings_use(NULL, &groups, &params, 1), STP_OK);
    assert_ptr_equal(scene->splats.group, whole);
    assert_int_equal(scene->facts.grouping.groups, many);
    assert_int_equal(groups.count, 2);
    groupings_end(&groups, false);
    assert_ptr_equal(scene->splats.group, group);
    assert_memory_equal(&scene->facts.grouping, &facts, sizeof facts);
    stp_scene_destroy(&scene);
}

static void ignore(void *user, enum stp_log_level level, const char *line)
{
}

static void groupings_without_memory(void **state)
{
    struct stp_scene *scene = plane_scene();
    struct stp_env env = { .threads = 1, .log = ignore };
    struct stp_group_params params = { 0 };
    struct groupings groups;
    for (unsigned long n = 1;; n++) {
        groupings_begin(&groups, scene);
        mem_fail_at(n);
        enum stp_result result = groupings_use(&env, &groups, &params, 0.8);
        mem_fail_at(0);
        groupings_end(&groups, false);
        assert_null(scene->splats.group);
        assert_int_equal(scene->facts.grouping.groups, 0);
        if (result == STP_OK)
            break;
        assert_int_equal(result, STP_ERROR_MEMORY);
    }
    stp_scene_destroy(&scene);
}

static void refused(void **state)
{
    struct stp_env env = { .log = ignore };
    struct stp_scene *scene = plane_scene();
    struct stp_report_params params = { 0 };
    struct stp_camera camera = { 0 };
    assert_int_equal(stp_report(&env, NULL, scene, &camera, &params, "."), STP_ERROR_ARGUMENT);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(configurations), cmocka_unit_test(of_transparent_scenes),
        cmocka_unit_test(of_volumes),     cmocka_unit_test(described),
        cmocka_unit_test(groupings),      cmocka_unit_test(groupings_without_memory),
        cmocka_unit_test(refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
