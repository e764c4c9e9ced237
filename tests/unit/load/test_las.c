/* LAS: every point format of every version against what was put in, and headers that lie. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

static const unsigned sizes[] = { 20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67 };

/* What a test file is made of; the rest is the same in all. */
struct recipe {
    unsigned format, minor;
    size_t count;
    unsigned extra;           /* bytes after each point, from `extras` */
    const struct buffer *vlr; /* records as they stand in the file, or NULL */
    uint32_t vlrs;
    const struct buffer *evlr;
    uint32_t evlrs;
    unsigned color_most; /* the largest colour; 0: all are 0 */
    bool withhold;       /* every third point */
    bool no_legacy_count;
};

/* The numbers of point i. */
static int32_t raw(size_t i, unsigned axis)
{
    static const int32_t ends[] = { INT32_MIN, INT32_MAX, 0, -1 };
    return i < 4 ? ends[(i + axis) % 4] : (int32_t)(i * 7919 * (axis + 1)) - 50000;
}
static unsigned intensity(size_t i)
{
    return (unsigned)(i * 257) & 0xffff;
}
static unsigned class_of(size_t i, unsigned format)
{
    return format < 6 ? i % 32 : i % 256;
}
static unsigned color(size_t i, unsigned c, unsigned most)
{
    return most ? (unsigned)((i * 31 + c * 17) % (most + 1)) : 0;
}
static double gps_time(size_t i)
{
    return 3.1e8 + 0.125 * (double)i;
}
static bool withheld(const struct recipe *r, size_t i)
{
    return r->withhold && i % 3 == 1;
}

static void put(unsigned char *at, uint64_t value, unsigned bytes)
{
    memcpy(at, &value, bytes);
}
static void put_double(unsigned char *at, double value)
{
    memcpy(at, &value, sizeof value);
}

static const double scales[] = { 0.01, 0.001, 0.25 }, offsets[] = { 500000, -4.25e6, 0.1 };

static void put_header(struct buffer *b, const struct recipe *r)
{
    static const size_t by_minor[] = { 227, 227, 227, 235, 375 };
    size_t size = by_minor[r->minor], vlr = r->vlr ? r->vlr->size : 0;
    unsigned length = sizes[r->format] + r->extra;
    unsigned char h[375] = "LASF";
    h[24] = 1;
    h[25] = (unsigned char)r->minor;
    put(h + 94, size, 2);
    put(h + 96, size + vlr, 4);
    put(h + 100, r->vlrs, 4);
    h[104] = (unsigned char)r->format;
    put(h + 105, length, 2);
    put(h + 107, r->no_legacy_count ? 0 : r->count, 4);
    for (unsigned i = 0; i < 3; i++) {
        put_double(h + 131 + 8 * i, scales[i]);
        put_double(h + 155 + 8 * i, offsets[i]);
    }
    if (r->minor >= 4) {
        put(h + 235, r->evlr ? size + vlr + length * r->count : 0, 8);
        put(h + 243, r->evlrs, 4);
        put(h + 247, r->count, 8);
    }
    put_bytes(b, h, size);
    if (vlr)
        put_bytes(b, r->vlr->data, vlr);
}

static void put_flags(unsigned char *p, const struct recipe *r, size_t i)
{
    if (r->format < 6) {
        p[14] = (unsigned char)(i % 8 | (i + 1) % 8 << 3 | i % 2 << 6);
        p[15] = (unsigned char)(class_of(i, r->format) | (withheld(r, i) ? 0x80 : 0));
        p[16] = (unsigned char)(int8_t)(i % 181 - 90);
    } else {
        p[14] = (unsigned char)(i % 16 | (i + 1) % 16 << 4);
        p[15] = (unsigned char)((withheld(r, i) ? 4 : 0) | i % 4 << 4);
        p[16] = (unsigned char)class_of(i, r->format);
        put(p + 18, (uint64_t)((int64_t)(i % 181) - 90) * 100, 2);
    }
}

