/* Log lines: one line each, whatever is printed into them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/log.h"

static void note(void *user, enum stp_log_level level, const char *line)
{
    snprintf(user, 2048, "%d %s", level, line);
}

static void test_one_line(void **state)
{
    char seen[2048];
    struct stp_env env = { .log = note, .user = seen };
    assert_int_equal(log_error(&env, STP_ERROR_IO, "%s: a\tb", "na\nme\x1b[2J\x7f\r"),
                     STP_ERROR_IO);
    assert_string_equal(seen, "0 na?me?[2J??: a?b");
    log_warning(&env, "%s", "gr\xc3\xbc\xc3\x9f"); /* UTF-8 stays */
    assert_string_equal(seen, "1 gr\xc3\xbc\xc3\x9f");
    log_info(&env, "plain ~ %d", 7);
    assert_string_equal(seen, "2 plain ~ 7");
}

static void test_long(void **state)
{
    char seen[2048], name[3000];
    struct stp_env env = { .log = note, .user = seen };
    memset(name, 'n', sizeof name);
    name[sizeof name - 1] = 0;
    log_warning(&env, "%s", name);
    assert_int_equal(strlen(seen), 2 + 1023);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_one_line),
                                        cmocka_unit_test(test_long) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
