/* half_from_float at, between and beside every pair of neighbouring halfs. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "write/half.h"

/* By the definition of binary16. */
static double value_of(unsigned half)
{
    int exponent = (int)(half >> 10 & 31), mantissa = (int)(half & 1023);
    double magnitude = exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24);
    return half & 0x8000 ? -magnitude : magnitude;
}

static void test_every_half(void **state)
{
    for (unsigned h = 0; h < 0x7c00; h++) {
        assert_int_equal(half_from_float((float)value_of(h)), h);
        assert_int_equal(half_from_float((float)value_of(h | 0x8000)), h | 0x8000);
    }
}

static void test_between(void **state)
{
    for (unsigned h = 0; h < 0x7bff; h++) {
        float middle = (float)((value_of(h) + value_of(h + 1)) / 2);
        unsigned even = h % 2 ? h + 1 : h;
        assert_int_equal(half_from_float(middle), even);
        assert_int_equal(half_from_float(-middle), even | 0x8000);
        assert_int_equal(half_from_float(nextafterf(middle, 0)), h);
        assert_int_equal(half_from_float(nextafterf(middle, 1e9f)), h + 1);
    }
}

static void test_ends(void **state)
{
    assert_int_equal(half_from_float(0.0f), 0);
    assert_int_equal(half_from_float(-0.0f), 0x8000);
    assert_int_equal(half_from_float(1e-40f), 0);
    assert_int_equal(half_from_float(65504), 0x7bff);
    assert_int_equal(half_from_float(65505), 0x7bff);
    assert_int_equal(half_from_float(65520), 0x7bff);
    assert_int_equal(half_from_float(1e30f), 0x7bff);
    assert_int_equal(half_from_float(INFINITY), 0x7bff);
    assert_int_equal(half_from_float(-INFINITY), 0xfbff);
    assert_int_equal(half_from_float(NAN) & 0x7fff, 0x7e00);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_half),
        cmocka_unit_test(test_between),
        cmocka_unit_test(test_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
