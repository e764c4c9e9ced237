/* Device profiles: read back what `stipple devices --json` writes, and refused when damaged. */
#include "plans.h"

#include <unistd.h>

static const char *const good =
    "{\"device\": \"Fast \\\"GPU\\\"\", \"driver\": \"1.2.3\",\n"
    " \"features\": [\"int64-atomics\", \"vertex-layer\", \"float32-blend\", \"int64\", "
    "\"float64\", \"storage-formats\"],\n"
    " \"heap_bytes\": 8589934592, \"max_allocation\": 4294967292, \"max_image_size\": 32768,\n"
    " \"max_image_layers\": 2048, \"max_workgroups\": 2147483647, \"max_texels\": 134217728,\n"
    " \"processor\": 2}\n";

static enum stp_result load(const char *text, struct plan_log *log, struct stp_limits *limits)
{
    char path[] = "/tmp/stipple-limits-XXXXXX";
    struct stp_env env = { .log = plan_keep_line, .user = log };
    int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), strlen(text));
    close(file);
    *log = (struct plan_log){ 0 };
    enum stp_result result = stp_limits_load(&env, path, limits);
    if (result != STP_OK)
        assert_non_null(strstr(log->last, path));
    unlink(path);
    return result;
}

static void test_read(void **state)
{
    struct plan_log log;
    struct stp_limits limits;
    memset(&limits, 0xaa, sizeof limits);
    assert_int_equal(load(good, &log, &limits), STP_OK);
    assert_int_equal(log.lines, 0);
    assert_string_equal(limits.device, "Fast \"GPU\"");
    assert_string_equal(limits.driver, "1.2.3");
    assert_int_equal(limits.features, 63);
    assert_true(limits.heap_bytes == 8589934592u && limits.max_allocation == 4294967292u);
    assert_true(limits.max_image_size == 32768 && limits.max_image_layers == 2048);
    assert_true(limits.max_workgroups == 2147483647 && limits.max_texels == 1 << 27);
    assert_int_equal(limits.processor, 2);
}

/* A profile with one part replaced: what it is, and a word of the line. */
static void test_damaged(void **state)
{
    static const struct {
        const char *part, *instead, *word;
    } cases[] = {
        { "8589934592", "-1", "heap_bytes" },
        { "8589934592", "1e300", "heap_bytes" },
        { "8589934592", "\"8 GiB\"", "heap_bytes" },
        { "\"heap_bytes\"", "\"heap\"", "heap_bytes" },
        { "4294967292", "0", "max_allocation" },
        { "32768", "4294967296", "max_image_size" },
        { "32768", "32768.5", "max_image_size" },
        { "2048", "null", "max_image_layers" },
        { "134217728", "4294967296", "max_texels" },
        { "\"max_texels\": 134217728,", "", "max_texels" },
        { "\"processor\": 2", "\"processor\": 3", "processor" },
        { ",\n \"processor\": 2", "", "processor" },
        { "\"int64\"", "\"int46\"", "features" },
        { "\"int64\"", "64", "features" },
        { "\"features\": [", "\"feature\": [", "features" },
        { "\"Fast \\\"GPU\\\"\"", "7", "device" },
        { "}", "", "" },
        { "{", "[", "" },
    };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[1024];
        struct plan_log log;
        struct stp_limits limits, before;
        const char *at = strstr(good, cases[i].part);
        assert_non_null(at);
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - good), good, cases[i].instead,
                 at + strlen(cases[i].part));
        memset(&limits, 0x55, sizeof limits);
        before = limits;
        enum stp_result result = load(text, &log, &limits);
        if (result != STP_ERROR_FORMAT || !strstr(log.last, cases[i].word))
            fail_msg("%s for %s: result %d: %s", cases[i].instead, cases[i].part, result, log.last);
        assert_memory_equal(&limits, &before, sizeof limits);
    }
}

static void test_missing(void **state)
{
    struct plan_log log = { 0 };
    struct stp_env env = { .log = plan_keep_line, .user = &log };
    struct stp_limits limits;
    assert_int_equal(stp_limits_load(&env, "/nonexistent/limits.json", &limits), STP_ERROR_IO);
    assert_int_equal(log.lines, 1);
}

static void test_feature_names(void **state)
{
    static const char *const names[] = { "int64-atomics",   "vertex-layer",      "float32-blend",
                                         "int64",           "float64",           "storage-formats",
                                         "shared-memory",   "independent-blend", "texel-buffers",
                                         "subgroup-shuffle" };
    for (unsigned i = 0; i < 10; i++)
        assert_string_equal(stp_feature_name((enum stp_feature)(1 << i)), names[i]);
    assert_null(stp_feature_name((enum stp_feature)1024));
    assert_null(stp_feature_name((enum stp_feature)3));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_read),
        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_missing),
        cmocka_unit_test(test_feature_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
