/* Raw components to linear ones, and scalars to colours. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/color.h"
#include "support.h"

static double srgb(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* One vertex a line: x y z red green blue. */
static struct cloud read_colors(const char *type, const char *values, enum stp_transfer transfer,
                                unsigned warnings)
{
    struct load_options options = { .transfer = transfer };
    struct buffer b = { 0 };
    struct cloud cloud;
    struct lines lines;
    unsigned count = 0;
    for (const char *at = values; *at; at++)
        count += *at == '\n';
    put_text(&b,
             "ply\nformat ascii 1.0\nelement vertex %u\nproperty float x\nproperty float y\n"
             "property float z\nproperty %s red\nproperty %s green\nproperty %s blue\n"
             "end_header\n",
             count, type, type, type);
    for (const char *at = values; *at; at = strchr(at, '\n') + 1)
        put_text(&b, "0 0 0 %.*s", (int)(strchr(at, '\n') - at) + 1, at);
    assert_int_equal(read_buffer(&b, &options, 1, &cloud, &lines), STP_OK);
    assert_int_equal(lines.warnings, warnings);
    assert_non_null(cloud.color);
    drop(&b);
    return cloud;
}

static void expect(const struct cloud *cloud, size_t row, double r, double g, double b)
{
    float wanted[3] = { (float)r, (float)g, (float)b };
    assert_memory_equal(cloud->color[row], wanted, sizeof wanted);
}

static void test_all_bytes(void **state)
{
    struct buffer b = { 0 };
    struct cloud cloud;
    struct lines lines;
    put_text(&b, "ply\nformat binary_little_endian 1.0\nelement vertex 256\nproperty uchar x\n"
                 "property uchar y\nproperty uchar z\nproperty uchar red\nproperty uchar green\n"
                 "property uchar blue\nproperty uchar alpha\nend_header\n");
    for (int i = 0; i < 256; i++) {
        unsigned char row[] = {
            1, 2, 3, (unsigned char)i, (unsigned char)(255 - i), 77, (unsigned char)i
        };
        put_bytes(&b, row, sizeof row);
    }
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    for (size_t i = 0; i < 256; i++) {
        expect(&cloud, i, srgb((double)i / 255), srgb((255 - (double)i) / 255), srgb(77 / 255.0));
        assert_true(cloud.opacity[i] == (float)((double)i / 255));
    }
    cloud_release(&cloud);
    drop(&b);
}

static void test_integer_types(void **state)
{
    struct cloud c = read_colors("uchar", "0 128 255\n", STP_TRANSFER_AUTO, 0);
    expect(&c, 0, 0, srgb(128 / 255.0), 1);
    cloud_release(&c);
    c = read_colors("char", "-1 -128 127\n", STP_TRANSFER_AUTO, 0); /* the bits of 255, 128 */
    expect(&c, 0, 1, srgb(128 / 255.0), srgb(127 / 255.0));
    cloud_release(&c);
    c = read_colors("ushort", "65535 300 0\n1 2 3\n", STP_TRANSFER_AUTO, 0);
    expect(&c, 0, 1, srgb(300 / 65535.0), 0);
    expect(&c, 1, srgb(1 / 65535.0), srgb(2 / 65535.0), srgb(3 / 65535.0));
    cloud_release(&c);
    c = read_colors("ushort", "255 100 0\n", STP_TRANSFER_AUTO, 0); /* 8 bits in 16 */
    expect(&c, 0, 1, srgb(100 / 255.0), 0);
    cloud_release(&c);
    c = read_colors("int", "255 100 0\n", STP_TRANSFER_AUTO, 0);
    expect(&c, 0, 1, srgb(100 / 255.0), 0);
    cloud_release(&c);
    c = read_colors("uchar", "0.25 0.5 1\n", STP_TRANSFER_AUTO, 0); /* not integers after all */
    expect(&c, 0, 0.25, 0.5, 1);
    cloud_release(&c);
}

static void test_floats(void **state)
{
    struct cloud c = read_colors("float", "0.25 0.5 1\n", STP_TRANSFER_AUTO, 0);
    expect(&c, 0, 0.25, 0.5, 1);
    cloud_release(&c);
    c = read_colors("float", "0.1 0.2 0.9\n0.5 40 900\n", STP_TRANSFER_AUTO, 0); /* radiances */
    expect(&c, 1, 0.5, 40, 900);
    cloud_release(&c);
    c = read_colors("float", "0.1 0.2 0.9\n0.5 0.25 4\n", STP_TRANSFER_AUTO, 0);
    expect(&c, 1, 0.5, 0.25, 4);
    cloud_release(&c);
    c = read_colors("float", "0.1 0.2 0.9\n0.5 0.25 100.5\n", STP_TRANSFER_AUTO, 0);
    expect(&c, 1, 0.5, 0.25, 100.5);
    cloud_release(&c);
    c = read_colors("float", "255 128 0\n", STP_TRANSFER_AUTO, 1);
    expect(&c, 0, 1, srgb(128 / 255.0), 0);
    cloud_release(&c);
    c = read_colors("double", "25.5 12.25 127.5\n", STP_TRANSFER_AUTO, 1);
    expect(&c, 0, srgb(0.1), srgb(12.25 / 255), srgb(0.5));
    cloud_release(&c);
}

