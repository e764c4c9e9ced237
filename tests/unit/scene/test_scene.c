#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "base/memory.h"
#include "scene/axes.h"
#include "scene/scene.h"

static void silent(void *user, enum stp_log_level level, const char *line)
{
}
static const struct stp_env quiet = { .log = silent };
static const double two[2][3] = { { 1, 2, 3 }, { 4, 5, 6 } };
static const struct stp_points pair = { .count = 2, .position = two };

static void defaults(void **state)
{
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &pair, NULL), STP_OK);
    const struct scene_object *o = scene->objects;
    assert_true(o->material.ambient == 0.1f && o->material.diffuse == 0.7f &&
                o->material.specular == 0.2f && o->material.shininess == 32 &&
                o->material.albedo[2] == 0.8f);
    assert_true(o->epsilon == 0 && o->opacity == 1);
    assert_true(o->cloud.position[1][2] == 6 && (const void *)o->cloud.position != two);
    assert_true(scene->light_count == 1 && scene->lights[0].at_eye &&
                scene->lights[0].color[0] == 1);
    assert_int_equal(stp_scene_facts(scene)->points, 2);
    stp_scene_destroy(&scene);
    assert_null(scene);
    stp_scene_destroy(&scene);
    stp_scene_destroy(NULL);
}

/* A material of zeros is black, not the default. */
static void zeros_are_taken_as_given(void **state)
{
    struct stp_material black = { 0 };
    struct stp_object_params object = { .material = &black, .epsilon = 0.25, .opacity = 0.5f };
    struct stp_scene *scene;
    stp_scene_create(NULL, &scene);
    assert_int_equal(stp_scene_add_points(NULL, scene, &pair, &object), STP_OK);
    assert_memory_equal(&scene->objects[0].material, &black, sizeof black);
    assert_true(scene->objects[0].epsilon == 0.25 && scene->objects[0].opacity == 0.5f);
    stp_scene_destroy(&scene);
}

static void bad_objects_change_nothing(void **state)
{
    struct stp_material nan = { .ambient = NAN }, dense = { .opacity = 2 };
    struct stp_material unclear = { .opacity = NAN };
    const struct stp_object_params bad[] = { { .epsilon = -1 },      { .epsilon = NAN },
                                             { .opacity = 2 },       { .opacity = NAN },
                                             { .material = &dense }, { .material = &unclear },
                                             { .material = &nan } };
    struct stp_scene *scene;
    stp_scene_create(NULL, &scene);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(stp_scene_add_points(&quiet, scene, &pair, &bad[i]), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_add_points(&quiet, scene, &(struct stp_points){ .count = 3 }, NULL),
                     STP_ERROR_ARGUMENT);
    struct cloud huge = { .count = UINT32_MAX };
    assert_int_equal(scene_add_cloud(&quiet, scene, &huge, NULL), STP_ERROR_ARGUMENT);
    assert_int_equal(huge.count, UINT32_MAX);
    assert_int_equal(scene->object_count, 0);
    assert_int_equal(scene->facts.points, 0);
    stp_scene_destroy(&scene);
}

static void lights(void **state)
{
    struct stp_light sun = { .direction = { 0, 2, 0 }, .color = { 1, 1, 1 } };
    struct stp_light lamp = { .positional = true, .color = { 1, 0, 0 } };
    struct stp_light none = { .color = { 1, 1, 1 } };
    struct stp_light many[STP_MAX_LIGHTS + 1] = { sun, lamp };
    struct stp_scene *scene;
    stp_scene_create(NULL, &scene);
    assert_int_equal(stp_scene_set_lights(NULL, scene, many, 2), STP_OK);
    assert_true(scene->light_count == 2 && scene->lights[1].positional);
    assert_true(stp_scene_facts(scene)->positional_lights);
    assert_int_equal(stp_scene_set_lights(NULL, scene, many, STP_MAX_LIGHTS + 1),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_set_lights(NULL, scene, &none, 1), STP_ERROR_ARGUMENT);
    assert_int_equal(scene->light_count, 2);
    assert_int_equal(stp_scene_set_lights(NULL, scene, NULL, 0), STP_OK);
    assert_true(scene->light_count == 1 && scene->lights[0].at_eye);
    assert_false(stp_scene_facts(scene)->positional_lights);
    stp_scene_destroy(&scene);
}

static void clouds_change_hands(void **state)
{
    struct cloud cloud = { .count = 1, .up = STP_UP_Z, .format = "PLY ascii" };
    struct stp_scene *scene;
    cloud.position = mem_zalloc(1, sizeof *cloud.position);
    cloud.fields = mem_zalloc(1, sizeof *cloud.fields);
    cloud.field_count = 1;
    cloud.fields[0].value = mem_zalloc(1, sizeof(float));
    stp_scene_create(NULL, &scene);
    mem_fail_at(1);
    assert_int_equal(scene_add_cloud(&quiet, scene, &cloud, NULL), STP_ERROR_MEMORY);
    mem_fail_at(0);
    assert_non_null(cloud.position);
    assert_int_equal(scene_add_cloud(NULL, scene, &cloud, NULL), STP_OK);
    assert_null(cloud.position);
    assert_null(cloud.fields);
    assert_string_equal(stp_scene_facts(scene)->format, "PLY ascii");
    assert_int_equal(stp_scene_facts(scene)->up, STP_UP_Z);
    stp_scene_destroy(&scene);
}

static void no_memory(void **state)
{
    float one[2][3] = { { 1 } };
    struct stp_points all = { .count = 2,
                              .position = two,
                              .normal = (const float(*)[3])one,
                              .radius = one[0],
                              .color = (const float(*)[3])one,
                              .opacity = one[0] };
    for (unsigned long n = 1, reached = 1; reached; n++) {
        struct stp_scene *scene = NULL;
        mem_fail_at(n);
        enum stp_result result = stp_scene_create(&quiet, &scene);
        if (result == STP_OK)
            result = stp_scene_add_points(&quiet, scene, &all, NULL);
        reached = mem_count() >= n;
        mem_fail_at(0);
        assert_int_equal(result, reached ? STP_ERROR_MEMORY : STP_OK);
        assert_true(!scene || !reached || scene->object_count == 0);
        stp_scene_destroy(&scene);
    }
}

static void axes_are_right_handed(void **state)
{
    for (int up = STP_UP_AUTO; up <= STP_UP_NEG_Y; up++) {
        struct scene_axes a = scene_axes((enum stp_up)up);
        struct vec3 c = v3_cross(a.right, a.up);
        assert_true(c.x == a.viewer.x && c.y == a.viewer.y && c.z == a.viewer.z);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults),
        cmocka_unit_test(zeros_are_taken_as_given),
        cmocka_unit_test(bad_objects_change_nothing),
        cmocka_unit_test(lights),
        cmocka_unit_test(clouds_change_hands),
        cmocka_unit_test(no_memory),
        cmocka_unit_test(axes_are_right_handed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
