/* Scene files: objects, lights, camera, paths relative to the file, mistakes; and point files. */
#include "json_files.h"

#include "base/memory.h"
#include "scene/scene.h"

static const char ply[] = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                          "property float y\nproperty float z\nproperty float nx\n"
                          "property float ny\nproperty float nz\nproperty float radius\n"
                          "end_header\n1 2 3 0 0 1 0.5\n-4 5 6 1 0 0 0.25\n";

static struct stp_scene *load(const char *folder, const char *text,
                              const struct stp_load_params *params, struct log_book *book)
{
    char path[PATH_MAX];
    struct stp_env env = logged_env(book, 0);
    struct stp_scene *scene = NULL;
    put_file(folder, "s.json", text);
    enum stp_result result =
        stp_scene_load(&env, in_folder(folder, "s.json", path), params, &scene);
    assert_int_equal(result == STP_OK, scene != NULL);
    assert_int_equal(book->errors, scene == NULL);
    return scene;
}

static void test_whole(void **state)
{
    static const char text[] =
        "\n {\"up\": \"z\", \"name\": \"n\", \"points\": [\"a.ply\", {\"file\": \"sub/b.ply\", "
        "\"epsilon\": 0.125, \"opacity\": 0.5, \"transform\": [[0,-2,0,10],[2,0,0,20],[0,0,2,30],"
        "[0,0,0,1]], \"material\": {\"albedo\": [0.1,0.2,0.3], \"shininess\": 5}}], "
        "\"lights\": [{\"at_eye\": true}, {\"direction\": [0,0,2], \"color\": [1,2,3]}, "
        "{\"position\": [1,2,3]}], \"camera\": {\"world_to_camera\": [1,0,0,0, 0,1,0,0, 0,0,1,-9, "
        "0,0,0,1], \"fov_y_deg\": 90, \"width\": 20, \"height\": 10}}";
    struct log_book book;
    struct stp_camera camera;
    struct stp_scene *scene = load(*state, text, NULL, &book);
    if (!scene || book.warnings)
        fail_msg("%s%s", book.error, book.warning);
    assert_int_equal(scene->object_count, 2);
    assert_int_equal(scene->facts.points, 4);
    assert_int_equal(scene->facts.up, STP_UP_Z);
    const struct scene_object *a = &scene->objects[0], *b = &scene->objects[1];
    assert_true(a->epsilon == 0 && a->opacity == 1 && a->material.albedo[0] == 0.8f);
    assert_true(b->epsilon == 0.125 && b->opacity == 0.5f && b->material.albedo[2] == 0.3f);
    assert_true(b->material.shininess == 5 && b->material.diffuse == 0.7f);
    assert_true(a->cloud.position[0][0] == 1 && a->cloud.radius[1] == 0.25f);
    const double moved[2][3] = { { 6, 22, 36 }, { 0, 12, 42 } };
    const float turned[2][3] = { { 0, 0, 1 }, { 0, 1, 0 } };
    for (int i = 0; i < 2; i++) {
        assert_true(b->cloud.radius[i] == (i ? 0.5f : 1.0f));
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(b->cloud.position[i][c] - moved[i][c]) < 1e-12);
            assert_true(fabsf(b->cloud.normal[i][c] - turned[i][c]) < 1e-6f);
        }
    }
    assert_int_equal(scene->light_count, 3);
    assert_true(scene->lights[0].at_eye && scene->lights[0].color[0] == 1);
    assert_true(!scene->lights[1].positional && scene->lights[1].direction[2] == 2);
    assert_true(scene->lights[1].color[2] == 3 && scene->lights[2].positional);
    assert_true(stp_scene_camera(scene, 0, 0, &camera));
    assert_true(camera.width == 20 && fabs(camera.fx - 5) < 1e-12 &&
                camera.world_to_camera[11] == -9);
    assert_true(stp_scene_camera(scene, 100, 20, &camera));
    assert_true(camera.width == 100 && fabs(camera.fx - 10) < 1e-12 && camera.cx == 50);
    stp_scene_destroy(&scene);
}

