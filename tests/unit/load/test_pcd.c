/* PCD: the same points through all three kinds of body, packed colours, and files that lie. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/lzf.h"
#include "support.h"

/* A field and its values. */
struct field {
    const char *name;
    char type;
    unsigned size, count;
    double (*value)(size_t i, unsigned k);
};

enum kind { ASCII, BINARY, COMPRESSED };
static const char *const kinds[] = { "ascii", "binary", "binary_compressed" };

/* Exact in a float and in nine digits. */
static double place(size_t i, unsigned axis)
{
    return (double)i * 1.25 - 7.0 * axis + 0.125;
}
static double x_of(size_t i, unsigned k)
{
    return i % 11 == 7 ? NAN : place(i, 0);
}
static double y_of(size_t i, unsigned k)
{
    return i % 11 == 7 ? NAN : place(i, 1);
}
static double z_of(size_t i, unsigned k)
{
    return i % 11 == 7 ? NAN : place(i, 2) + 20;
}
static double small_of(size_t i, unsigned k)
{
    return (double)((i * 7 + k * 3) % 100);
}
static double signed_of(size_t i, unsigned k)
{
    return (double)(i % 200) - 100;
}
static double unit_of(size_t i, unsigned k)
{
    return (double)(i % 8) / 8;
}
static uint32_t packed_of(size_t i)
{
    return (uint32_t)(i * 2654435761u);
}

static void put_value(struct buffer *b, const struct field *f, double value)
{
    float narrow = (float)value;
    int64_t whole = isnan(value) ? 0 : (int64_t)value;
    if (f->type == 'F')
        put_bytes(b, f->size == 4 ? (void *)&narrow : (void *)&value, f->size);
    else
        put_bytes(b, &whole, f->size);
}

static bool is_packed(const struct field *f)
{
    return !f->value;
}

static void put_field(struct buffer *b, const struct field *f, size_t i)
{
    uint32_t bits = packed_of(i);
    if (is_packed(f))
        put_bytes(b, &bits, 4);
    for (unsigned k = 0; k < f->count && !is_packed(f); k++)
        put_value(b, f, f->value(i, k));
}

static void put_words(struct buffer *b, const char *key, const struct field *fields, unsigned n,
                      char what)
{
    put_text(b, "%s", key);
    for (unsigned i = 0; i < n; i++)
        if (what == 'N')
            put_text(b, " %s", fields[i].name);
        else if (what == 'T')
            put_text(b, " %c", fields[i].type);
        else
            put_text(b, " %u", what == 'S' ? fields[i].size : fields[i].count);
    put_text(b, "\n");
}

/* Parts of both kinds: matches are looked for among the last bytes only. */
static struct buffer pack(const struct buffer *in)
{
    struct buffer out = { 0 };
    for (size_t at = 0; at < in->size;) {
        size_t best = 0, back = 0;
        for (size_t b = 1; b <= 32 && b <= at; b++) {
            size_t n = 0;
            while (at + n < in->size && n < 264 && in->data[at + n] == in->data[at + n - b])
                n++;
            if (n > best)
                best = n, back = b;
        }
        unsigned char part[40], length = 1;
        if (best >= 3) {
            size_t l = best - 2;
            part[0] = (unsigned char)((l < 7 ? l : 7) << 5);
            if (l >= 7)
                part[length++] = (unsigned char)(l - 7);
            part[length++] = (unsigned char)(back - 1);
            at += best;
        } else {
            size_t n = 1 + at % 32;
            n = n < in->size - at ? n : in->size - at;
            part[0] = (unsigned char)(n - 1);
            memcpy(part + 1, in->data + at, n);
            length = (unsigned char)(n + 1);
            at += n;
        }
        put_bytes(&out, part, length);
    }
    return out;
}

static void put_compressed(struct buffer *b, const struct field *fields, unsigned n, size_t points)
{
    struct buffer flat = { 0 };
    for (unsigned f = 0; f < n; f++)
        for (size_t i = 0; i < points && strcmp(fields[f].name, "_") != 0; i++)
            put_field(&flat, &fields[f], i);
    struct buffer packed = pack(&flat);
    uint32_t counts[2] = { (uint32_t)packed.size, (uint32_t)flat.size };
    put_bytes(b, counts, 8);
    put_bytes(b, packed.data, packed.size);
    drop(&flat);
    drop(&packed);
}

