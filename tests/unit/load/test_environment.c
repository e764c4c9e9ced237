/* Radiance pictures made here byte by byte, and what is wrong with others. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "load/environment.h"

#define W 12
#define H 3

static void keep(void *user, enum stp_log_level level, const char *line)
{
    struct lines *l = user;
    char *to = level == STP_LOG_ERROR ? l->error : l->warning;
    *(level == STP_LOG_ERROR ? &l->errors : &l->warnings) += 1;
    snprintf(to, sizeof l->error, "%s", line);
}

static enum stp_result read_map(const struct buffer *b, struct environment_map *map,
                                struct lines *lines)
{
    char path[] = "/tmp/stipple-test-XXXXXX";
    struct stp_env env = { .log = keep, .user = lines };
    int file = mkstemp(path);
    *lines = (struct lines){ 0 };
    assert_true(file >= 0 && write(file, b->data, b->size) == (ssize_t)b->size);
    close(file);
    enum stp_result result = environment_read(&env, path, map);
    unlink(path);
    assert_int_equal(lines->errors, result != STP_OK);
    return result;
}

/* A pixel that tells where it is: mantissas of column, row and 77, exponent 128 + 8. */
static void pixel(unsigned x, unsigned y, unsigned char out[4])
{
    out[0] = (unsigned char)(3 + x);
    out[1] = (unsigned char)(100 + y);
    out[2] = 77;
    out[3] = 136;
}

static void expect_pixels(const struct environment_map *map, double scale)
{
    assert_true(map->width == W && map->height == H);
    for (unsigned y = 0; y < H; y++)
        for (unsigned x = 0; x < W; x++) {
            const float *t = map->texel[y * W + x];
            assert_float_equal(t[0], (3 + x) * scale, 1e-4);
            assert_float_equal(t[1], (100 + y) * scale, 1e-3);
            assert_float_equal(t[2], 77 * scale, 1e-3);
        }
}

static void put_flat_line(struct buffer *b, unsigned y)
{
    unsigned char p[4];
    for (unsigned x = 0; x < W; x++) {
        pixel(x, y, p);
        put_bytes(b, p, 4);
    }
}

/* Literals of the red plane in two parts, runs in the three that do not change. */
static void put_new_line(struct buffer *b, unsigned y)
{
    const unsigned char head[] = { 2, 2, 0, W, 5, 3, 4, 5, 6, 7, W - 5 };
    put_bytes(b, head, sizeof head);
    for (unsigned x = 5; x < W; x++)
        put_bytes(b, &(unsigned char){ (unsigned char)(3 + x) }, 1);
    const unsigned char rest[] = { 128 + 7,     (unsigned char)(100 + y),
                                   128 + W - 7, (unsigned char)(100 + y),
                                   128 + W,     77,
                                   128 + W,     136 };
    put_bytes(b, rest, sizeof rest);
}

static void put_header(struct buffer *b, const char *lines, const char *resolution)
{
    put_text(b, "#?RADIANCE\n# made by a test\n%sFORMAT=32-bit_rle_rgbe\n\n%s\n", lines,
             resolution);
}

static void test_flat_and_new(void **state)
{
    for (int mode = 0; mode < 3; mode++) { /* 2: scanlines of both kinds */
        struct buffer b = { 0 };
        struct environment_map map = { 0 };
        struct lines lines;
        put_header(&b, "", "-Y 3 +X 12");
        for (unsigned y = 0; y < H; y++)
            mode == 0 || (mode == 2 && y == 1) ? put_flat_line(&b, y) : put_new_line(&b, y);
        assert_int_equal(read_map(&b, &map, &lines), STP_OK);
        expect_pixels(&map, 1);
        assert_non_null(strstr(lines.warning, "twice as wide"));
        environment_map_release(&map);
        drop(&b);
    }
}