/* The caller's params win over the file. */
static void test_params_win(void **state)
{
    const struct stp_material material = {
        .ambient = 1, .diffuse = 1, .specular = 1, .shininess = 1, .albedo = { 1, 1, 1 }
    };
    const struct stp_load_params params = {
        .up = STP_UP_X, .material = &material, .epsilon = 3, .opacity = 0.25f
    };
    struct log_book book;
    struct stp_scene *scene =
        load(*state,
             "{\"up\": \"z\", \"points\": [{\"file\": \"a.ply\", \"epsilon\": "
             "1, \"opacity\": 0.5, \"material\": {\"ambient\": 0}}]}",
             &params, &book);
    assert_non_null(scene);
    assert_true(scene->facts.up == STP_UP_X && scene->objects[0].epsilon == 3);
    assert_true(scene->objects[0].opacity == 0.25f && scene->objects[0].material.ambient == 1);
    struct stp_camera camera;
    assert_false(stp_scene_camera(scene, 0, 0, &camera));
    stp_scene_destroy(&scene);
}

static void test_camera_file(void **state)
{
    struct log_book book;
    struct stp_camera camera;
    put_file(
        *state, "sub/c.json",
        "[{\"world_to_camera\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], \"intrinsics\": {\"fx\": "
        "10, \"fy\": 10, \"cx\": 5, \"cy\": 5}, \"width\": 10, \"height\": 10}]");
    struct stp_scene *scene =
        load(*state, "{\"points\": [], \"camera_file\": \"sub/c.json\"}", NULL, &book);
    assert_non_null(scene);
    assert_true(stp_scene_camera(scene, 20, 10, &camera));
    assert_true(camera.fx == 20 && camera.fy == 10 && camera.cx == 10);
    /* No points is an error of prepare, not of load. */
    struct stp_env env = logged_env(&book, 0);
    assert_int_equal(stp_scene_prepare(&env, scene, NULL), STP_ERROR_NO_POINTS);
    stp_scene_destroy(&scene);
}

static void test_point_file(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 0);
    struct stp_scene *scene = NULL;
    const struct stp_load_params params = { .epsilon = 2 };
    in_folder(*state, "a.ply", path);
    assert_int_equal(stp_scene_load(&env, path, &params, &scene), STP_OK);
    assert_int_equal(scene->facts.points, 2);
    assert_true(scene->objects[0].epsilon == 2 && scene->light_count == 1);
    stp_scene_destroy(&scene);
    in_folder(*state, "none.ply", path);
    assert_int_equal(stp_scene_load(&env, path, NULL, &scene), STP_ERROR_IO);
    assert_null(scene);
    assert_int_equal(stp_scene_load(&env, *state, NULL, &scene), STP_ERROR_FORMAT);
    assert_int_equal(book.errors, 2);
}