static void put_row(struct buffer *b, const struct field *fields, unsigned n, size_t i)
{
    for (unsigned f = 0; f < n; f++) {
        if (is_packed(&fields[f]))
            put_text(b, "%u ", packed_of(i));
        for (unsigned k = 0; k < fields[f].count && !is_packed(&fields[f]); k++)
            put_text(b, "%.9g ", fields[f].value(i, k));
    }
    put_text(b, "\n");
}

static struct buffer make(enum kind kind, const struct field *fields, unsigned n, size_t width,
                          size_t height)
{
    struct buffer b = { 0 };
    put_text(&b, "# .PCD v.7 - Point Cloud Data file format\nVERSION .7\n");
    put_words(&b, "FIELDS", fields, n, 'N');
    put_words(&b, "SIZE", fields, n, 'S');
    put_words(&b, "TYPE", fields, n, 'T');
    put_words(&b, "COUNT", fields, n, 'C');
    put_text(&b, "WIDTH %zu\nHEIGHT %zu\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS %zu\nDATA %s\n", width,
             height, width * height, kinds[kind]);
    if (kind == COMPRESSED)
        put_compressed(&b, fields, n, width * height);
    for (size_t i = 0; i < width * height && kind == BINARY; i++)
        for (unsigned f = 0; f < n; f++)
            put_field(&b, &fields[f], i);
    for (size_t i = 0; i < width * height && kind == ASCII; i++)
        put_row(&b, fields, n, i);
    return b;
}

static struct cloud read_by(const struct buffer *b, const char *color_by)
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

static bool same(double a, double b)
{
    return a == b || (isnan(a) && isnan(b));
}

static void check_places(const struct cloud *cloud)
{
    for (size_t i = 0; i < cloud->count; i++) {
        const double *p = cloud->position[i];
        assert_true(same(p[0], x_of(i, 0)));
        assert_true(same(p[1], y_of(i, 0)));
        assert_true(same(p[2], z_of(i, 0)));
    }
}

static float linear(double encoded)
{
    return (float)(encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4));
}

static void check_packed(const struct cloud *cloud, bool has_alpha)
{
    assert_non_null(cloud->color);
    assert_int_equal(cloud->opacity != NULL, has_alpha);
    for (size_t i = 0; i < cloud->count; i++) {
        uint32_t bits = packed_of(i);
        for (unsigned c = 0; c < 3; c++)
            assert_true(fabsf(cloud->color[i][c] - linear((bits >> (16 - 8 * c) & 255) / 255.0)) <=
                        1e-7f);
        if (has_alpha)
            assert_true(cloud->opacity[i] == (float)((bits >> 24) / 255.0));
    }
}

static void test_plain(void **state)
{
    const struct field fields[] = { { "x", 'F', 4, 1, x_of },
                                    { "y", 'F', 4, 1, y_of },
                                    { "z", 'F', 8, 1, z_of },
                                    { "rgb", 'F', 4, 1, NULL } };
    for (int kind = ASCII; kind <= COMPRESSED; kind++) {
        char name[32];
        struct buffer b = make((enum kind)kind, fields, 4, 100, 30);
        struct cloud cloud = read_by(&b, NULL);
        snprintf(name, sizeof name, "PCD %s", kinds[kind]);
        assert_string_equal(cloud.format, name);
        assert_int_equal(cloud.count, 3000);
        check_places(&cloud);
        check_packed(&cloud, false);
        cloud_release(&cloud);
        drop(&b);
    }
}

