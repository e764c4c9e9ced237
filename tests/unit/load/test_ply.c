/* PLY in every dialect, made in code with values that every type holds. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support.h"

enum body { ASCII, LITTLE, BIG };
static const char *const body_names[] = { "ascii", "binary_little_endian", "binary_big_endian" };
static const char *const type_names[] = { "char",  "int8",    "uchar",  "uint8",
                                          "short", "int16",   "ushort", "uint16",
                                          "int",   "int32",   "uint",   "uint32",
                                          "float", "float32", "double", "float64" };
#define TYPES 16

static void put_sized(struct buffer *buffer, enum body body, const void *data, size_t size)
{
    if (body == LITTLE)
        put_bytes(buffer, data, size);
    else
        put_reversed(buffer, data, size);
}

static void put_value(struct buffer *buffer, enum body body, int type, double value)
{
    int8_t i8 = (int8_t)(int)value;
    uint8_t u8 = (uint8_t)(int)value;
    int16_t i16 = (int16_t)(int)value;
    uint16_t u16 = (uint16_t)(int)value;
    int32_t i32 = (int32_t)value;
    uint32_t u32 = (uint32_t)(int64_t)value;
    float f = (float)value;
    const void *data[] = { &i8, &u8, &i16, &u16, &i32, &u32, &f, &value };
    static const size_t size[] = { 1, 1, 2, 2, 4, 4, 4, 8 };
    if (body == ASCII)
        put_text(buffer, "%.17g ", value);
    else
        put_sized(buffer, body, data[type / 2], size[type / 2]);
}

static double test_value(int type, size_t i, int axis)
{
    double value = (double)((i * 7 + (size_t)axis * 3) % 100);
    bool is_signed = type / 2 % 2 == 0 || type >= 12;
    if (is_signed && (i & 1))
        value = -value;
    return type >= 12 ? value + 0.25 : value;
}

/* Every type in every encoding, for each axis. */
static void test_types(void **state)
{
    for (int body = ASCII; body <= BIG; body++)
        for (int type = 0; type < TYPES; type++) {
            struct buffer b = { 0 };
            put_text(&b, "ply\nformat %s 1.0\nelement vertex 9\n", body_names[body]);
            for (int axis = 0; axis < 3; axis++)
                put_text(&b, "property %s %c\n", type_names[type], 'x' + axis);
            put_text(&b, "end_header\n");
            for (size_t i = 0; i < 9; i++) {
                for (int axis = 0; axis < 3; axis++)
                    put_value(&b, body, type, test_value(type, i, axis));
                if (body == ASCII)
                    put_text(&b, "\n");
            }
            struct cloud cloud;
            struct lines lines;
            assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
            assert_int_equal(lines.warnings, 0);
            assert_int_equal(cloud.count, 9);
            for (size_t i = 0; i < 9; i++)
                for (int axis = 0; axis < 3; axis++)
                    assert_true(cloud.position[i][axis] == test_value(type, i, axis));
            assert_null(cloud.normal);
            assert_null(cloud.color);
            assert_int_equal(cloud.up, STP_UP_Y);
            cloud_release(&cloud);
            drop(&b);
        }
}

static double vertex_value(size_t vertex, int column)
{
    return (double)vertex * 0.5 + column * 1000;
}