static void test_mistakes(void **state)
{
    static const char *const cases[][2] = {
        { "{\"points\": [}", "s.json: broken JSON at byte 12" },
        { "{}", "points: an array of point files" },
        { "{\"points\": {}}", "points: an array" },
        { "{\"points\": [3]}", "points[0]." },
        { "{\"points\": [{}]}", "points[0].file: the path" },
        { "{\"points\": [{\"file\": 3}]}", "points[0].file: a string" },
        { "{\"points\": [\"a.ply\", {\"file\": \"a.ply\", \"epsilon\": 0}]}", "points[1].epsilon" },
        { "{\"points\": [{\"file\": \"a.ply\", \"opacity\": 2}]}",
          "opacity: a number from 0 to 1" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"opacity\": -0.1}}]}",
          "points[0].material.opacity: a number from 0 to 1" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": 1}]}", "points[0].material." },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"albedo\": [1]}}]}",
          "points[0].material.albedo: an array of 3" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"ambient\": -1}}]}",
          "ambient: must" },
        { "{\"points\": [{\"file\": \"a.ply\", \"transfer\": \"gamma\"}]}",
          "transfer: one of these is needed: auto srgb linear" },
        { "{\"points\": [{\"file\": \"a.ply\", \"transform\": [1,0,0,0, 0,2,0,0, 0,0,1,0, "
          "0,0,0,1]}]}",
          "transform: a rotation" },
        { "{\"points\": [], \"up\": \"w\"}", "up: one of these is needed: auto x y z -y" },
        { "{\"points\": [], \"lights\": []}", "lights: an array of 1 to 8" },
        { "{\"points\": [], \"lights\": [{}]}", "lights[0].at_eye: exactly one" },
        { "{\"points\": [], \"lights\": [{\"direction\": [0,0,0]}]}", "must not be zero" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"ior\": 0}}]}",
          "points[0].material.ior: 0.05 to 20" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"ior\": [1, 2]}}]}",
          "material.ior: an array of 3" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"roughness\": [0, 0, 0]}}]}",
          "material.roughness: a finite number" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"reflectance\": 1.1}}]}",
          "material.reflectance: 0 to 1" },
        { "{\"points\": [{\"file\": \"a.ply\", \"material\": {\"absorption\": -1}}]}",
          "material.absorption: numbers from 0" },
        { "{\"points\": [], \"environment\": 1}", "environment." },
        { "{\"points\": [], \"environment\": {}}", "environment.file: the path" },
        { "{\"points\": [], \"environment\": {\"file\": \"sky.hdr\", \"intensity\": 0}}",
          "environment.intensity: more than 0" },
        { "{\"points\": [], \"environment\": {\"file\": \"a.ply\"}}",
          "a.ply: neither OpenEXR nor Radiance" },
        { "{\"points\": [], \"volume\": \"head.nrrd\"}", "volume: stands beside points" },
        { "{\"points\": [], \"camera\": {}}", "camera.world_to_camera: missing" },
        { "{\"points\": [], \"camera\": {}, \"camera_file\": \"c\"}", "exclude each other" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct log_book book;
        struct stp_scene *scene = load(*state, cases[i][0], NULL, &book);
        assert_null(scene);
        if (!strstr(book.error, cases[i][1]))
            fail_msg("%s: %s", cases[i][0], book.error);
    }
    struct log_book book;
    assert_null(load(*state, "{\"points\": [\"gone.ply\"]}", NULL, &book));
    assert_non_null(strstr(book.error, "/gone.ply: cannot open"));
    assert_null(load(*state, "{\"points\": [], \"camera_file\": \"gone.json\"}", NULL, &book));
    assert_non_null(strstr(book.error, "/gone.json: cannot open"));
}

static void test_unknown_keys(void **state)
{
    struct log_book book;
    struct stp_scene *scene = load(
        *state, "{\"point\": 1, \"points\": [{\"file\": \"a.ply\", \"colour\": 2}]}", NULL, &book);
    assert_non_null(scene);
    assert_int_equal(book.warnings, 2);
    assert_non_null(strstr(book.warning, "points[0].colour: unknown key"));
    stp_scene_destroy(&scene);
}

