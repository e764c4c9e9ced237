/* Numbers as text and back, getters, and where broken JSON is said to break. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/json.h"

static void take_line(void *user, enum stp_log_level level, const char *line)
{
    snprintf(user, 512, "%s", line);
}

static void check_number(double value)
{
    char text[JSON_NUMBER_SIZE], document[64];
    snprintf(document, sizeof document, "{\"v\": %s}", json_number_text(value, text));
    cJSON *json = cJSON_Parse(document);
    double back = NAN;
    struct json_at at = json_root(NULL, "t");
    assert_int_equal(json_get_number(&at, json, "v", &back), STP_OK);
    assert_true(back == value);
    cJSON_Delete(json);
}

static void test_numbers(void **state)
{
    char text[JSON_NUMBER_SIZE];
    assert_string_equal(json_number_text(0.1, text), "0.1");
    assert_string_equal(json_number_text(-3, text), "-3");
    check_number(DBL_MAX);
    check_number(DBL_MIN);
    check_number(5e-324);
    check_number(0.1 + 0.2);
    srand(1);
    for (int i = 0; i < 20000; i++) {
        union {
            unsigned char bytes[8];
            double value;
        } u;
        for (int b = 0; b < 8; b++)
            u.bytes[b] = (unsigned char)(rand() >> 7);
        if (isfinite(u.value))
            check_number(u.value);
    }
}

static void test_getters(void **state)
{
    char line[512] = "";
    const struct stp_env env = { .log = take_line, .user = line };
    struct json_at root = json_root(&env, "file"), at = json_below(&root, "list", 2);
    cJSON *json = cJSON_Parse("{\"n\": 1, \"s\": \"a\", \"b\": true, \"v\": [[1, 2], [3]], "
                              "\"big\": 1e300}");
    double number = 7, values[3] = { 0 };
    float small = 2;
    bool flag = false;
    const char *string = NULL;
    assert_int_equal(json_get_number(&at, json, "absent", &number), STP_OK);
    assert_true(number == 7);
    assert_int_equal(json_get_number(&at, json, "s", &number), STP_ERROR_FORMAT);
    assert_string_equal(line, "file: list[2].s: a finite number is needed");
    assert_int_equal(json_get_float(&at, json, "big", &small), STP_ERROR_FORMAT);
    assert_true(number == 7 && small == 2);
    assert_int_equal(json_get_string(&at, json, "s", &string), STP_OK);
    assert_string_equal(string, "a");
    assert_int_equal(json_get_string(&at, json, "n", &string), STP_ERROR_FORMAT);
    assert_int_equal(json_get_bool(&at, json, "b", &flag), STP_OK);
    assert_true(flag);
    assert_int_equal(json_get_bool(&at, json, "n", &flag), STP_ERROR_FORMAT);
    assert_int_equal(json_get_numbers(&at, json, "v", 3, values), STP_OK);
    assert_true(values[0] == 1 && values[1] == 2 && values[2] == 3);
    assert_int_equal(json_get_numbers(&at, json, "v", 2, values), STP_ERROR_FORMAT);
    assert_int_equal(json_get_numbers(&at, json, "v", 4, values), STP_ERROR_FORMAT);
    assert_int_equal(json_check_object(&at, json, "n s b v big"), STP_OK);
    line[0] = 0;
    assert_int_equal(json_check_object(&at, json, "n s b v bigger"), STP_OK);
    assert_non_null(strstr(line, "list[2].big: unknown key"));
    cJSON_Delete(json);
}

static void test_syntax(void **state)
{
    static const char *const cases[][2] = {
        { "", "byte 0 (line 1, column 1)" },
        { "  \n ", "byte" },
        { "{\"a\": 1\n\"b\": 2}", "byte 8 (line 2, column 1)" },
        { "[1, 2] 3", "byte 7 (line 1, column 8)" },
        { "{\"a\": \"unterminated}", "byte" },
        { "{\"a\": \"b.ply\\u0000c\"}", "a character NUL at byte 12 (line 1, column 13)" },
        { "{\"a\\u0000\": 1}", "a character NUL at byte 3" },
        { "[\"\\\\\\u0000\"]", "a character NUL at byte 4" },
    };
    char path[] = "/tmp/stipple-test-XXXXXX", line[512] = "";
    const struct stp_env env = { .log = take_line, .user = line };
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        cJSON *json = NULL;
        size_t size = strlen(cases[i][0]);
        assert_int_equal(ftruncate(fd, 0), 0);
        assert_int_equal(pwrite(fd, cases[i][0], size, 0), size);
        assert_int_equal(json_read(&env, path, &json), STP_ERROR_FORMAT);
        assert_null(json);
        if (!strstr(line, cases[i][1]))
            fail_msg("%s: %s", cases[i][0], line);
    }
    close(fd);
    unlink(path);
}

/* A raw NUL inside a string; and what only looks like one escaped. */
static void test_nul(void **state)
{
    static const char raw[] = "[\"a\0b\"]", escaped[] = "[\"\\\\u0000\", \"\\u00001\", \"u0000\"]";
    char path[] = "/tmp/stipple-test-XXXXXX", line[512] = "";
    const struct stp_env env = { .log = take_line, .user = line };
    cJSON *json = NULL;
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(pwrite(fd, raw, sizeof raw - 1, 0), sizeof raw - 1);
    assert_int_equal(json_read(&env, path, &json), STP_ERROR_FORMAT);
    assert_non_null(strstr(line, "byte 3"));
    assert_int_equal(ftruncate(fd, 0), 0);
    assert_int_equal(pwrite(fd, escaped, sizeof escaped - 1, 0), sizeof escaped - 1);
    assert_int_equal(json_read(&env, path, &json), STP_ERROR_FORMAT);
    assert_non_null(strstr(line, "byte 13")); /* the second string's */
    close(fd);
    unlink(path);
}

static void test_keys_again(void **state)
{
    char line[512] = "";
    const struct stp_env env = { .log = take_line, .user = line };
    struct json_at at = json_root(&env, "file");
    cJSON *json = cJSON_Parse("{\"a\": 1, \"b\": 2, \"a\": 3}");
    double value = 0;
    assert_int_equal(json_check_object(&at, json, "a b"), STP_OK);
    assert_string_equal(line, "file: a: the key comes again; the first counts");
    assert_int_equal(json_get_number(&at, json, "a", &value), STP_OK);
    assert_true(value == 1);
    cJSON_Delete(json);
    line[0] = 0;
    json = cJSON_Parse("{\"a\": 1, \"b\": 2, \"A\": 3}");
    assert_int_equal(json_check_object(&at, json, "a b A"), STP_OK);
    assert_string_equal(line, "");
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers),    cmocka_unit_test(test_getters),
        cmocka_unit_test(test_syntax),     cmocka_unit_test(test_nul),
        cmocka_unit_test(test_keys_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
