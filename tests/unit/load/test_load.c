/* Files on disk: probing by content, gzip, refusals by name, and memory that runs out. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "support.h"
#include <stipple/scene.h>

static const char ply[] = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                          "property float y\nproperty float z\nproperty uchar red\n"
                          "property uchar green\nproperty uchar blue\nproperty uchar alpha\n"
                          "property float nx\nproperty float ny\nproperty float nz\n"
                          "property float radius\nproperty float intensity\nend_header\n"
                          "1 2 3 9 9 9 9 0 0 1 7 1\n4 5 6 9 9 9 9 0 0 1 7 2\n";

static void quiet(void *user, enum stp_log_level level, const char *line)
{
    (*(unsigned *)user) += level == STP_LOG_ERROR;
}

static void make_name(char name[32])
{
    strcpy(name, "/tmp/test_load.XXXXXX");
    int fd = mkstemp(name);
    assert_true(fd >= 0);
    close(fd);
}

static void test_file_and_gzip(void **state)
{
    char name[32];
    make_name(name);
    FILE *file = fopen(name, "wb");
    fwrite(ply, 1, sizeof ply - 1, file);
    fclose(file);
    struct cloud plain, packed;
    assert_int_equal(read_file(NULL, name, &plain), STP_OK);
    assert_string_equal(plain.format, "PLY ascii");
    gzFile gz = gzopen(name, "wb");
    gzwrite(gz, ply, sizeof ply - 1);
    gzclose(gz);
    assert_int_equal(read_file(NULL, name, &packed), STP_OK);
    assert_string_equal(packed.format, "PLY ascii, gzip");
    strcpy(packed.format, plain.format);
    assert_true(same_cloud(&plain, &packed));
    cloud_release(&plain);
    cloud_release(&packed);
    unlink(name);
    unsigned errors = 0;
    struct stp_env env = { .log = quiet, .user = &errors };
    assert_int_equal(read_file(&env, name, &plain), STP_ERROR_IO);
    assert_int_equal(errors, 1);
}

static void test_known_formats(void **state)
{
    static const char *const cases[][2] = {
        { "ASTM-E57", "E57" },
        { "glTF\2", "binary glTF" },
        { "solid thing\nfacet normal 0 0 1\n", "STL" },
        { "\x89PNG\r\n", "PNG" },
        { "\x76\x2f\x31\x01", "OpenEXR" },
        { "PK\3\4", "zip" },
        { "{\"asset\":{}}", "JSON" },
        { "\x93NUMPY", "NumPy" },
        { "# vtk DataFile Version 3.0\n1 2 3\n", "VTK" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        refuse_text(cases[i][0], STP_ERROR_FORMAT, cases[i][1]);
    struct buffer b = { 0 };
    unsigned char stl[134] = { 0 };
    stl[80] = 1;
    put_bytes(&b, stl, sizeof stl);
    refuse_buffer(&b, STP_ERROR_FORMAT, "binary STL");
    b.size--;
    refuse_buffer(&b, STP_ERROR_FORMAT, "not a point file");
    drop(&b);
}

static void fail_everywhere(const char *text, const char *color_by)
{
    struct buffer b = { 0 };
    put_bytes(&b, text, strlen(text));
    fail_each_allocation(&b, color_by);
    drop(&b);
}

static void test_memory(void **state)
{
    fail_everywhere(ply, NULL);
    fail_everywhere(ply, "intensity");
    fail_everywhere("1 2 3 100\n4 5 6 200\n", "intensity");
    fail_everywhere("1 2 3 0 0 1 255 0 0\n4 5 6 1 0 0 9 9 9\n", NULL);
    fail_everywhere("NCOFF\n1 0 0\n1 2 3 0 0 1 9 9 9 9\n", NULL);
    fail_everywhere("v 1 2 3 1 1 1\nvn 0 0 1\nf 1//1\n", NULL);
    fail_everywhere("v 1 2 3\nvn 0 0 1\n", NULL);
}

struct progress {
    double last;
    unsigned calls;
};

/* The mark that UTF-8 may begin with is no part of any format, and of no first point. */
static void test_mark(void **state)
{
    static const char *const texts[] = {
        ply,
        "1 2 3\n4 5 6\n",
        "x,y,z\n1,2,3\n4,5,6\n",
        "OFF\n2 0 0\n1 2 3\n4 5 6\n",
        "v 1 2 3\nv 4 5 6\n",
        ("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
         "POINTS 2\nDATA ascii\n1 2 3\n4 5 6\n"),
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        char marked[1024] = "\xef\xbb\xbf";
        strcat(marked, texts[i]);
        struct cloud plain = read_text(texts[i]), cloud = read_text(marked);
        assert_int_equal(cloud.count, 2);
        assert_true(same_cloud(&plain, &cloud));
        cloud_release(&plain);
        cloud_release(&cloud);
    }
    refuse_text("\xef\xbb\xbf", STP_ERROR_FORMAT, "the file is empty");
    refuse_text("\xef\xbb\xbf{", STP_ERROR_FORMAT, "JSON");
    refuse_text("ply", STP_ERROR_FORMAT, "no end_header");
}

static void note_progress(void *user, const char *stage, double fraction)
{
    struct progress *progress = user;
    assert_string_equal(stage, "load");
    assert_true(fraction >= progress->last);
    progress->last = fraction;
    progress->calls++;
}

static void test_progress(void **state)
{
    char name[32];
    make_name(name);
    FILE *file = fopen(name, "wb");
    fwrite(ply, 1, sizeof ply - 1, file);
    fclose(file);
    struct progress progress = { 0 };
    struct stp_env env = { .progress = note_progress, .user = &progress };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_load(&env, name, NULL, &scene), STP_OK);
    assert_true(progress.calls >= 2 && progress.last == 1);
    stp_scene_destroy(&scene);
    unlink(name);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_file_and_gzip), cmocka_unit_test(test_known_formats),
        cmocka_unit_test(test_mark),          cmocka_unit_test(test_memory),
        cmocka_unit_test(test_progress),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