/* Elements before, lists among the properties, doubles, any order, elements after. */
static void put_rich_file(struct buffer *b, enum body body, size_t count)
{
    put_text(b,
             "ply\nformat %s 1.0\nobj_info from a test\ncomment hello\n"
             "element camera 2\nproperty float f\nproperty list uchar short tags\n"
             "element plain 3\nproperty int a\nproperty uchar b\n"
             "element vertex %zu\nproperty double z\nproperty list ushort float weights\n"
             "property float nx\nproperty double x\nproperty float nz\nproperty float radius\n"
             "property float ny\nproperty double y\nproperty list int uchar more\n"
             "element face 1\nproperty list uchar int vertex_indices\nend_header\n",
             body_names[body], count);
    for (int i = 0; i < 2; i++) {
        put_value(b, body, 12, 1.5);
        put_value(b, body, 2, i);
        for (int k = 0; k < i; k++)
            put_value(b, body, 4, -k);
        if (body == ASCII)
            put_text(b, "\n");
    }
    for (int i = 0; i < 3; i++) {
        put_value(b, body, 8, 77);
        put_value(b, body, 2, 3);
        if (body == ASCII)
            put_text(b, "\n");
    }
    for (size_t v = 0; v < count; v++) {
        put_value(b, body, 14, vertex_value(v, 2));
        put_value(b, body, 6, (double)(v % 3));
        for (size_t k = 0; k < v % 3; k++)
            put_value(b, body, 12, 9.5);
        put_value(b, body, 12, vertex_value(v, 3));
        put_value(b, body, 14, vertex_value(v, 0));
        put_value(b, body, 12, vertex_value(v, 5));
        put_value(b, body, 12, vertex_value(v, 6));
        put_value(b, body, 12, vertex_value(v, 4));
        put_value(b, body, 14, vertex_value(v, 1));
        put_value(b, body, 8, (double)((v + 1) % 2));
        for (size_t k = 0; k < (v + 1) % 2; k++)
            put_value(b, body, 2, 200);
        if (body == ASCII)
            put_text(b, "\n");
    }
}

static void test_lists_and_order(void **state)
{
    for (int body = ASCII; body <= BIG; body++) {
        struct buffer b = { 0 };
        struct cloud cloud;
        struct lines lines;
        put_rich_file(&b, body, 50);
        assert_int_equal(read_buffer(&b, NULL, 2, &cloud, &lines), STP_OK);
        assert_int_equal(cloud.count, 50);
        for (size_t v = 0; v < 50; v++)
            for (int c = 0; c < 3; c++) {
                assert_true(cloud.position[v][c] == vertex_value(v, c));
                assert_true(cloud.normal[v][c] == (float)vertex_value(v, c + 3));
                assert_true(cloud.radius[v] == (float)vertex_value(v, 6));
            }
        cloud_release(&cloud);
        drop(&b);
    }
}

static void test_header_dialects(void **state)
{
    static const char *const texts[] = {
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n1 2 3\n4 5 6\n",
        "ply\r\nformat ascii 1.0\r\nelement vertex 2\r\nproperty float x\r\nproperty float y\r\n"
        "property float z\r\nend_header\r\n1 2 3\r\n4 5 6\r\n",
        "ply\rformat ascii 1.0\relement vertex 2\rproperty float x\rproperty float y\r"
        "property float z\rend_header\r1 2 3\r4 5 6",
        "ply  \nformat   ascii 1.0\t\n\n comment\t\tx\n element vertex\t2\n\tproperty float\t x \n"
        "property   float y\nobj_info\nproperty float z\ncomment\nend_header \n\n   1\t2   3 \n\n"
        "\t4 5\t6",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n1\n2 3\n4 5\n6\n", /* rows go on in the next line */
    };
    for (size_t t = 0; t < sizeof texts / sizeof *texts; t++) {
        struct cloud cloud = read_text(texts[t]);
        assert_int_equal(cloud.count, 2);
        assert_string_equal(cloud.format, "PLY ascii");
        for (int i = 0; i < 6; i++)
            assert_true(cloud.position[i / 3][i % 3] == i + 1);
        cloud_release(&cloud);
    }
}

/* A binary body may begin with any byte, a line feed too. */
static void test_binary_after_header(void **state)
{
    static const char *const ends[] = { "\n", "\r\n" };
    for (int e = 0; e < 2; e++) {
        struct buffer b = { 0 };
        put_text(&b, "ply%sformat binary_little_endian 1.0%selement vertex 1%s", ends[e], ends[e],
                 ends[e]);
        for (int axis = 0; axis < 3; axis++)
            put_text(&b, "property uchar %c%s", 'x' + axis, ends[e]);
        put_text(&b, "end_header%s\n\r\n", ends[e]);
        struct cloud cloud;
        struct lines lines;
        assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
        assert_true(cloud.position[0][0] == 10 && cloud.position[0][1] == 13 &&
                    cloud.position[0][2] == 10);
        put_text(&b, "zzz");
        cloud_release(&cloud);
        assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
        assert_int_equal(lines.warnings, 1);
        assert_non_null(strstr(lines.warning, "3 bytes follow"));
        cloud_release(&cloud);
        drop(&b);
    }
}

