/* Transfer functions: evaluation, presets, and the JSON they stand in. */
#include "base/memory.h"
#include "json_files.h"
#include "scene/volume.h"

static void close_to(double actual, double expected)
{
    if (!(fabs(actual - expected) < 1e-6))
        fail_msg("%.9g, expected %.9g", actual, expected);
}

static void between_points_it_is_linear(void **state)
{
    const struct transfer_function f = { .count = 4,
                                         .point = { { -1, { 0, 0, 0 }, 0 },
                                                    { 1, { 1, 0.5f, 0 }, 0.4f },
                                                    { 1, { 0, 0, 1 }, 0.8f },
                                                    { 5, { 0, 0, 0 }, 0 } } };
    close_to((double)transfer_at(&f, -3).opacity, 0);
    close_to((double)transfer_at(&f, 0).opacity, 0.2);
    close_to((double)transfer_at(&f, 0).color[1], 0.25);
    close_to((double)transfer_at(&f, 1 - 1e-9).opacity, 0.4); /* a step, from below */
    close_to((double)transfer_at(&f, 1).opacity, 0.8);        /* and at it */
    close_to((double)transfer_at(&f, 3).opacity, 0.4);
    close_to((double)transfer_at(&f, 99).opacity, 0);
    close_to((double)transfer_at(&f, INFINITY).opacity, 0);
    assert_true(transfer_at(&f, NAN).opacity == 0);
}

static void presets_ascend_from_nothing(void **state)
{
    static const char *const names[] = { "grey", "bone", "flesh", "hot" };
    struct transfer_function f;
    for (int i = 0; i < 4; i++) {
        assert_true(transfer_preset(names[i], &f));
        assert_string_equal(f.name, names[i]);
        assert_true(f.of_range && f.count > 1 && f.point[0].opacity == 0);
        for (unsigned p = 1; p < f.count; p++)
            assert_true(f.point[p].value > f.point[p - 1].value &&
                        f.point[p].opacity >= f.point[p - 1].opacity);
        assert_true(f.point[f.count - 1].value == 1);
    }
    assert_false(transfer_preset("no such", &f));
}

static void a_file_is_read(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 0);
    struct transfer_function f;
    put_file(*state, "tf.json",
             "{\"name\": \"vessels\", \"unit\": \"value\", \"points\": ["
             "{\"value\": 10, \"opacity\": 0, \"color\": \"#ff8000\"},"
             "{\"value\": 20, \"opacity\": 0.5, \"color\": [0.25, 2, 0]}]}");
    assert_int_equal(transfer_load(&env, in_folder(*state, "tf.json", path), &f), STP_OK);
    assert_string_equal(f.name, "vessels");
    assert_true(!f.of_range && f.count == 2 && f.point[1].value == 20);
    close_to((double)f.point[0].color[0], 1);
    close_to((double)f.point[0].color[1], 0.2158605);
    close_to((double)f.point[1].color[1], 2);
    assert_int_equal(book.errors + book.warnings, 0);
}

static void mistakes_name_their_place(void **state)
{
    static const char *const wrong[][2] = {
        { "{\"points\": []}", "points" },
        { "{}", "points" },
        { "{\"points\": [{\"value\": 1}]}", "points[0]" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 2}]}", "points[0].opacity" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 1}, {\"value\": 0, \"opacity\": 1}]}",
          "points[1].value" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 1, \"color\": \"#12345\"}]}", "color" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 1, \"color\": \"#-1-1-1\"}]}", "color" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 1, \"color\": \"#0x1122\"}]}", "color" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 1, \"color\": \"# 1 2 3\"}]}", "color" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 1, \"color\": \"1234567\"}]}", "color" },
        { "{\"points\": [{\"value\": 1, \"opacity\": 1, \"color\": [1, -1, 0]}]}", "color" },
        { "{\"unit\": \"percent\", \"points\": [{\"value\": 1, \"opacity\": 1}]}", "unit" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char path[PATH_MAX];
        struct log_book book;
        struct stp_env env = logged_env(&book, 0);
        struct transfer_function f = { .count = 7 };
        put_file(*state, "wrong.json", wrong[i][0]);
        in_folder(*state, "wrong.json", path);
        assert_int_equal(transfer_load(&env, path, &f), STP_ERROR_FORMAT);
        assert_int_equal(book.errors, 1);
        assert_non_null(strstr(book.error, wrong[i][1]));
        assert_int_equal(f.count, 7);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(between_points_it_is_linear),
        cmocka_unit_test(presets_ascend_from_nothing),
        cmocka_unit_test_setup_teardown(a_file_is_read, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(mistakes_name_their_place, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