static void put_point(struct buffer *b, const struct recipe *r, size_t i)
{
    static const unsigned char time_at[] = { 0, 20, 0, 20, 20, 20, 22, 22, 22, 22, 22 };
    static const unsigned char color_at[] = { 0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30 };
    unsigned char p[67];
    memset(p, 0xee, sizeof p);
    for (unsigned axis = 0; axis < 3; axis++)
        put(p + 4 * axis, (uint32_t)raw(i, axis), 4);
    put(p + 12, intensity(i), 2);
    put_flags(p, r, i);
    if (time_at[r->format])
        put_double(p + time_at[r->format], gps_time(i));
    for (unsigned c = 0; c < 3 && color_at[r->format]; c++)
        put(p + color_at[r->format] + 2 * c, color(i, c, r->color_most), 2);
    if (r->format == 8 || r->format == 10)
        put(p + 36, i % 1000, 2);
    put_bytes(b, p, sizes[r->format]);
}

/* Extra bytes of point i: a running pattern that the tests know. */
static unsigned char extra_byte(size_t i, unsigned k)
{
    return (unsigned char)(i * 29 + k * 13 + 1);
}

static struct buffer make(const struct recipe *r)
{
    struct buffer b = { 0 };
    put_header(&b, r);
    for (size_t i = 0; i < r->count; i++) {
        put_point(&b, r, i);
        for (unsigned k = 0; k < r->extra; k++) {
            unsigned char byte = extra_byte(i, k);
            put_bytes(&b, &byte, 1);
        }
    }
    if (r->evlr)
        put_bytes(&b, r->evlr->data, r->evlr->size);
    return b;
}

static struct cloud read_field(const struct buffer *b, const char *color_by)
{
    struct load_options options = { .color_by = color_by };
    struct cloud cloud;
    struct lines lines;
    enum stp_result result = read_buffer(b, &options, 3, &cloud, &lines);
    if (result != STP_OK)
        print_error("%s\n", lines.error);
    assert_int_equal(result, STP_OK);
    assert_int_equal(lines.warnings, 0);
    return cloud;
}

static void check_places(const struct cloud *cloud, const struct recipe *r)
{
    size_t row = 0;
    for (size_t i = 0; i < r->count; i++) {
        if (withheld(r, i))
            continue;
        for (unsigned axis = 0; axis < 3; axis++)
            assert_true(cloud->position[row][axis] == raw(i, axis) * scales[axis] + offsets[axis]);
        row++;
    }
    assert_int_equal(cloud->count, row);
    assert_int_equal(cloud->up, STP_UP_Z);
    assert_null(cloud->normal);
    assert_null(cloud->radius);
    assert_null(cloud->opacity);
}

static float linear(double encoded)
{
    return (float)(encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4));
}

static void check_colors(const struct cloud *cloud, const struct recipe *r, double divisor)
{
    bool has = r->color_most && (r->format == 2 || r->format == 3 || r->format == 5 ||
                                 r->format == 7 || r->format == 8 || r->format == 10);
    if (!has) {
        assert_null(cloud->color);
        return;
    }
    assert_non_null(cloud->color);
    for (size_t i = 0, row = 0; i < r->count; i++) {
        for (unsigned c = 0; c < 3 && !withheld(r, i); c++) {
            float expected = linear(color(i, c, r->color_most) / divisor);
            assert_true(fabsf(cloud->color[row][c] - expected) <= 1e-7f);
        }
        row += !withheld(r, i);
    }
}

/* The field's value of point i is `expected(i)`. */
static void check_field(const struct recipe *r, const char *name, double (*expected)(size_t i))
{
    struct buffer b = make(r);
    struct cloud cloud = read_field(&b, name);
    assert_int_equal(cloud.field_count, 1);
    for (size_t i = 0, row = 0; i < r->count; i++)
        if (!withheld(r, i)) {
            float value = cloud.fields->value[row++];
            assert_true(value == (float)expected(i) || (isnan(value) && isnan(expected(i))));
        }
    assert_non_null(cloud.color);
    cloud_release(&cloud);
    drop(&b);
}