/* Every type, counts above one, padding, normals, and alpha; each field by its name. */
static void test_fields(void **state)
{
    const struct field fields[] = {
        { "hist", 'U', 2, 5, small_of },
        { "x", 'F', 4, 1, x_of },
        { "i1", 'I', 1, 1, signed_of },
        { "u1", 'U', 1, 1, small_of },
        { "_", 'U', 1, 7, small_of },
        { "y", 'F', 4, 1, y_of },
        { "z", 'F', 4, 1, z_of },
        { "i2", 'I', 2, 1, signed_of },
        { "u4", 'U', 4, 1, small_of },
        { "i4", 'I', 4, 1, signed_of },
        { "rgba", 'U', 4, 1, NULL },
        { "normal_x", 'F', 4, 1, unit_of },
        { "normal_y", 'F', 8, 1, unit_of },
        { "normal_z", 'F', 4, 1, unit_of },
        { "intensity", 'F', 4, 1, unit_of },
        { "u8", 'U', 8, 1, small_of },
        { "i8", 'I', 8, 1, signed_of },
        { "curvature", 'F', 4, 1, unit_of },
    };
    const unsigned n = sizeof fields / sizeof *fields;
    for (int kind = ASCII; kind <= COMPRESSED; kind++) {
        struct buffer b = make((enum kind)kind, fields, n, 500, 1);
        struct cloud cloud = read_by(&b, NULL);
        check_places(&cloud);
        check_packed(&cloud, true);
        assert_non_null(cloud.normal);
        for (size_t i = 0; i < cloud.count; i++)
            for (unsigned a = 0; a < 3; a++)
                assert_true(cloud.normal[i][a] == (float)unit_of(i, 0));
        cloud_release(&cloud);
        for (unsigned f = 0; f < n; f++) {
            if (!fields[f].value || fields[f].name[0] == '_')
                continue;
            cloud = read_by(&b, fields[f].name);
            assert_string_equal(cloud.fields->name, fields[f].name);
            for (size_t i = 0; i < cloud.count; i++)
                assert_true(same(cloud.fields->value[i], (float)fields[f].value(i, 0)));
            cloud_release(&cloud);
        }
        drop(&b);
    }
}

/* Floats whose bits are a colour, and integers, stand side by side in texts. */
static void test_packed_text(void **state)
{
    static const char head[] = "VERSION 0.7\r\nFIELDS x y z rgb\r\nSIZE 4 4 4 4\r\nTYPE F F F F\r\n"
                               "WIDTH 5\r\nHEIGHT 1\r\nDATA ascii\r\n";
    char text[1024];
    uint32_t bits = 0x00ff8040, opaque = 0xff204060;
    float value, negative;
    memcpy(&value, &bits, 4);
    memcpy(&negative, &opaque, 4);
    snprintf(text, sizeof text,
             "%s0 0 0 %.9g\r\n0 0 0 %.9g\r\n0 0 0 %u\r\n0 0 0 16744512\r\n0 0 0 nan\r\n", head,
             value, negative, opaque);
    static const unsigned expected[5][3] = {
        { 255, 128, 64 }, { 32, 64, 96 }, { 32, 64, 96 }, { 255, 128, 64 }, { 0, 0, 0 }
    };
    struct cloud cloud = read_text(text);
    assert_int_equal(cloud.count, 5);
    for (size_t i = 0; i < 5; i++)
        for (unsigned c = 0; c < 3; c++)
            assert_true(fabsf(cloud.color[i][c] - linear(expected[i][c] / 255.0)) <= 1e-7f);
    cloud_release(&cloud);
}

/* A depth camera's picture has its y down; a lidar's rows, and a cloud of one row, do not. */
static void test_up(void **state)
{
    static const char head[] = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH %u\nHEIGHT %u\n"
                               "DATA ascii\n%s";
    static const struct {
        unsigned width, height;
        const char *rows;
        enum stp_up up;
    } cases[] = {
        { 2, 2, "1 2 3\nnan nan nan\n1 1 .5\n-1 0 9\n", STP_UP_NEG_Y },
        { 2, 2, "1 2 3\nnan nan nan\n1 1 -.5\n-1 0 9\n", STP_UP_Y },
        { 2, 2, "nan nan nan\nnan nan nan\nnan nan nan\nnan nan nan\n", STP_UP_Y },
        { 4, 1, "1 2 3\nnan nan nan\n1 1 .5\n-1 0 9\n", STP_UP_Y },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct buffer b = { 0 };
        put_text(&b, head, cases[i].width, cases[i].height, cases[i].rows);
        struct cloud cloud = read_by(&b, NULL);
        assert_int_equal(cloud.count, 4);
        assert_int_equal(cloud.up, cases[i].up);
        cloud_release(&cloud);
        drop(&b);
    }
}

