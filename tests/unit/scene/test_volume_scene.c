/* Volumes in scenes: files and scene .json, and what does not go together. */
#include "json_files.h"
#include "scene/scene.h"

/* 2 x 3 x 4 bytes, the value being the index. */
static void put_raw(const char *folder, const char *name)
{
    char path[PATH_MAX];
    FILE *file = fopen(in_folder(folder, name, path), "wb");
    assert_non_null(file);
    for (int i = 0; i < 24; i++)
        fputc(i, file);
    assert_int_equal(fclose(file), 0);
}

static void by_a_description_beside_the_file(void **state)
{
    struct log_book book;
    struct stp_scene *scene;
    put_raw(*state, "v.raw");
    put_file(*state, "volumes.json",
             "{\"v.raw\": {\"dims\": [2,3,4], \"dtype\": \"uint8\", \"spacing\": [1,1,2]}}");
    assert_int_equal(load_named(*state, "v.raw", NULL, &book, &scene), STP_OK);
    const struct stp_facts *f = stp_scene_facts(scene);
    assert_int_equal(f->points, 24);
    assert_int_equal(f->volume.dims[2], 4);
    assert_true(f->volume.spacing[2] == 2 && f->volume.high == 23);
    assert_string_equal(f->format, "raw voxels");
    stp_scene_destroy(&scene);
}

static void by_the_callers_dims(void **state)
{
    struct log_book book;
    struct stp_scene *scene;
    struct stp_load_params params = { .volume = { .dims = { 4, 3, 1 }, .type = STP_VOXEL_U16 } };
    put_raw(*state, "v.raw");
    assert_int_equal(load_named(*state, "v.raw", &params, &book, &scene), STP_OK);
    assert_true(stp_scene_facts(scene)->volume.high == 22 + 256 * 23);
    stp_scene_destroy(&scene);
    params.volume.dims[0] = 5;
    assert_int_equal(load_named(*state, "v.raw", &params, &book, &scene), STP_ERROR_FORMAT);
    assert_non_null(strstr(book.error, "30 bytes"));
    params.volume = (struct stp_volume_params){ 0 };
    assert_int_equal(load_named(*state, "v.raw", &params, &book, &scene), STP_ERROR_FORMAT);
    assert_non_null(strstr(book.error, "--volume-dims"));
}

static void by_a_scene_file(void **state)
{
    struct log_book book;
    struct stp_scene *scene;
    put_raw(*state, "v.raw");
    put_file(*state, "tf.json", "{\"points\": [{\"value\": 3, \"opacity\": 0.5}]}");
    put_file(*state, "s.json",
             "{\"up\": \"z\", \"volume\": {\"file\": \"v.raw\", \"dims\": [2,3,4], \"type\": "
             "\"u8\", \"spacing\": [1,2,3], \"transfer_function\": \"tf.json\", "
             "\"unshaded\": true}}");
    assert_int_equal(load_named(*state, "s.json", NULL, &book, &scene), STP_OK);
    assert_int_equal(book.warnings, 0);
    assert_true(scene->volume->unshaded && scene->volume->transfer.point[0].value == 3);
    assert_int_equal(scene->facts.up, STP_UP_Z);
    stp_scene_destroy(&scene);
    put_file(*state, "s.json",
             "{\"volume\": {\"file\": \"v.raw\", \"dims\": [2,3,4], \"transfer_function\": "
             "{\"name\": \"own\", \"points\": [{\"value\": 5, \"opacity\": 1}]}}}");
    assert_int_equal(load_named(*state, "s.json", NULL, &book, &scene), STP_OK);
    assert_string_equal(scene->volume->transfer.name, "own");
    assert_false(scene->volume->automatic);
    stp_scene_destroy(&scene);
}

static void what_does_not_go_together(void **state)
{
    static const char *const wrong[][2] = {
        { "{\"volume\": {\"dims\": [2,3,4]}}", "volume.file" },
        { "{\"volume\": {\"file\": \"v.raw\", \"dims\": [2,3,4.5]}}", "volume.dims" },
        { "{\"volume\": {\"file\": \"v.raw\", \"dims\": [2,3,4], \"type\": \"u7\"}}", "type" },
        { "{\"volume\": {\"file\": \"p.xyz\"}}", "no volume" },
        { "{\"volume\": {\"file\": \"v.raw\", \"dims\": [2,3,4], \"transfer_function\": 3}}",
          "transfer_function" },
        { "{\"volume\": {\"file\": \"v.raw\", \"dims\": [2,3,4], \"transfer_function\": "
          "\"none.json\"}}",
          "none.json" },
        { "{\"points\": [\"p.xyz\"], \"volume\": {\"file\": \"v.raw\", \"dims\": [2,3,4]}}",
          "volume: stands beside points" },
    };
    put_raw(*state, "v.raw");
    put_file(*state, "p.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct log_book book;
        struct stp_scene *scene;
        put_file(*state, "s.json", wrong[i][0]);
        assert_int_not_equal(load_named(*state, "s.json", NULL, &book, &scene), STP_OK);
        if (!strstr(book.error, wrong[i][1]))
            fail_msg("'%s' does not say '%s'", book.error, wrong[i][1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(by_a_description_beside_the_file, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(by_the_callers_dims, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(by_a_scene_file, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(what_does_not_go_together, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