static double expect_intensity(size_t i)
{
    return intensity(i);
}
static double expect_old_class(size_t i)
{
    return class_of(i, 0);
}
static double expect_new_class(size_t i)
{
    return class_of(i, 6);
}
static double expect_old_return(size_t i)
{
    return (double)(i % 8);
}
static double expect_new_return(size_t i)
{
    return (double)(i % 16);
}
static double expect_old_angle(size_t i)
{
    return (double)(i % 181) - 90;
}
static double expect_new_angle(size_t i)
{
    return ((double)(i % 181) - 90) * 100 * 0.006;
}
static double expect_time(size_t i)
{
    return 0.125 * (double)i;
}

static void test_formats(void **state)
{
    for (unsigned minor = 0; minor <= 4; minor++)
        for (unsigned format = 0; format <= 10; format++) {
            struct recipe r = { .format = format,
                                .minor = minor,
                                .count = 300,
                                .extra = minor,
                                .color_most = 255,
                                .withhold = format % 2 };
            struct buffer b = make(&r);
            struct cloud cloud = read_field(&b, NULL);
            char name[32];
            snprintf(name, sizeof name, "LAS 1.%u, point format %u", minor, format);
            assert_string_equal(cloud.format, name);
            check_places(&cloud, &r);
            check_colors(&cloud, &r, 255);
            cloud_release(&cloud);
            drop(&b);
        }
}

static void test_fields(void **state)
{
    for (unsigned format = 0; format <= 10; format++) {
        struct recipe r = { .format = format, .minor = 4, .count = 520, .withhold = format % 2 };
        bool old = format < 6;
        check_field(&r, "intensity", expect_intensity);
        check_field(&r, "class", old ? expect_old_class : expect_new_class);
        check_field(&r, "return_number", old ? expect_old_return : expect_new_return);
        check_field(&r, "scan_angle", old ? expect_old_angle : expect_new_angle);
        if (format != 0 && format != 2)
            check_field(&r, "gps_time", expect_time);
    }
}

static double expect_infrared(size_t i)
{
    return (double)(i % 1000);
}

static void test_infrared(void **state)
{
    struct recipe r = { .format = 8, .minor = 4, .count = 40 };
    check_field(&r, "infrared", expect_infrared);
    r.format = 10;
    check_field(&r, "infrared", expect_infrared);
}

/* 8 bits in fields of 16, 16 bits, and none at all. */
static void test_color_depth(void **state)
{
    static const struct {
        unsigned most;
        double divisor;
    } cases[] = { { 255, 255 }, { 200, 255 }, { 256, 65535 }, { 65535, 65535 }, { 0, 1 } };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        struct recipe r = { .format = 3, .minor = 2, .count = 70000, .color_most = cases[c].most };
        struct buffer b = make(&r);
        struct cloud cloud = read_field(&b, NULL);
        check_places(&cloud, &r);
        check_colors(&cloud, &r, cases[c].divisor);
        cloud_release(&cloud);
        drop(&b);
    }
}

static void put_extra(struct buffer *b, unsigned type, unsigned options, const char *name)
{
    unsigned char d[192] = { [2] = (unsigned char)type, [3] = (unsigned char)options };
    strcpy((char *)d + 4, name);
    if (options & 1)
        put(d + 40, extra_byte(5, 0), 8);
    put_double(d + 112, 0.5);
    put_double(d + 136, -100);
    put_bytes(b, d, sizeof d);
}

/* A record of another kind, then the descriptions. */
static struct buffer wrap(const struct buffer *descriptions, bool wide)
{
    struct buffer b = { 0 };
    unsigned char head[60] = "??other";
    put(head + 20, 7, 2);
    put_bytes(&b, head, wide ? 60 : 54);
    put_bytes(&b, "content", 7);
    memset(head, 0, sizeof head);
    strcpy((char *)head + 2, "LASF_Spec");
    put(head + 18, 4, 2);
    put(head + 20, descriptions->size, 2);
    put_bytes(&b, head, wide ? 60 : 54);
    put_bytes(&b, descriptions->data, descriptions->size);
    return b;
}

static double expect_first(size_t i)
{
    return i % 256 == 5 ? NAN : extra_byte(i, 0);
}
static double expect_scaled(size_t i)
{
    return (extra_byte(i, 4) | extra_byte(i, 5) << 8) * 0.5 - 100;
}
static double expect_last(size_t i)
{
    return (int8_t)extra_byte(i, 9);
}

