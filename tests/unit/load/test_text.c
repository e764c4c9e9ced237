/* Plain text points and OFF. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support.h"

static double srgb(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void expect_123456(struct cloud cloud)
{
    assert_int_equal(cloud.count, 2);
    assert_string_equal(cloud.format, "text");
    for (int i = 0; i < 6; i++)
        assert_true(cloud.position[i / 3][i % 3] == i + 1);
    cloud_release(&cloud);
}

static void test_separators(void **state)
{
    static const char *const texts[] = {
        "1 2 3\n4 5 6\n",          "1 2 3\r\n4 5 6\r\n",
        "1 2 3\r4 5 6\r",          "1,2,3\n4,5,6",
        "1, 2, 3\n4, 5, 6\n",      "1;2;3\n4;5;6\n",
        "1\t2\t3\n4\t5\t6\n",      "  1  2 3 \n\n\n 4 5 6",
        "# x\n1 2 3\n#\n4 5 6\n",  "// c\n1 2 3\n4 5 6 # end\n",
        "2\n1 2 3\n4 5 6\n",       "x y z\n1 2 3\n4 5 6\n",
        "X,Y,Z\n1,2,3\n4,5,6\n",   "\"x\";\"y\";\"z\"\n1;2;3\n4;5;6\n",
        "//X Y Z\n1 2 3\n4 5 6\n", "2\n# c\nx y z\n1 2 3\n4 5 6\n",
        "1,2,3,\n4,5,6,\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        expect_123456(read_text(texts[i]));
}

static void test_normals(void **state)
{
    struct cloud c = read_text("1 2 3 0 0 1\n4 5 6 0.6 -0.8 0\n");
    assert_true(c.normal && !c.color);
    assert_true(c.normal[1][0] == 0.6f && c.normal[1][1] == -0.8f);
    cloud_release(&c);
    c = read_text("1 2 3 0 0 1 255 128 0\n4 5 6 0.6 -0.8 0 0 0 1\n");
    assert_true(c.normal && c.color && c.color[0][1] == (float)srgb(128 / 255.0));
    cloud_release(&c);
    c = read_text("1 2 3 255 128 0 0 0 1\n4 5 6 0 0 1 0.6 -0.8 0\n");
    assert_true(c.normal && c.color && c.color[0][0] == 1 && c.normal[1][1] == -0.8f);
    cloud_release(&c);
}

static void test_colors(void **state)
{
    struct cloud c = read_text("1 2 3 255 128 0\n4 5 6 1 2 3\n");
    assert_true(c.color && !c.normal && c.color[0][1] == (float)srgb(128 / 255.0));
    cloud_release(&c);
    c = read_text("1 2 3 0.25 0.5 0.75\n4 5 6 0 0 0.1\n");
    assert_true(c.color && !c.normal && c.color[0][1] == 0.5f);
    cloud_release(&c);
    c = read_text("1 2 3 65535 0 300\n4 5 6 1 2 3\n");
    assert_true(c.color && c.color[0][0] == 1 && c.color[0][2] == (float)srgb(300 / 65535.0));
    cloud_release(&c);
    c = read_text("1 2 3 -700 1500 2000.5\n4 5 6 1 2 3\n"); /* neither: three scalars */
    assert_true(!c.color && !c.normal);
    cloud_release(&c);
}

static struct cloud read_by(const char *text, const char *color_by)
{
    struct load_options options = { .color_by = color_by };
    struct buffer b = { 0 };
    struct lines lines;
    struct cloud cloud;
    put_bytes(&b, text, strlen(text));
    assert_int_equal(read_buffer(&b, &options, 1, &cloud, &lines), STP_OK);
    drop(&b);
    return cloud;
}

