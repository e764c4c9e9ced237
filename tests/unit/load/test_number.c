/* number_read against the C library's strtod, bit for bit. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/text.h"
#include "support.h"

/* In a block of exactly its length, so that reading on is seen. */
static bool read_exact(const char *text, double *value, size_t *used)
{
    size_t length = strlen(text);
    char *copy = malloc(length ? length : 1);
    memcpy(copy, text, length);
    const char *at = copy;
    bool ok = number_read(&at, copy + length, value);
    *used = (size_t)(at - copy);
    free(copy);
    return ok;
}

static void expect_strtod(const char *text)
{
    double value = 0, expected = strtod(text, NULL);
    size_t used;
    bool ok = read_exact(text, &value, &used);
    if (!ok || used != strlen(text) || memcmp(&value, &expected, sizeof value) != 0)
        print_error("%s: %.17g, expected %.17g\n", text, value, expected);
    assert_true(ok);
    assert_int_equal(used, strlen(text));
    assert_memory_equal(&value, &expected, sizeof value);
}

static void test_printed_doubles(void **state)
{
    uint64_t seed = 88172645463325252u;
    static const char *const formats[] = {
        "%.17g", "%.16g", "%.9g", "%.6f", "%.20e", "%g", "%.3f"
    };
    for (int i = 0; i < 40000; i++) {
        uint64_t bits = next_random(&seed);
        double value;
        char text[400];
        if (i & 1)
            value = ((double)(int64_t)bits) / (double)(1ull << (bits & 63));
        else
            memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        snprintf(text, sizeof text, formats[i % 7], value);
        expect_strtod(text);
    }
}

static void test_random_digits(void **state)
{
    uint64_t seed = 5;
    for (int i = 0; i < 40000; i++) {
        char text[80];
        size_t length = 0, digits = 1 + next_random(&seed) % 40;
        size_t dot = next_random(&seed) % 45;
        if (next_random(&seed) & 1)
            text[length++] = '-';
        for (size_t d = 0; d < digits; d++) {
            if (d == dot)
                text[length++] = '.';
            text[length++] = (char)('0' + next_random(&seed) % 10);
        }
        text[length] = 0;
        if (next_random(&seed) & 1)
            snprintf(text + length, sizeof text - length, "e%d",
                     (int)(next_random(&seed) % 700) - 350);
        expect_strtod(text);
    }
}

static void test_boundaries(void **state)
{
    static const char *const texts[] = {
        "0",
        "-0",
        "0.0e5",
        "1",
        "+1",
        "1.",
        ".5",
        "00012.50",
        "9007199254740992",
        "9007199254740993",
        "9007199254740991e22",
        "9007199254740993e22",
        "1e22",
        "1e23",
        "1e-22",
        "1e-23",
        "4.9406564584124654e-324",
        "2.4703282292062327e-324",
        "2.4703282292062328e-324",
        "2.2250738585072011e-308",
        "1.7976931348623157e308",
        "1.7976931348623159e308",
        "1e400",
        "1e-400",
        "123456789012345678901234567890",
        "18446744073709551616",
        "0.000000000000000000000000000000000000000000001",
        "1e99999999999999999999",
        "1e-99999999999999999999",
        "5e-324",
        "3E+5",
        "3e05",
        "1.00000000000000011102230246251565404236316680908203125",  /* half way */
        "1.000000000000000111022302462515654042363166809082031251", /* and above */
        "1.00000000000000011102230246251565404236316680908203124",  /* and below */
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        expect_strtod(texts[i]);
}

/* Half way, until digit 1500. */
static void test_long_digits(void **state)
{
    static const char half[] = "1.00000000000000011102230246251565404236316680908203125";
    char text[2048];
    memset(text, '0', sizeof text);
    memcpy(text, half, sizeof half - 1);
    text[1500] = 0;
    expect_strtod(text);
    text[1499] = '1';
    expect_strtod(text);
    memset(text, '7', 2000);
    text[2000] = 0;
    expect_strtod(text);
    memset(text, '0', 1900);
    text[1] = '.';
    strcpy(text + 1900, "123e1900");
    expect_strtod(text);
}

static void test_not_finite(void **state)
{
    static const char *const nans[] = { "nan",       "NaN",     "-nan",    "nan(ind)",
                                        "-nan(ind)", "1.#QNAN", "-1.#IND", "1.#QNAN0" };
    static const char *const infs[] = { "inf", "Inf", "INFINITY", "+inf", "1.#INF", "1.#INF00" };
    double value;
    size_t used;
    for (size_t i = 0; i < sizeof nans / sizeof *nans; i++) {
        assert_true(read_exact(nans[i], &value, &used));
        assert_true(isnan(value));
        assert_int_equal(used, strlen(nans[i]));
    }
    for (size_t i = 0; i < sizeof infs / sizeof *infs; i++) {
        assert_true(read_exact(infs[i], &value, &used));
        assert_true(isinf(value) && value > 0);
        assert_int_equal(used, strlen(infs[i]));
    }
    assert_true(read_exact("-inf", &value, &used));
    assert_true(isinf(value) && value < 0);
}

static void test_rejects(void **state)
{
    static const char *const texts[] = {
        "", "-", "+", ".", "-.", "e5", "x", "--1", "i", "na", "#"
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        double value = 7;
        size_t used;
        assert_false(read_exact(texts[i], &value, &used));
        assert_int_equal(used, 0);
        assert_true(value == 7);
    }
}

/* What follows the number is left. */
static void test_stops(void **state)
{
    static const struct {
        const char *text;
        double value;
        size_t used;
    } cases[] = { { "1.5e", 1.5, 3 },  { "1.5e+", 1.5, 3 },  { "1.5ex", 1.5, 3 }, { "2,3", 2, 1 },
                  { "1.2.3", 1.2, 3 }, { "12d3", 12000, 4 }, { "12D-1", 1.2, 5 }, { "4 5", 4, 1 } };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double value;
        size_t used;
        assert_true(read_exact(cases[i].text, &value, &used));
        assert_true(value == cases[i].value);
        assert_int_equal(used, cases[i].used);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_printed_doubles), cmocka_unit_test(test_random_digits),
        cmocka_unit_test(test_boundaries),      cmocka_unit_test(test_long_digits),
        cmocka_unit_test(test_not_finite),      cmocka_unit_test(test_rejects),
        cmocka_unit_test(test_stops),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
