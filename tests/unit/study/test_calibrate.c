/* The cache of calibrations, the profiles they are kept as, and the scenes they are measured on. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/memory.h"
#include "scene/scene.h"
#include "study/calibrate.h"

struct lines {
    unsigned count;
    char last[1024];
};

static void keep(void *user, enum stp_log_level level, const char *line)
{
    struct lines *lines = user;
    lines->count++;
    snprintf(lines->last, sizeof lines->last, "%s", line);
}

static int enter(void **state)
{
    static char folder[] = "/tmp/stipple-calibrate-XXXXXX";
    assert_non_null(mkdtemp(folder));
    assert_int_equal(setenv("XDG_CACHE_HOME", folder, 1), 0);
    *state = folder;
    return 0;
}

static int leave(void **state)
{
    char command[256];
    snprintf(command, sizeof command, "rm -r '%s'", (const char *)*state);
    return system(command);
}

static struct stp_limits some_limits(void)
{
    struct stp_limits limits;
    stp_limits_lavapipe(&limits);
    limits.calibration = (struct stp_calibration){ .measured = true };
    for (unsigned kind = 0; plan_cost_name(kind); kind++)
        for (unsigned term = 0; term < PLAN_TERMS; term++)
            limits.calibration.ns[kind][term] = kind + term ? 1.0 / (3 * kind + term) : 0;
    return limits;
}

static char *path_of(const struct stp_limits *limits)
{
    char *path = NULL;
    assert_int_equal(calibrate_cache_path(NULL, limits, &path), STP_OK);
    assert_non_null(path);
    return path;
}

static void round_trip(void **state)
{
    struct lines lines = { 0 };
    struct stp_env env = { .log = keep, .user = &lines };
    struct stp_limits limits = some_limits();
    struct stp_calibration read = { 0 };
    char *path = path_of(&limits);
    bool found = true;
    assert_int_equal(calibrate_cache_read(&env, path, &limits, &read, &found), STP_OK);
    assert_false(found);
    calibrate_cache_write(&env, path, &limits);
    assert_int_equal(calibrate_cache_read(&env, path, &limits, &read, &found), STP_OK);
    assert_true(found);
    assert_memory_equal(&read, &limits.calibration, sizeof read);
    assert_int_equal(lines.count, 0);
    struct stp_limits loaded = { 0 }; /* the cache's file is a profile too */
    assert_int_equal(stp_limits_load(&env, path, &loaded), STP_OK);
    assert_memory_equal(&loaded.calibration, &limits.calibration, sizeof read);
    assert_int_equal(loaded.features, limits.features);
    assert_string_equal(loaded.device, limits.device);
    assert_int_equal(unlink(path), 0);
    mem_free(path);
}

/* A file for each device, driver and version. */
static void names(void **state)
{
    struct stp_limits a = some_limits(), b = a, c = a;
    snprintf(b.device, sizeof b.device, "other");
    snprintf(c.driver, sizeof c.driver, "other");
    char *pa = path_of(&a), *pb = path_of(&b), *pc = path_of(&c), *again = path_of(&a);
    assert_string_equal(pa, again);
    assert_string_not_equal(pa, pb);
    assert_string_not_equal(pa, pc);
    assert_string_not_equal(pb, pc);
    mem_free(pa);
    mem_free(pb);
    mem_free(pc);
    mem_free(again);
}

static void no_place(void **state)
{
    struct stp_limits limits = some_limits();
    char *path = NULL, *home = strdup(getenv("HOME") ? getenv("HOME") : "");
    setenv("XDG_CACHE_HOME", "relative", 1); /* to be ignored */
    setenv("HOME", "/somewhere", 1);
    assert_int_equal(calibrate_cache_path(NULL, &limits, &path), STP_OK);
    assert_int_equal(strncmp(path, "/somewhere/.cache/stipple/", 26), 0);
    mem_free(path);
    path = NULL;
    unsetenv("HOME");
    assert_int_equal(calibrate_cache_path(NULL, &limits, &path), STP_OK);
    assert_null(path);
    setenv("HOME", home, 1);
    setenv("XDG_CACHE_HOME", *state, 1);
    free(home);
}