static void test_transfer(void **state)
{
    struct cloud c = read_colors("uchar", "0 51 255\n", STP_TRANSFER_LINEAR, 0);
    expect(&c, 0, 0, 0.2, 1);
    cloud_release(&c);
    c = read_colors("float", "0.02 0.5 -0.5\n", STP_TRANSFER_SRGB, 0);
    expect(&c, 0, srgb(0.02f), srgb(0.5), -srgb(0.5));
    cloud_release(&c);
    c = read_colors("float", "255 128 0\n", STP_TRANSFER_LINEAR, 0);
    expect(&c, 0, 255, 128, 0);
    cloud_release(&c);
}

/* Many values take the table; the bits are those of the formula. */
static void test_table_and_formula(void **state)
{
    enum { N = 70000 };
    float(*color)[3] = malloc(N * sizeof *color);
    for (int i = 0; i < N; i++)
        for (int c = 0; c < 3; c++)
            color[i][c] = (float)((i * 3 + c) % 65536);
    color_decode(NULL, "in", color, N, SCALE_INTEGER, STP_TRANSFER_AUTO);
    for (int i = 0; i < N; i += 7)
        for (int c = 0; c < 3; c++)
            assert_true(color[i][c] == (float)srgb((i * 3 + c) % 65536 / 65535.0));
    free(color);
}

static void test_alpha(void **state)
{
    struct cloud c = read_text("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                               "property float y\nproperty float z\nproperty float opacity\n"
                               "end_header\n0 0 0 0\n0 0 0 0\n");
    assert_true(c.opacity && c.opacity[0] == 0); /* floats mean it */
    cloud_release(&c);
    c = read_text("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                  "property float y\nproperty float z\nproperty uchar alpha\n"
                  "end_header\n0 0 0 0\n0 0 0 0\n");
    assert_null(c.opacity); /* a writer that left it out */
    cloud_release(&c);
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void test_percentiles(void **state)
{
    static size_t tally[65536];
    static float value[5000], sorted[5000];
    uint64_t seed = 11;
    for (int round = 0; round < 40; round++) {
        size_t n = 1 + next_random(&seed) % 5000, finite = 0;
        for (size_t i = 0; i < n; i++) {
            uint32_t bits = (uint32_t)next_random(&seed);
            memcpy(&value[i], &bits, 4);
            if (round & 1)
                value[i] = (float)((int)(bits % 21) - 10);
            if (isfinite(value[i]))
                sorted[finite++] = value[i];
        }
        float bounds[2];
        bool any = color_percentiles(value, n, tally, bounds);
        assert_int_equal(any, finite > 0);
        if (!any)
            continue;
        qsort(sorted, finite, sizeof *sorted, compare_floats);
        size_t low = (size_t)((double)(finite - 1) * 0.01 + 0.5);
        assert_true(bounds[0] == sorted[low]);
        assert_true(bounds[1] == sorted[finite - 1 - low]);
    }
}

static double lightness(const float c[3])
{
    double l = cbrt(0.4122214708 * c[0] + 0.5363325363 * c[1] + 0.0514459929 * c[2]);
    double m = cbrt(0.2119034982 * c[0] + 0.6806995451 * c[1] + 0.1073969566 * c[2]);
    double s = cbrt(0.0883024619 * c[0] + 0.2817188376 * c[1] + 0.6299787005 * c[2]);
    return 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
}

/* Lightness in Oklab goes up in even steps, and nothing is clipped. */
static void test_ramp(void **state)
{
    for (int i = 0; i <= 100; i++) {
        float c[3];
        color_ramp_at(i / 100.0, c);
        assert_true(fabs(lightness(c) - (0.35 + 0.5 * i / 100)) < 1e-4);
        for (int k = 0; k < 3; k++)
            assert_true(c[k] > 0 && c[k] < 1);
    }
}

static void test_classes(void **state)
{
    float a[3], b[3], grey[3];
    color_class_at(-1, grey);
    assert_true(grey[0] == grey[1] && grey[1] == grey[2]);
    color_class_at(NAN, a);
    assert_memory_equal(a, grey, sizeof a);
    for (int i = 0; i < 20; i++)
        for (int j = 0; j < i; j++) {
            color_class_at(i, a);
            color_class_at(j, b);
            double d = fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2]);
            assert_true(d > 0.02);
        }
}