static void test_no_vertices(void **state)
{
    static const char *const texts[] = {
        "ply\nformat ascii 1.0\nend_header\n",
        ("ply\nformat binary_big_endian 1.0\nelement face 0\n"
         "property list uchar int v\nend_header\n"),
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n",
    };
    for (size_t t = 0; t < sizeof texts / sizeof *texts; t++) {
        struct cloud cloud = read_text(texts[t]);
        assert_int_equal(cloud.count, 0);
        cloud_release(&cloud);
    }
}

#define HEADER(n, properties)                                                                      \
    "ply\nformat ascii 1.0\nelement vertex " n "\nproperty float x\nproperty float y\n"            \
    "property float z\n" properties "end_header\n"

static void test_names(void **state)
{
    static const char *const normals[] = { "nx ny nz", "normal_x normal_y normal_z", "NX NY NZ",
                                           "normalx normaly normalz" };
    static const char *const colors[] = { "red green blue", "r g b",
                                          "diffuse_red diffuse_green diffuse_blue", "R G B" };
    static const char *const radii[] = { "radius", "psz", "point_size", "Radius" };
    static const char *const alphas[] = { "alpha", "opacity", "a", "Alpha" };
    for (int i = 0; i < 4; i++) {
        char n[3][32], c[3][32];
        struct buffer b = { 0 };
        struct lines lines;
        struct cloud cloud;
        sscanf(normals[i], "%31s %31s %31s", n[0], n[1], n[2]);
        sscanf(colors[i], "%31s %31s %31s", c[0], c[1], c[2]);
        put_text(&b, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                     "property float y\nproperty float z\n");
        for (int k = 0; k < 3; k++)
            put_text(&b, "property float %s\nproperty float %s\n", n[k], c[k]);
        put_text(&b, "property double %s\nproperty float %s\nend_header\n", radii[i], alphas[i]);
        put_text(&b, "1 2 3 0 0.25 1 0.5 0 0.75 7 0.125\n");
        assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
        assert_true(cloud.normal[0][1] == 1 && cloud.normal[0][2] == 0);
        assert_true(cloud.color[0][0] == 0.25f && cloud.color[0][1] == 0.5f &&
                    cloud.color[0][2] == 0.75f);
        assert_true(cloud.radius[0] == 7 && cloud.opacity[0] == 0.125f);
        cloud_release(&cloud);
        drop(&b);
    }
}

static void test_incomplete_groups(void **state)
{
    struct cloud cloud =
        read_text(HEADER("1", "property float nx\nproperty float nz\n"
                              "property uchar red\nproperty uchar blue\n") "1 2 3 4 5 6 7\n");
    assert_null(cloud.normal);
    assert_null(cloud.color);
    cloud_release(&cloud);
}

/* Lists that the header declares and the body lacks; numbers that it does not declare. */
static void test_ragged_lines(void **state)
{
    struct cloud cloud =
        read_text(HEADER("2", "property list uchar int vertex_indices\n") "1 2 3\n4 5 6\n");
    assert_int_equal(cloud.count, 2);
    assert_true(cloud.position[1][0] == 4 && cloud.position[1][2] == 6);
    cloud_release(&cloud);
    struct buffer b = { 0 };
    struct lines lines;
    put_text(&b, HEADER("2", "") "1 2 3 99\n4 5 6 99\n");
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    assert_int_equal(lines.warnings, 1);
    assert_true(cloud.position[1][0] == 4 && cloud.position[1][2] == 6);
    cloud_release(&cloud);
    drop(&b);
}

static void test_planar(void **state)
{
    struct buffer b = { 0 };
    struct lines lines;
    struct cloud cloud;
    put_text(&b, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float y\nproperty float x\n"
                 "end_header\n8 9\n");
    assert_int_equal(read_buffer(&b, NULL, 1, &cloud, &lines), STP_OK);
    assert_int_equal(lines.warnings, 1);
    assert_true(cloud.position[0][0] == 9 && cloud.position[0][1] == 8 &&
                cloud.position[0][2] == 0);
    cloud_release(&cloud);
    drop(&b);
}

