/* One version: of the project, the headers and the library. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>
#include <stipple/stipple.h>

static void one_version(void **state)
{
    assert_string_equal(STP_VERSION, PROJECT_VERSION);
    assert_string_equal(stp_version(), PROJECT_VERSION);
    int major = -1, minor = -1, patch = -1;
    assert_int_equal(sscanf(PROJECT_VERSION, "%d.%d.%d", &major, &minor, &patch), 3);
    assert_int_equal(STP_VERSION_NUMBER, 10000 * major + 100 * minor + patch);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(one_version) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