static void check_extras(bool wide)
{
    struct buffer d = { 0 };
    put_extra(&d, 1, 1, "first");
    put_extra(&d, 0, 3, "undocumented");
    put_extra(&d, 3, 24, "scaled");
    put_extra(&d, 21, 0, "triple");
    put_extra(&d, 2, 0, "a name of thirty-two characters!");
    struct buffer records = wrap(&d, wide);
    struct recipe r = { .format = 6, .minor = 4, .count = 256, .extra = 12 };
    if (wide)
        r.evlr = &records, r.evlrs = 2;
    else
        r.vlr = &records, r.vlrs = 2;
    check_field(&r, "first", expect_first);
    check_field(&r, "Scaled", expect_scaled);
    check_field(&r, "a name of thirty-two characters!", expect_last);
    struct buffer b = make(&r);
    struct load_options options = { .color_by = "triple" };
    struct cloud cloud;
    struct lines lines;
    assert_int_equal(read_buffer(&b, &options, 1, &cloud, &lines), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(lines.error, "scaled"));
    drop(&b);
    drop(&d);
    drop(&records);
}

static void test_extras(void **state)
{
    check_extras(false);
    check_extras(true);
}

/* Normals that CloudCompare writes as extra bytes are normals. */
static void test_extra_normals(void **state)
{
    struct buffer d = { 0 };
    put_extra(&d, 9, 0, "NormalX");
    put_extra(&d, 9, 0, "NormalY");
    put_extra(&d, 9, 0, "NormalZ");
    struct buffer records = wrap(&d, false);
    struct recipe r = { .format = 3,
                        .minor = 2,
                        .count = 20,
                        .extra = 12,
                        .vlr = &records,
                        .vlrs = 2,
                        .withhold = true };
    struct buffer b = make(&r);
    struct cloud cloud = read_field(&b, NULL);
    assert_non_null(cloud.normal);
    for (size_t i = 0, row = 0; i < r.count; i++) {
        unsigned char bytes[12];
        for (unsigned k = 0; k < 12; k++)
            bytes[k] = extra_byte(i, k);
        if (!withheld(&r, i))
            assert_memory_equal(cloud.normal[row++], bytes, 12);
    }
    cloud_release(&cloud);
    drop(&b);
    drop(&d);
    drop(&records);
}

static void test_all_withheld(void **state)
{
    struct recipe r = { .format = 0, .minor = 2, .count = 1 };
    struct buffer b = make(&r);
    b.data[227 + 15] |= 0x80;
    struct cloud cloud = read_field(&b, NULL);
    assert_int_equal(cloud.count, 0);
    assert_null(cloud.position);
    assert_int_equal(cloud.up, STP_UP_Z);
    drop(&b);
}

static void test_counts(void **state)
{
    struct recipe r = { .format = 6, .minor = 4, .count = 10, .no_legacy_count = true };
    struct buffer b = make(&r);
    struct cloud cloud = read_field(&b, NULL);
    assert_int_equal(cloud.count, 10);
    cloud_release(&cloud);
    put(b.data + 107, 4, 4); /* the wide count wins, and a line says so */
    struct lines lines;
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    assert_int_equal(cloud.count, 10);
    assert_int_equal(lines.warnings, 1);
    cloud_release(&cloud);
    put(b.data + 247, 0, 8); /* a writer that filled only the old one */
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    assert_int_equal(cloud.count, 4);
    cloud_release(&cloud);
    drop(&b);
    r.count = 0;
    b = make(&r);
    cloud = read_field(&b, NULL);
    assert_int_equal(cloud.count, 0);
    assert_int_equal(cloud.up, STP_UP_Z);
    drop(&b);
}

/* `bytes` bytes at `at` become `value`. */
static void refuse_changed(size_t at, uint64_t value, unsigned bytes, const char *words)
{
    struct recipe r = { .format = 7, .minor = 4, .count = 5 };
    struct buffer b = make(&r);
    put(b.data + at, value, bytes);
    refuse_buffer(&b, STP_ERROR_FORMAT, words);
    drop(&b);
}

