/* The files of tests/fail/load: each is refused with the words that its line of expected.txt says.
 * The folder is the program's argument. */
#include <dirent.h>
#include <stdio.h>
#include <string.h>

#include "support.h"

static const char *folder;

static void note(void *user, enum stp_log_level level, const char *line)
{
    char *error = user;
    if (level == STP_LOG_ERROR)
        snprintf(error, 1100, "%s", line);
}

static void expect_refusal(const char *name, const char *words)
{
    char path[1024], error[1100] = "";
    struct cloud cloud;
    struct stp_env env = { .log = note, .user = error };
    snprintf(path, sizeof path, "%s/%s", folder, name);
    enum stp_result result = read_file(&env, path, &cloud);
    if (result != STP_ERROR_FORMAT || !strstr(error, words))
        print_error("%s: %d \"%s\"\n", name, result, error);
    assert_int_equal(result, STP_ERROR_FORMAT);
    assert_non_null(strstr(error, words));
    assert_non_null(strstr(error, name));
}

static unsigned count_files(void)
{
    unsigned count = 0;
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        count += entry->d_name[0] != '.' && strcmp(entry->d_name, "expected.txt") != 0;
    closedir(directory);
    return count;
}

static void test_refused(void **state)
{
    char path[1024], line[512];
    unsigned checked = 0;
    snprintf(path, sizeof path, "%s/expected.txt", folder);
    FILE *list = fopen(path, "r");
    assert_non_null(list);
    while (fgets(line, sizeof line, list)) {
        char *words = strchr(line, ' ');
        assert_non_null(words);
        *words++ = 0;
        words[strcspn(words, "\n")] = 0;
        expect_refusal(line, words);
        checked++;
    }
    fclose(list);
    assert_int_equal(checked, count_files());
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_refused) };
    folder = argc > 1 ? argv[1] : "tests/fail/load";
    return cmocka_run_group_tests(tests, NULL, NULL);
}
