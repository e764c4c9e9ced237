/* Scratch files for the tests of JSON. */
#ifndef TEST_JSON_FILES_H
#define TEST_JSON_FILES_H

#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <stipple/scene.h>
#include <stipple/view.h>

#include "../log_book.h"

static inline char *in_folder(const char *folder, const char *name, char path[PATH_MAX])
{
    snprintf(path, PATH_MAX, "%s/%s", folder, name);
    return path;
}

static inline void put_file(const char *folder, const char *name, const char *text)
{
    char path[PATH_MAX];
    FILE *file = fopen(in_folder(folder, name, path), "wb");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static inline int make_folder(void **state)
{
    static char folder[64];
    strcpy(folder, "/tmp/stipple-test-XXXXXX");
    *state = mkdtemp(folder);
    return *state ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    char line[128];
    snprintf(line, sizeof line, "rm -r %s", (const char *)*state);
    return system(line);
}

/* Loads a file of the folder, "" the folder itself: one error line when it fails, else a scene. */
static inline enum stp_result load_named(const char *folder, const char *name,
                                         const struct stp_load_params *params,
                                         struct log_book *book, struct stp_scene **scene)
{
    char path[PATH_MAX];
    struct stp_env env = logged_env(book, 0);
    *scene = NULL;
    enum stp_result result = stp_scene_load(&env, in_folder(folder, name, path), params, scene);
    assert_int_equal(book->errors, result != STP_OK);
    assert_true((*scene != NULL) == (result == STP_OK));
    return result;
}

#endif