static void put(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void expect_damaged(const char *path, const struct stp_limits *limits)
{
    struct lines lines = { 0 };
    struct stp_env env = { .log = keep, .user = &lines };
    struct stp_calibration read = { .measured = true, .ns = { { 77 } } };
    bool found = true;
    assert_int_equal(calibrate_cache_read(&env, path, limits, &read, &found), STP_OK);
    assert_false(found);
    assert_int_equal(lines.count, 1);
    assert_true(read.ns[0][0] == 77);
}

/* Cut anywhere, of another device, of the wrong types: one line, and it counts as none. */
static void damaged(void **state)
{
    struct stp_limits limits = some_limits(), other = limits;
    char *path = path_of(&limits), *text = stp_limits_print(&limits);
    calibrate_cache_write(NULL, path, &limits);
    for (size_t length = 0; length < strlen(text); length += 97) {
        char *part = strndup(text, length);
        put(path, part);
        expect_damaged(path, &limits);
        free(part);
    }
    put(path, text); /* whole, but it says no version */
    expect_damaged(path, &limits);
    const char *const wrong[] = { "[]", "{\"calibration\": 3}",
                                  "{\"calibration\": {\"exact id\": 1}}",
                                  "{\"calibration\": {\"exact id\": {\"box\": -1}}}",
                                  "{\"calibration\": {\"exact id\": {\"box\": \"x\"}}}" };
    for (unsigned i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        put(path, wrong[i]);
        expect_damaged(path, &limits);
    }
    snprintf(other.device, sizeof other.device, "other");
    calibrate_cache_write(NULL, path, &other);
    expect_damaged(path, &limits);
    assert_int_equal(unlink(path), 0);
    free(text);
    mem_free(path);
}

static void not_writable(void **state)
{
    struct lines lines = { 0 };
    struct stp_env env = { .log = keep, .user = &lines };
    struct stp_limits limits = some_limits();
    calibrate_cache_write(&env, "/proc/none/stipple/x.json", &limits);
    assert_int_equal(lines.count, 1);
}

static void without_memory(void **state)
{
    struct stp_limits limits = some_limits();
    struct lines lines = { 0 };
    struct stp_env env = { .log = keep, .user = &lines };
    char *path = NULL;
    mem_fail_at(1);
    assert_int_equal(calibrate_cache_path(&env, &limits, &path), STP_ERROR_MEMORY);
    mem_fail_at(0);
    assert_null(path);
    assert_int_equal(lines.count, 1);
}

/* As many splats as said, grouped, and as large on the screen. */
static void scenes(void **state)
{
    for (unsigned i = 0; i < calibrate_scene_count; i++) {
        const struct calibrate_scene *what = &calibrate_scenes[i];
        struct stp_scene *scene = NULL;
        struct stp_camera camera;
        bool clear = what->opacity > 0;
        assert_true(i == 0 || what->color >= what[-1].color || what->opacity > what[-1].opacity);
        if (what->splats > 20000)
            continue;
        assert_int_equal(calibrate_scene_make(NULL, what, &scene, &camera), STP_OK);
        const struct stp_facts *facts = stp_scene_facts(scene);
        assert_true(facts->splats + what->shells > what->splats);
        assert_int_equal(facts->has_color, what->color);
        assert_int_equal(facts->transparent, clear);
        assert_true(clear == (what->overlap == 0));
        assert_true(clear == (facts->grouping.groups == 0));
        double pixels = facts->radius_median * camera.fx / 10;
        assert_true(fabs(pixels / what->radius - 1) < 1e-3);
        stp_scene_destroy(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),   cmocka_unit_test(names),
        cmocka_unit_test(no_place),     cmocka_unit_test(damaged),
        cmocka_unit_test(not_writable), cmocka_unit_test(without_memory),
        cmocka_unit_test(scenes),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