static const char fields[] = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                             "property float y\nproperty float z\nproperty uchar red\n"
                             "property uchar green\nproperty uchar blue\nproperty float quality\n"
                             "property ushort scalar_Classification\n"
                             "property list uchar int tags\nend_header\n"
                             "1 0 0 10 20 30 0 2 0\n2 0 0 10 20 30 1 2 0\n"
                             "3 0 0 10 20 30 nan 6 0\n4 0 0 10 20 30 2 65535 0\n";

static enum stp_result read_by(const char *name, struct cloud *cloud, struct lines *lines)
{
    struct load_options options = { .color_by = name };
    struct buffer b = { 0 };
    put_text(&b, "%s", fields);
    enum stp_result result = read_buffer(&b, &options, 1, cloud, lines);
    drop(&b);
    return result;
}

static void test_color_by_scalar(void **state)
{
    struct cloud cloud;
    struct lines lines;
    float low[3], high[3], middle[3];
    color_ramp_at(0, low);
    color_ramp_at(0.5, middle);
    color_ramp_at(1, high);
    assert_int_equal(read_by("quality", &cloud, &lines), STP_OK);
    assert_int_equal(cloud.field_count, 1);
    assert_string_equal(cloud.fields->name, "quality");
    assert_true(cloud.fields->value[1] == 1);
    assert_memory_equal(cloud.color[0], low, sizeof low);
    assert_memory_equal(cloud.color[1], middle, sizeof low);
    assert_memory_equal(cloud.color[3], high, sizeof low);
    assert_true(cloud.color[2][0] == cloud.color[2][1]); /* NaN: grey */
    cloud_release(&cloud);
    assert_int_equal(read_by("x", &cloud, &lines), STP_OK); /* a coordinate is a field too */
    assert_true(cloud.position[3][0] == 4 && cloud.fields->value[3] == 4);
    cloud_release(&cloud);
}

static void test_color_by_class(void **state)
{
    static const char *const names[] = { "class", "classification", "label",
                                         "scalar_Classification" };
    for (int i = 0; i < 4; i++) {
        struct cloud cloud;
        struct lines lines;
        float two[3];
        color_class_at(2, two);
        assert_int_equal(read_by(names[i], &cloud, &lines), STP_OK);
        assert_memory_equal(cloud.color[0], two, sizeof two);
        assert_memory_equal(cloud.color[1], two, sizeof two);
        assert_true(memcmp(cloud.color[2], two, sizeof two) != 0);
        cloud_release(&cloud);
    }
}

static void test_color_by_others(void **state)
{
    struct cloud cloud;
    struct lines lines;
    assert_int_equal(read_by("rgb", &cloud, &lines), STP_OK);
    assert_true(cloud.color[0][0] == (float)srgb(10 / 255.0));
    assert_int_equal(cloud.field_count, 0);
    cloud_release(&cloud);
    assert_int_equal(read_by("height", &cloud, &lines), STP_OK);
    assert_null(cloud.color);
    cloud_release(&cloud);
    assert_int_equal(read_by("normal", &cloud, &lines), STP_OK);
    assert_null(cloud.color);
    cloud_release(&cloud);
    assert_int_equal(read_by("intensity", &cloud, &lines), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(lines.error, "quality, scalar_Classification"));
    assert_null(strstr(lines.error, "tags"));
}

static void test_one_value(void **state)
{
    struct cloud cloud;
    struct lines lines;
    float middle[3];
    assert_int_equal(read_by("y", &cloud, &lines), STP_OK);
    color_ramp_at(0.5, middle);
    assert_memory_equal(cloud.color[0], middle, sizeof middle);
    cloud_release(&cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_bytes),
        cmocka_unit_test(test_integer_types),
        cmocka_unit_test(test_floats),
        cmocka_unit_test(test_transfer),
        cmocka_unit_test(test_table_and_formula),
        cmocka_unit_test(test_alpha),
        cmocka_unit_test(test_percentiles),
        cmocka_unit_test(test_ramp),
        cmocka_unit_test(test_classes),
        cmocka_unit_test(test_color_by_scalar),
        cmocka_unit_test(test_color_by_class),
        cmocka_unit_test(test_color_by_others),
        cmocka_unit_test(test_one_value),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