/* 1 1 1 n repeats; two in a row count n + 256 m. */
static void test_old_runs(void **state)
{
    struct buffer b = { 0 };
    struct environment_map map = { 0 };
    struct lines lines;
    const unsigned char line[] = { 10, 20, 30, 136, 1,  1,   1, 4, 1, 1,
                                   1,  1,  50, 60,  70, 137, 1, 1, 1, 38 };
    put_header(&b, "", "-Y 1 +X 300");
    put_bytes(&b, line, sizeof line);
    assert_int_equal(read_map(&b, &map, &lines), STP_OK);
    for (int x = 0; x < 300; x++) {
        assert_true(map.texel[x][0] == (x < 261 ? 10 : 100));
        assert_true(map.texel[x][2] == (x < 261 ? 30 : 140));
    }
    environment_map_release(&map);
    drop(&b);
}

/* All eight orientations of the resolution line show the same picture. */
static void test_orientations(void **state)
{
    static const char *const axes[2][2] = { { "-Y", "+X" }, { "+Y", "-X" } };
    for (int i = 0; i < 8; i++) {
        bool columns = i & 4, flip_y = i & 1, flip_x = i & 2;
        const char *y_axis = axes[flip_y][0], *x_axis = axes[flip_x][1];
        char resolution[64];
        unsigned char p[4];
        struct buffer b = { 0 };
        struct environment_map map = { 0 };
        struct lines lines;
        snprintf(resolution, sizeof resolution, "%s %d %s %d", columns ? x_axis : y_axis,
                 columns ? W : H, columns ? y_axis : x_axis, columns ? H : W);
        put_header(&b, "", resolution);
        for (unsigned line = 0; line < (columns ? W : H); line++)
            for (unsigned k = 0; k < (columns ? H : W); k++) {
                unsigned x = columns ? line : k, y = columns ? k : line;
                pixel(flip_x ? W - 1 - x : x, flip_y ? H - 1 - y : y, p);
                put_bytes(&b, p, 4);
            }
        assert_int_equal(read_map(&b, &map, &lines), STP_OK);
        expect_pixels(&map, 1);
        environment_map_release(&map);
        drop(&b);
    }
}

/* EXPOSURE lines multiply up and are taken back; GAMMA decodes. */
static void test_exposure_and_gamma(void **state)
{
    struct buffer b = { 0 };
    struct environment_map map = { 0 };
    struct lines lines;
    put_header(&b, "EXPOSURE=4\nEXPOSURE= 0.5\n", "-Y 3 +X 12");
    for (unsigned y = 0; y < H; y++)
        put_flat_line(&b, y);
    assert_int_equal(read_map(&b, &map, &lines), STP_OK);
    expect_pixels(&map, 0.5);
    environment_map_release(&map);
    drop(&b);
    put_header(&b, "GAMMA=2.2\n", "-Y 1 +X 2");
    put_bytes(&b, (unsigned char[]){ 64, 128, 255, 128, 0, 0, 0, 0 }, 8);
    assert_int_equal(read_map(&b, &map, &lines), STP_OK);
    for (int k = 0; k < 3; k++) {
        double v = (k == 0 ? 64 : k == 1 ? 128 : 255) / 256.0;
        assert_float_equal(map.texel[0][k], pow(v, 2.2), 1e-6);
        assert_true(map.texel[1][k] == 0);
    }
    environment_map_release(&map);
    drop(&b);
}

static void refuse(const char *header, const char *resolution, const void *data, size_t size,
                   const char *words)
{
    struct buffer b = { 0 };
    struct environment_map map = { 0 };
    struct lines lines;
    put_text(&b, "%s", header);
    if (resolution)
        put_text(&b, "\n%s\n", resolution);
    put_bytes(&b, data, size);
    assert_int_equal(read_map(&b, &map, &lines), STP_ERROR_FORMAT);
    if (!strstr(lines.error, words))
        fail_msg("'%s' lacks '%s'", lines.error, words);
    assert_null(map.texel);
    drop(&b);
}