static void test_lies(void **state)
{
    double nan_value = NAN;
    uint64_t nan_bits;
    memcpy(&nan_bits, &nan_value, 8);
    refuse_changed(24, 2, 1, "byte 24: LAS 2.4");
    refuse_changed(25, 5, 1, "byte 24: LAS 1.5");
    refuse_changed(94, 227, 2, "byte 94: ");
    refuse_changed(94, 60000, 2, "byte 94: ");
    refuse_changed(96, 100, 4, "byte 96: ");
    refuse_changed(96, 0xffffffff, 4, "byte 96: ");
    refuse_changed(104, 11, 1, "byte 104: point format 11");
    refuse_changed(104, 0x87, 1, "LAZ (compressed LAS) is not read");
    refuse_changed(104, 0x87, 1, "pdal translate");
    refuse_changed(105, 35, 2, "byte 105: ");
    refuse_changed(105, 37, 2, "the file ends in point 4");
    refuse_changed(131, nan_bits, 8, "byte 131: the scale of x");
    refuse_changed(147, 0, 8, "byte 147: the scale of z is 0");
    refuse_changed(163, nan_bits, 8, "byte 163: the offset of y");
    refuse_changed(247, 6, 8, "byte 375: 6 points of 36 bytes");
    refuse_changed(247, UINT64_MAX, 8, "18446744073709551615 points");
}

static void test_short(void **state)
{
    struct recipe r = { .format = 1, .minor = 2, .count = 3 };
    struct buffer b = make(&r);
    size_t whole = b.size;
    for (b.size = 4; b.size < whole; b.size++)
        refuse_buffer(&b, STP_ERROR_FORMAT, b.size < 227 ? "within the LAS header" : "cut short");
    b.size = whole;
    put_bytes(&b, "more", 4); /* waveforms and EVLRs stand there */
    struct cloud cloud = read_field(&b, NULL);
    assert_int_equal(cloud.count, 3);
    cloud_release(&cloud);
    drop(&b);
}

/* Records that leave the file are warned of; the points are as good as before. */
static void test_lying_records(void **state)
{
    struct recipe r = {
        .format = 6, .minor = 4, .count = 5, .extra = 2, .vlrs = 1000000, .evlrs = 7
    };
    struct buffer b = make(&r);
    struct cloud cloud;
    struct lines lines;
    put(b.data + 235, UINT64_MAX - 3, 8);
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    assert_int_equal(lines.warnings, 2);
    assert_int_equal(cloud.count, 5);
    cloud_release(&cloud);
    drop(&b);
    /* Descriptions of more bytes than a point has. */
    struct buffer d = { 0 };
    put_extra(&d, 1, 0, "fits");
    put_extra(&d, 10, 0, "does not");
    struct buffer records = wrap(&d, false);
    struct recipe s = {
        .format = 0, .minor = 2, .count = 5, .extra = 2, .vlr = &records, .vlrs = 2
    };
    b = make(&s);
    struct load_options options = { .color_by = "fits" };
    assert_int_equal(read_buffer(&b, &options, 1, &cloud, &lines), STP_OK);
    assert_int_equal(lines.warnings, 1);
    assert_non_null(strstr(lines.warning, "extra bytes number 1"));
    cloud_release(&cloud);
    drop(&b);
    drop(&d);
    drop(&records);
}

static void test_memory(void **state)
{
    struct recipe r = { .format = 3, .minor = 2, .count = 300, .color_most = 9, .withhold = true };
    struct buffer b = make(&r);
    fail_each_allocation(&b, NULL);
    fail_each_allocation(&b, "intensity");
    fail_each_allocation(&b, "class");
    drop(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_formats),       cmocka_unit_test(test_fields),
        cmocka_unit_test(test_infrared),      cmocka_unit_test(test_color_depth),
        cmocka_unit_test(test_extras),        cmocka_unit_test(test_extra_normals),
        cmocka_unit_test(test_all_withheld),  cmocka_unit_test(test_counts),
        cmocka_unit_test(test_lies),          cmocka_unit_test(test_short),
        cmocka_unit_test(test_lying_records), cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