static void test_none(void **state)
{
    struct cloud cloud = read_text("# .PCD v.7\nVERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"
                                   "WIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA binary_compressed\n");
    assert_int_equal(cloud.count, 0);
    cloud_release(&cloud);
}

/* A header with one line changed; NULL leaves it out. */
static void refuse_line(const char *key, const char *line, const char *words)
{
    static const char *const lines[][2] = {
        { "VERSION", "VERSION .7" }, { "FIELDS", "FIELDS x y z w" }, { "SIZE", "SIZE 4 4 4 2" },
        { "TYPE", "TYPE F F F U" },  { "COUNT", "COUNT 1 1 1 2" },   { "WIDTH", "WIDTH 3" },
        { "HEIGHT", "HEIGHT 1" },    { "POINTS", "POINTS 3" },       { "DATA", "DATA binary" },
    };
    struct buffer b = { 0 };
    put_text(&b, "# .PCD v.7 - x\n");
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        bool changed = strcmp(lines[i][0], key) == 0;
        if (!changed || line)
            put_text(&b, "%s\n", changed ? line : lines[i][1]);
    }
    put_text(&b, "%048d", 0);
    refuse_buffer(&b, STP_ERROR_FORMAT, words);
    drop(&b);
}

static void test_lies(void **state)
{
    refuse_line("FIELDS", NULL, "FIELDS must come before");
    refuse_line("FIELDS", "FIELDS a y z w", "has no field x");
    refuse_line("FIELDS", "FIELDS x b z w", "has no field y");
    refuse_line("SIZE", NULL, "no FIELDS, SIZE and TYPE");
    refuse_line("SIZE", "SIZE 4 4 4", "byte 41: not a size");
    refuse_line("SIZE", "SIZE 4 4 4 2 1", "more entries than fields: \"1\"");
    refuse_line("SIZE", "SIZE 4 4 3 2", "do not go together, of field \"z\"");
    refuse_line("SIZE", "SIZE 4 4 -4 2", "not a size");
    refuse_line("TYPE", "TYPE F F F X", "do not go together, of field \"w\"");
    refuse_line("TYPE", "TYPE F F Float U", "\"Float\"");
    refuse_line("COUNT", "COUNT 1 1 1 0", "not a size, type or count");
    refuse_line("COUNT", "COUNT 1 1 1 4096", "more than 4096 numbers");
    refuse_line("COUNT", "COUNT 1 1 1 18446744073709551617", "not a size");
    refuse_line("POINTS", "POINTS 4", "the file ends in point 3");
    refuse_line("POINTS", "POINTS 18446744073709551615", "18446744073709551615 points");
    refuse_line("POINTS", "POINTS 3.5", "not a count: \"3.5\"");
    refuse_line("DATA", "DATA packed", "an unknown kind of DATA: \"packed\"");
    refuse_line("DATA", NULL, "unknown line \"0000");
    refuse_line("WIDTH", "WIDE 3", "unknown line \"WIDE\"");
    refuse_text("# .PCD v.7\nVERSION .7\n", STP_ERROR_FORMAT, "ends without a DATA line");
    refuse_text("FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 5\nHEIGHT 3689348814741910324\nDATA ascii\n",
                STP_ERROR_FORMAT, "no count of points");
}

static void test_short(void **state)
{
    const struct field fields[] = { { "x", 'F', 4, 1, x_of },
                                    { "y", 'F', 4, 1, y_of },
                                    { "z", 'F', 4, 1, z_of } };
    for (int kind = ASCII; kind <= COMPRESSED; kind++) {
        struct buffer b = make((enum kind)kind, fields, 3, 9, 1);
        size_t whole = b.size;
        for (b.size = 12; b.size < whole - (kind == ASCII ? 2 : 0); b.size++) {
            struct cloud cloud;
            struct lines lines;
            enum stp_result result = read_buffer(&b, NULL, 1, &cloud, &lines);
            if (result == STP_OK) /* the last digits of a text may go unnoticed */
                assert_true(kind == ASCII && b.size > whole - 14);
            else
                assert_non_null(strstr(lines.error, "byte "));
            cloud_release(&cloud);
        }
        drop(&b);
    }
}