static void test_intensity(void **state)
{
    struct cloud c = read_by("1 2 3 700\n4 5 6 -2\n", "intensity");
    assert_true(c.fields->value[0] == 700 && c.fields->value[1] == -2 && c.color);
    cloud_release(&c);
    /* PTS: a count, then intensity before the colour. */
    static const char pts[] = "2\n1 2 3 100 255 128 0\n4 5 6 90 1 2 3\n";
    c = read_by(pts, "intensity");
    assert_true(c.fields->value[0] == 100);
    cloud_release(&c);
    c = read_text(pts);
    assert_true(c.color[0][0] == 1 && c.color[0][2] == 0);
    cloud_release(&c);
    c = read_text("1 2 3 255 128 0 100\n4 5 6 1 2 3 90\n"); /* no count: the colour comes first */
    assert_true(c.color[0][0] == 1 && c.color[0][2] == 0);
    cloud_release(&c);
    c = read_text("1 2 3 -1200 255 128 0\n4 5 6 90 1 2 3\n");
    assert_true(c.color[0][0] == 1);
    cloud_release(&c);
}

static void test_names(void **state)
{
    static const char text[] = "//Z,X,Y,Label,B,G,R,Nx,Ny,Nz,Reflectance\n"
                               "3,1,2,7,0,128,255,0,0,5,0.5\n6,4,5,8,0,0,0,1,0,0,0.25\n";
    struct cloud c = read_text(text);
    for (int i = 0; i < 6; i++)
        assert_true(c.position[i / 3][i % 3] == i + 1);
    assert_true(c.color[0][0] == 1 && c.color[0][2] == 0 && c.normal[0][2] == 5);
    cloud_release(&c);
    c = read_by(text, "Reflectance");
    assert_true(c.fields->value[1] == 0.25f);
    cloud_release(&c);
    c = read_by(text, "class");
    assert_true(c.fields->value[1] == 8);
    assert_string_equal(c.fields->name, "Label");
    cloud_release(&c);
}

static void test_errors(void **state)
{
    refuse_text("1 2 3\n4 5\n", STP_ERROR_FORMAT, "a number is missing in point 1 of 2");
    refuse_text("1 2 3\n4 5 x\n", STP_ERROR_FORMAT, "byte 10: not a number in point 1 of 2");
    refuse_text("3\n1 2 3\n4 5 6\n", STP_ERROR_FORMAT, "claims 3 points, the file ends after 2");
    refuse_text("1,5;2,5;3,5\n", STP_ERROR_FORMAT, "decimal commas");
    refuse_text("1,5 2,5 3,5\n", STP_ERROR_FORMAT, "decimal commas");
    refuse_text("1,5\t2\t3,5\n", STP_ERROR_FORMAT, "decimal commas");
    refuse_text("2\n3\n0 0 0\n1 0 0\n", STP_ERROR_FORMAT, "PTX");
    refuse_text("1 2\n3 4\n", STP_ERROR_FORMAT, "not a point file");
    refuse_text("hello world\nhow are you\n", STP_ERROR_FORMAT, "not a point file");
    refuse_text("", STP_ERROR_FORMAT, "empty");
}

static void test_nothing(void **state)
{
    static const char *const texts[] = { "# nothing here\n", "\n\n", "0\n", "x y z\n" };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct cloud c = read_text(texts[i]);
        assert_int_equal(c.count, 0);
        cloud_release(&c);
    }
}

/* Several blocks, any number of threads. */
static void test_threads(void **state)
{
    struct buffer b = { 0 };
    struct lines lines;
    struct cloud one, many;
    uint64_t seed = 21;
    for (int i = 0; i < 20000; i++) {
        put_text(&b, "%.17g %.6f %d %d %d %d\n", (double)next_random(&seed) * 1e-3,
                 (double)(next_random(&seed) >> 50), i, i % 256, 7, 255);
        if (i % 100 == 0)
            put_text(&b, "# %d\n\n", i);
    }
    assert_int_equal(read_buffer(&b, NULL, 1, &one, &lines), STP_OK);
    assert_int_equal(read_buffer(&b, NULL, 4, &many, &lines), STP_OK);
    assert_int_equal(one.count, 20000);
    for (int i = 0; i < 20000; i++)
        assert_true(one.position[i][2] == i);
    assert_true(same_cloud(&one, &many));
    cloud_release(&one);
    cloud_release(&many);
    drop(&b);
}