/* Optics of an object; what the caller's set wins field by field, 0 being a value of a file. */
static void test_environment(void **state)
{
    static const char text[] =
        "{\"points\": [\"a.ply\", {\"file\": \"a.ply\", \"material\": {\"ior\": [1.2, 1.3, 1.4], "
        "\"reflectance\": 0, \"roughness\": 0.5, \"absorption\": [0, 1, 2], \"thickness\": 3}}], "
        "\"environment\": {\"file\": \"sky.hdr\", \"rotation\": 90, \"intensity\": 2}}";
    const struct stp_optics optics = { .roughness = -1, .reflectance = { 0.5f } };
    const struct stp_load_params params = { .optics = &optics };
    struct log_book book;
    for (int given = 0; given < 2; given++) {
        struct stp_scene *scene = load(*state, text, given ? &params : NULL, &book);
        assert_non_null(scene);
        const struct scene_environment *e = &scene->environment;
        assert_true(e->map.width == 2 && e->map.height == 1 && e->params.intensity == 2);
        assert_float_equal(e->params.rotation, 1.5707963267948966, 1e-12);
        const struct stp_optics *plain = &scene->objects[0].optics, *o = &scene->objects[1].optics;
        assert_true(plain->ior[0] == 1.5f && plain->thickness == 1 && plain->absorption[1] == 0);
        assert_true(o->ior[0] == 1.2f && o->ior[2] == 1.4f && o->thickness == 3);
        assert_true(o->absorption[0] == 0 && o->absorption[2] == 2);
        assert_true(o->roughness == (given ? 0 : 0.5f) && o->reflectance[1] == 0);
        assert_true(o->reflectance[0] == (given ? 0.5f : 0));
        assert_true(plain->reflectance[0] == o->reflectance[0]);
        stp_scene_destroy(&scene);
    }
}

/* cJSON's own allocations are not counted; all of ours are. */
static void test_memory(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 0);
    struct stp_scene *scene = NULL;
    unsigned failures = 0;
    env.threads = 1;
    put_file(*state, "s.json",
             "{\"points\": [\"a.ply\", {\"file\": \"sub/b.ply\", \"transform\": [1,0,0,0, 0,1,0,0, "
             "0,0,1,0, 0,0,0,1]}], \"lights\": [{\"at_eye\": true}], \"environment\": {\"file\": "
             "\"sky.hdr\"}}");
    in_folder(*state, "s.json", path);
    for (unsigned long n = 1;; n++) {
        mem_fail_at(n);
        enum stp_result result = stp_scene_load(&env, path, NULL, &scene);
        bool reached = mem_count() >= n;
        mem_fail_at(0);
        if (!reached)
            break;
        if (result == STP_OK) {
            /* Readers may do without a table that only saves time. */
            assert_int_equal(scene->facts.points, 4);
            stp_scene_destroy(&scene);
            continue;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_null(scene);
        assert_int_equal(book.errors, ++failures);
    }
    assert_true(failures > 10);
    stp_scene_destroy(&scene);
}

static void test_example(void **state)
{
    struct log_book book;
    struct stp_env env = logged_env(&book, 0);
    struct stp_scene *scene = NULL;
    struct stp_camera camera;
    assert_int_equal(stp_scene_load(&env, STP_ASSETS "/example_scene.json", NULL, &scene), STP_OK);
    assert_int_equal(book.warnings, 0);
    assert_true(scene->facts.points == 171700 && scene->light_count == 2);
    assert_true(stp_scene_camera(scene, 0, 0, &camera));
    assert_int_equal(stp_scene_prepare(&env, scene, NULL), STP_OK);
    assert_int_equal(scene->facts.splats, 171700);
    stp_scene_destroy(&scene);
}

static int set_up(void **state)
{
    char path[PATH_MAX];
    if (make_folder(state) != 0)
        return -1;
    put_file(*state, "a.ply", ply);
    put_file(*state, "sky.hdr", "#?RGBE\n\n-Y 1 +X 2\n@@@\200@@@\200");
    if (mkdir(in_folder(*state, "sub", path), 0777) != 0)
        return -1;
    put_file(*state, "sub/b.ply", ply);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_whole),       cmocka_unit_test(test_params_win),
        cmocka_unit_test(test_camera_file), cmocka_unit_test(test_point_file),
        cmocka_unit_test(test_mistakes),    cmocka_unit_test(test_unknown_keys),
        cmocka_unit_test(test_environment), cmocka_unit_test(test_memory),
        cmocka_unit_test(test_example),
    };
    return cmocka_run_group_tests(tests, set_up, remove_folder);
}