static void test_refused(void **state)
{
    static const char good[] = "#?RGBE\n", line[] = "-Y 1 +X 9";
    static const unsigned char data[64] = { 2, 2, 0, 9 };
    refuse("P6 1 1 255\n", NULL, data, 8, "neither OpenEXR nor Radiance");
    refuse("#?RGBE\nFORMAT=32-bit_rle_xyze\n", line, data, 64, "XYZE");
    refuse("#?RGBE\nFORMAT=other\n", line, data, 64, "FORMAT");
    refuse("#?RGBE\nEXPOSURE=0\n", line, data, 64, "EXPOSURE");
    refuse("#?RGBE\nGAMMA=-1\n", line, data, 64, "GAMMA");
    refuse("#?RGBE\nand no end", NULL, data, 0, "does not end");
    refuse(good, NULL, "\n", 1, "no resolution line");
    refuse(good, "-Y 1 +Z 9", data, 64, "no resolution line");
    refuse(good, "-Y 1", data, 64, "no resolution line");
    refuse(good, "-Y 1 +Y 9", data, 64, "names one axis twice");
    refuse(good, "-Y 0 +X 9", data, 64, "1 .. 16384");
    refuse(good, "-Y 1 +X 16385", data, 64, "1 .. 16384");
    refuse(good, "-Y 99999999999999999999 +X 9", data, 64, "1 .. 16384");
    refuse(good, "-Y 64 +X 9", data, 64, "shorter than its resolution");
    refuse(good, line, data, 20, "a run that does not fit");      /* a run of 0 */
    refuse(good, line, "\2\2\0\11\212\1", 6, "does not fit");     /* 10 in a line of 9 */
    refuse(good, line, "\2\2\0\11\211\1\5ab", 9, "does not fit"); /* 5 of 2 left */
    refuse(good, line, "\2\2\0\11\211\1\211\1\211", 9, "end within a scanline");
    refuse(good, line, "\1\1\1\3aaaa", 8, "does not fit"); /* repeats nothing */
    refuse(good, line, "abcd\1\1\1\11", 8, "does not fit");
    refuse(good, line, "abcd\1\1\1\0\1\1\1\1", 12, "does not fit"); /* 256 */
    refuse(good, line, "abcdefgh", 8, "end within a scanline");
}

/* Values that are no light are, and one warning says so. */
static void test_bound(void **state)
{
    float texel[3][3] = { { NAN, -1, 2 }, { INFINITY, 3e9f, 5 }, { -INFINITY, 0, 1e9f } };
    const float expected[3][3] = { { 0, 0, 2 }, { 1e9f, 1e9f, 5 }, { 0, 0, 1e9f } };
    struct environment_map map = { 3, 1, texel };
    struct lines lines = { 0 };
    struct stp_env env = { .log = keep, .user = &lines };
    environment_bound(&env, "x", &map);
    assert_memory_equal(texel, expected, sizeof texel);
    assert_int_equal(lines.warnings, 1);
    assert_non_null(strstr(lines.warning, "3 values that are NaN or negative became 0, 2 above"));
    environment_bound(&env, "x", &map);
    assert_int_equal(lines.warnings, 1);
}

static void test_memory(void **state)
{
    struct buffer b = { 0 };
    put_header(&b, "", "-Y 3 +X 12");
    for (unsigned y = 0; y < H; y++)
        put_new_line(&b, y);
    unsigned long n = 1;
    for (;; n++) {
        struct environment_map map = { 0 };
        struct lines lines;
        mem_fail_at(n);
        enum stp_result result = read_map(&b, &map, &lines);
        mem_fail_at(0);
        if (result == STP_OK) {
            environment_map_release(&map);
            break;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_null(map.texel);
    }
    assert_true(n > 3);
    drop(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat_and_new), cmocka_unit_test(test_old_runs),
        cmocka_unit_test(test_orientations), cmocka_unit_test(test_exposure_and_gamma),
        cmocka_unit_test(test_refused),      cmocka_unit_test(test_bound),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
