/* PLY that lies or stops: one line that names the byte and the element, and nothing is allocated
 * for what cannot be there. */
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "support.h"

#define XYZ "property float x\nproperty float y\nproperty float z\n"

static void test_headers(void **state)
{
    static const char *const cases[][2] = {
        { "ply\nformat ascii 1.0\nelement vertex 1\n" XYZ, "no end_header" },
        { "ply\n", "no end_header" },
        { "ply\nend_header\n", "no format line" },
        { "ply\nformat ascii 1.1\nend_header\n", "byte 4: an unknown version" },
        { "ply\nformat morse 1.0\nend_header\n", "byte 4: an unknown format" },
        { "ply\nformat ascii 1.0\nformat ascii 1.0\nend_header\n", "byte 21: a format line" },
        { "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "without a valid count" },
        { "ply\nformat ascii 1.0\nelement vertex 1e3\nend_header\n", "without a valid count" },
        { "ply\nformat ascii 1.0\nelement vertex 99999999999999999999\nend_header\n",
          "without a valid count" },
        { "ply\nformat ascii 1.0\nelement vertex\nend_header\n", "without a valid count" },
        { "ply\nformat ascii 1.0\nproperty float x\nend_header\n", "before any element" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n",
          "an unknown type" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\nend_header\n",
          "not an integer" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nproperty float\nend_header\n",
          "an incomplete property" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int\nend_header\n",
          "an incomplete property" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty int x\nend_header\n",
          "has already" },
        { "ply\nformat ascii 1.0\nelephant\nend_header\n", "an unknown keyword" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
          "no scalar property y" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nproperty float y\nend_header\n1\n",
          "no scalar property x" },
        { "ply\nformat ascii 1.0\nelement vertex 1\nend_header\n1\n", "no scalar property x" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        refuse_text(cases[i][0], STP_ERROR_FORMAT, cases[i][1]);
}

static void test_ascii_bodies(void **state)
{
    static const char *const cases[][2] = {
        { "1 2 3\n4 5", "the file ends in vertex 1, at byte 109" },
        { "1 2 3\n4 5 6x\n", "not a number in vertex 1 of 2" },
        { "1 2 three\n4 5 6\n", "not a number in vertex 0 of 2" },
        { "1 2 3\n4 5 \n\n\n\n", "the file ends in vertex 1 of 2" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct buffer b = { 0 };
        put_text(&b, "ply\nformat ascii 1.0\nelement vertex 2\n" XYZ "end_header\n%s", cases[i][0]);
        refuse_buffer(&b, STP_ERROR_FORMAT, cases[i][1]);
        drop(&b);
    }
}

/* The offset is that of the very byte. */
static void test_offset(void **state)
{
    struct buffer b = { 0 };
    char words[64];
    put_text(&b, "ply\nformat ascii 1.0\nelement vertex 2\n" XYZ "end_header\n1 2 3\n4 ");
    snprintf(words, sizeof words, "byte %zu: not a number", b.size);
    put_text(&b, "oops 6\n");
    refuse_buffer(&b, STP_ERROR_FORMAT, words);
    drop(&b);
}

static void put_header(struct buffer *b, const char *count, const char *properties)
{
    put_text(b, "ply\nformat binary_little_endian 1.0\nelement vertex %s\n%send_header\n", count,
             properties);
}

/* Every length short of the whole is refused; the whole is read. */
static void test_truncated_everywhere(void **state)
{
    struct buffer b = { 0 };
    float vertex[3] = { 1, 2, 3 };
    put_header(&b, "4", XYZ);
    size_t header = b.size;
    for (int i = 0; i < 4; i++)
        put_bytes(&b, vertex, sizeof vertex);
    size_t whole = b.size;
    for (b.size = 4; b.size < whole; b.size++)
        refuse_buffer(&b, STP_ERROR_FORMAT, b.size < header ? "no end_header" : "cut short");
    struct cloud cloud;
    struct lines lines;
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    assert_int_equal(cloud.count, 4);
    cloud_release(&cloud);
    drop(&b);
}

/* Counts that no file can hold: refused after two small allocations, header and columns. */
static void test_impossible_counts(void **state)
{
    static const char *const counts[] = { "5", "1000000000", "4294967296", "9999999999999999999",
                                          "1537228672809129302" };
    static const char *const bodies[] = { "ascii", "binary_little_endian", "binary_big_endian" };
    for (size_t i = 0; i < 5; i++)
        for (size_t f = 0; f < 3; f++) {
            struct buffer b = { 0 };
            put_text(&b, "ply\nformat %s 1.0\nelement vertex %s\n" XYZ "end_header\n0 0 0 0 0 0 0",
                     bodies[f], counts[i]);
            mem_fail_at(0);
            refuse_buffer(&b, STP_ERROR_FORMAT, "element \"vertex\" claims");
            assert_in_range(mem_count(), 0, 2);
            drop(&b);
        }
}

static void test_lists(void **state)
{
    struct buffer b = { 0 };
    put_header(&b, "2", XYZ "property list int int l\n");
    float vertex[3] = { 1, 2, 3 };
    int32_t lengths[] = { -1, 5, INT32_MAX };
    static const char *const words[] = { "a list of negative length", "longer than the file",
                                         "longer than the file" };
    size_t header = b.size;
    for (int i = 0; i < 3; i++) {
        b.size = header;
        put_bytes(&b, vertex, sizeof vertex);
        put_bytes(&b, &lengths[i], 4);
        put_bytes(&b, vertex, 12);
        put_bytes(&b, vertex, 4);
        refuse_buffer(&b, STP_ERROR_FORMAT, words[i]);
    }
    drop(&b);
    refuse_text("ply\nformat ascii 1.0\nelement vertex 1\n" XYZ
                "property list uchar int l\nend_header\n1 2 3 4000000000 1 1\n",
                STP_ERROR_FORMAT, "the file ends in vertex 0 of 1");
    refuse_text("ply\nformat ascii 1.0\nelement vertex 1\n" XYZ
                "property list uchar int l\nend_header\n1 2 3 -4 1 1\n",
                STP_ERROR_FORMAT, "a list of impossible length");
}

static void test_elements_before(void **state)
{
    struct buffer b = { 0 };
    put_text(&b, "ply\nformat binary_little_endian 1.0\nelement face 9999999999999999999\n"
                 "property list uchar int v\nelement vertex 1\n" XYZ "end_header\n");
    put_bytes(&b, "\0\0\0\0\0\0\0\0\0\0\0\0", 12);
    refuse_buffer(&b, STP_ERROR_FORMAT, "the file ends in element \"face\", 12 of");
    drop(&b);
    put_text(&b, "ply\nformat binary_little_endian 1.0\nelement big 9999999999999999999\n"
                 "property double v\nelement vertex 1\n" XYZ "end_header\n0123456789ab");
    refuse_buffer(&b, STP_ERROR_FORMAT, "the file ends in element \"big\", 1 of");
    drop(&b);
    /* Nothing times a great many is nothing. */
    put_text(&b, "ply\nformat binary_little_endian 1.0\nelement none 9999999999999999999\n"
                 "element vertex 1\n" XYZ "end_header\n0123456789ab");
    struct cloud cloud;
    struct lines lines;
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    assert_int_equal(cloud.count, 1);
    cloud_release(&cloud);
    drop(&b);
    put_text(&b, "ply\nformat ascii 1.0\nelement none 9999999999999999999\nproperty int a\n"
                 "element vertex 1\n" XYZ "end_header\n1\n2\n3\n");
    refuse_buffer(&b, STP_ERROR_FORMAT, "element \"vertex\" claims");
    drop(&b);
}

static void test_bounds(void **state)
{
    struct buffer b = { 0 };
    put_text(&b, "ply\nformat ascii 1.0\nelement vertex 1\n");
    for (int i = 0; i < 1025; i++)
        put_text(&b, "property float p%d\n", i);
    put_text(&b, "end_header\n");
    refuse_buffer(&b, STP_ERROR_FORMAT, "too many properties");
    drop(&b);
    put_text(&b, "ply\nformat ascii 1.0\n");
    for (int i = 0; i < 65; i++)
        put_text(&b, "element e%d 0\n", i);
    put_text(&b, "end_header\n");
    refuse_buffer(&b, STP_ERROR_FORMAT, "too many elements");
    drop(&b);
    put_text(&b, "ply\nformat ascii 1.0\ncomment ");
    for (int i = 0; i < 4300; i++)
        put_text(&b, "%02000d", 0);
    put_text(&b, "\nend_header\n");
    refuse_buffer(&b, STP_ERROR_FORMAT, "no end_header");
    drop(&b);
}

static void test_gaussians(void **state)
{
    refuse_text("ply\nformat ascii 1.0\nelement vertex 1\n" XYZ
                "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
                "property float opacity\nproperty float scale_0\nproperty float rot_0\n"
                "end_header\n1 2 3 4 5 6 7 8 9\n",
                STP_ERROR_FORMAT, "3D Gaussian splatting PLY");
    refuse_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty uint packed_position\n"
                "property uint packed_rotation\nproperty uint packed_scale\n"
                "property uint packed_color\nend_header\n1 2 3 4\n",
                STP_ERROR_FORMAT, "3D Gaussian splatting PLY");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_headers),
        cmocka_unit_test(test_ascii_bodies),
        cmocka_unit_test(test_offset),
        cmocka_unit_test(test_truncated_everywhere),
        cmocka_unit_test(test_impossible_counts),
        cmocka_unit_test(test_lists),
        cmocka_unit_test(test_elements_before),
        cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_gaussians),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