static void test_off(void **state)
{
    static const char *const texts[] = {
        "OFF\n2 0 0\n1 2 3\n4 5 6\n",
        "OFF 2 0 0\n1 2 3\n4 5 6\n",
        "OFF # comment\n# another\n2 1 0\n\n1 2 3 # a\n 4 5 6\n3 0 1 0\n",
        "# first\nOFF\r\n2 1 3\r\n1 2 3\r\n4 5 6\r\n3 0 1 1 255 0 0\r\n",
        "OFF\n2\n1 2 3\n4 5 6\n",
        "OFF\n2 0 0\n1 2 3 9 9 9\n4 5 6 9 9 9\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct cloud c = read_text(texts[i]);
        assert_int_equal(c.count, 2);
        assert_string_equal(c.format, "OFF");
        assert_true(!c.normal && !c.color);
        for (int k = 0; k < 6; k++)
            assert_true(c.position[k / 3][k % 3] == k + 1);
        cloud_release(&c);
    }
}

static void test_off_attributes(void **state)
{
    struct cloud c = read_text("COFF\n2 0 0\n1 2 3 255 128 0 255\n4 5 6 0 0 0 51\n");
    assert_true(c.color[0][1] == (float)srgb(128 / 255.0) && c.opacity[1] == 0.2f);
    cloud_release(&c);
    c = read_text("COFF\n1 0 0\n1 2 3 0.25 0.5 1\n");
    assert_true(c.color[0][1] == 0.5f && !c.opacity);
    cloud_release(&c);
    c = read_text("NOFF\n1 0 0\n1 2 3 0 0.5 1\n");
    assert_true(c.normal[0][1] == 0.5f && !c.color);
    cloud_release(&c);
    static const char *const both[] = { "CNOFF", "NCOFF" };
    for (int i = 0; i < 2; i++) {
        char text[100];
        snprintf(text, sizeof text, "%s\n1 0 0\n1 2 3 0 0.5 1 1 0.25 0 0.5\n", both[i]);
        c = read_text(text);
        assert_true(c.normal[0][1] == 0.5f && c.color[0][1] == 0.25f && c.opacity[0] == 0.5f);
        assert_string_equal(c.format, both[i]);
        cloud_release(&c);
    }
    c = read_text("OFF\n0 0 0\n");
    assert_int_equal(c.count, 0);
    cloud_release(&c);
}

static void test_off_errors(void **state)
{
    refuse_text("OFF\n", STP_ERROR_FORMAT, "no count of vertices");
    refuse_text("OFF\n-3 0 0\n", STP_ERROR_FORMAT, "an impossible count");
    refuse_text("OFF\n2.5 0 0\n", STP_ERROR_FORMAT, "an impossible count");
    refuse_text("OFF\n4000000000 0 0\n1 2 3\n", STP_ERROR_FORMAT, "more vertices claimed");
    refuse_text("OFF\n3 0 0\n1.5 2.5 3.5\n4.5 5.5 6.5\n", STP_ERROR_FORMAT,
                "the file ends in vertex 2 of 3");
    refuse_text("OFF\n2 0 0\n1 2 3\n4 5 z\n", STP_ERROR_FORMAT, "not a number in vertex 1 of 2");
    refuse_text("OFF BINARY\n", STP_ERROR_FORMAT, "binary OFF");
    refuse_text("4OFF\n1 0 0\n1 2 3 4\n", STP_ERROR_FORMAT, "other than three dimensions");
    refuse_text("COFF\n1 0 0\n1 2 3\n", STP_ERROR_FORMAT, "COFF needs 6");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_separators), cmocka_unit_test(test_normals),
        cmocka_unit_test(test_colors),     cmocka_unit_test(test_intensity),
        cmocka_unit_test(test_names),      cmocka_unit_test(test_errors),
        cmocka_unit_test(test_nothing),    cmocka_unit_test(test_threads),
        cmocka_unit_test(test_off),        cmocka_unit_test(test_off_attributes),
        cmocka_unit_test(test_off_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