static void refuse_packed(uint32_t packed, uint32_t size, const char *bytes, const char *words)
{
    struct buffer b = { 0 };
    put_text(&b, "VERSION .7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nWIDTH 1\nHEIGHT 1\n"
                 "POINTS 1\nDATA binary_compressed\n");
    put_bytes(&b, &packed, 4);
    put_bytes(&b, &size, 4);
    put_bytes(&b, bytes, 9);
    refuse_buffer(&b, STP_ERROR_FORMAT, words);
    drop(&b);
}

static void test_compressed_lies(void **state)
{
    refuse_packed(10, 8, "\7abcdefgh", "10 bytes of compressed data are claimed; 9 are left");
    refuse_packed(9, 9, "\7abcdefgh", "9 bytes when unpacked are claimed");
    refuse_packed(8, 8, "\7abcdefgh", "byte 107: damaged");
    refuse_packed(9, 8, "\6abcdefgh", "damaged");              /* one too few, then a cut literal */
    refuse_packed(9, 8, "\10abcdefgh", "byte 107: damaged");   /* longer than the output */
    refuse_packed(4, 8, "\1ab\40\2xxxx", "damaged");           /* a match whose offset is missing */
    refuse_packed(5, 8, "\1ab\40\2xxxx", "byte 110: damaged"); /* from before the output */
    refuse_packed(6, 8, "\1ab\340\1\1xxx", "byte 110: damaged"); /* past its end */
    refuse_packed(5, 8, "\1ab\100\1xxxx", "byte 112: damaged");  /* too little of it */
}

/* Against bytes that were packed by other code: random runs, every size up to two thousand. */
static void test_lzf(void **state)
{
    uint64_t random = 88172645463325252u;
    for (size_t size = 0; size < 2000; size += 1 + size / 50) {
        struct buffer in = { 0 };
        while (in.size < size) {
            unsigned char byte = (unsigned char)(next_random(&random) % 5);
            for (size_t run = next_random(&random) % 300; run && in.size < size; run--)
                put_bytes(&in, &byte, 1);
            put_bytes(&in, &byte, in.size < size);
        }
        struct buffer packed = pack(&in);
        unsigned char *out = malloc(size + 1), guard = 0x5a;
        size_t at = 0;
        out[size] = guard;
        assert_true(lzf_unpack(packed.data, packed.size, out, size, &at));
        assert_int_equal(at, packed.size);
        assert_int_equal(out[size], guard);
        if (size)
            assert_memory_equal(out, in.data, size);
        if (size)
            assert_false(lzf_unpack(packed.data, packed.size, out, size - 1, &at));
        assert_false(lzf_unpack(packed.data, packed.size, out, size + 1, &at));
        free(out);
        drop(&in);
        drop(&packed);
    }
}

static void test_memory(void **state)
{
    const struct field fields[] = { { "x", 'F', 4, 1, x_of },
                                    { "y", 'F', 4, 1, y_of },
                                    { "intensity", 'U', 2, 3, small_of },
                                    { "rgba", 'U', 4, 1, NULL } };
    for (int kind = ASCII; kind <= COMPRESSED; kind++) {
        struct buffer b = make((enum kind)kind, fields, 4, 50, 1);
        fail_each_allocation(&b, NULL);
        fail_each_allocation(&b, "intensity");
        drop(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plain),       cmocka_unit_test(test_fields),
        cmocka_unit_test(test_packed_text), cmocka_unit_test(test_up),
        cmocka_unit_test(test_none),        cmocka_unit_test(test_lies),
        cmocka_unit_test(test_short),       cmocka_unit_test(test_compressed_lies),
        cmocka_unit_test(test_lzf),         cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