static void test_not_finite(void **state)
{
    struct cloud cloud =
        read_text(HEADER("2", "property float radius\n") "nan -inf 1.#QNAN 0\n1e400 2 3 -1\n");
    assert_true(isnan(cloud.position[0][0]) && isnan(cloud.position[0][2]));
    assert_true(isinf(cloud.position[0][1]) && cloud.position[0][1] < 0);
    assert_true(isinf(cloud.position[1][0]));
    assert_true(cloud.radius[0] == 0 && cloud.radius[1] == -1);
    cloud_release(&cloud);
}

/* What stp_scene_save writes comes back bit for bit: no colour is guessed at or decoded. */
static void test_prepared(void **state)
{
    struct buffer b = { 0 };
    struct lines lines;
    struct cloud cloud;
    uint64_t seed = 3;
    double position[40][3];
    float rest[40][8];
    put_text(&b, "ply\nformat binary_little_endian 1.0\ncomment stipple prepared 1\n"
                 "element vertex 40\nproperty double x\nproperty double y\nproperty double z\n"
                 "property float nx\nproperty float ny\nproperty float nz\nproperty float radius\n"
                 "property float red\nproperty float green\nproperty float blue\n"
                 "property float opacity\nproperty uint input_index\nproperty ushort object\n"
                 "property uchar group\nend_header\n");
    for (uint32_t i = 0; i < 40; i++) {
        uint16_t object = 1;
        for (int c = 0; c < 3; c++)
            position[i][c] = (double)next_random(&seed) * 1e-13 + 6e6;
        for (int c = 0; c < 8; c++) /* colours of 0..255 that a guess would divide */
            rest[i][c] = (float)(next_random(&seed) % 200);
        put_bytes(&b, position[i], sizeof position[i]);
        put_bytes(&b, rest[i], sizeof rest[i]);
        put_bytes(&b, &i, sizeof i);
        put_bytes(&b, &object, sizeof object);
        put_bytes(&b, "g", 1);
    }
    assert_int_equal(read_buffer(&b, NULL, 2, &cloud, &lines), STP_OK);
    assert_int_equal(lines.warnings, 0);
    assert_memory_equal(cloud.position, position, sizeof position);
    for (int i = 0; i < 40; i++) {
        assert_memory_equal(cloud.normal[i], rest[i], 12);
        assert_memory_equal(&cloud.radius[i], &rest[i][3], 4);
        assert_memory_equal(cloud.color[i], &rest[i][4], 12);
        assert_memory_equal(&cloud.opacity[i], &rest[i][7], 4);
    }
    cloud_release(&cloud);
    drop(&b);
}

/* Large enough for many blocks, in both bodies: the number of threads changes nothing. */
static void test_threads(void **state)
{
    for (int body = ASCII; body <= BIG; body++) {
        struct buffer b = { 0 };
        struct lines lines;
        struct cloud one, many;
        put_text(&b,
                 "ply\nformat %s 1.0\nelement vertex 30000\nproperty double x\n"
                 "property float y\nproperty double z\nproperty uchar red\n"
                 "property uchar green\nproperty uchar blue\nend_header\n",
                 body_names[body]);
        uint64_t seed = 9;
        for (int i = 0; i < 30000; i++) {
            for (int c = 0; c < 3; c++)
                put_value(&b, body, c == 1 ? 12 : 14, (double)(next_random(&seed) >> 40) / 1024);
            for (int c = 0; c < 3; c++)
                put_value(&b, body, 2, (double)(next_random(&seed) & 255));
            if (body == ASCII)
                put_text(&b, "\n");
        }
        assert_int_equal(read_buffer(&b, NULL, 1, &one, &lines), STP_OK);
        assert_int_equal(read_buffer(&b, NULL, 5, &many, &lines), STP_OK);
        seed = 9;
        assert_true(one.position[0][0] == (double)(next_random(&seed) >> 40) / 1024);
        assert_true(same_cloud(&one, &many));
        cloud_release(&one);
        cloud_release(&many);
        drop(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types),
        cmocka_unit_test(test_lists_and_order),
        cmocka_unit_test(test_header_dialects),
        cmocka_unit_test(test_binary_after_header),
        cmocka_unit_test(test_no_vertices),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_incomplete_groups),
        cmocka_unit_test(test_ragged_lines),
        cmocka_unit_test(test_planar),
        cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_prepared),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
