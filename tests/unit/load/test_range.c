/* Pictures, intrinsics and poses of range images, made here byte by byte, and what is refused. */
#include "support.h"

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "load/range.h"

static void keep(void *user, enum stp_log_level level, const char *line)
{
    struct lines *l = user;
    char *to = level == STP_LOG_ERROR ? l->error : l->warning;
    *(level == STP_LOG_ERROR ? &l->errors : &l->warnings) += 1;
    snprintf(to, sizeof l->error, "%s", line);
}

static struct stp_env quiet(struct lines *lines)
{
    *lines = (struct lines){ 0 };
    return (struct stp_env){ .log = keep, .user = lines };
}

/* From a block of exactly its size. */
static enum stp_result read_picture(const struct buffer *b, enum range_plane plane,
                                    struct range_image *image, struct lines *lines)
{
    struct stp_env env = quiet(lines);
    unsigned char *copy = malloc(b->size ? b->size : 1);
    if (b->size)
        memcpy(copy, b->data, b->size);
    const struct file_bytes bytes = { .data = copy, .size = b->size };
    enum stp_result result = range_image_from_bytes(&env, "picture", &bytes, plane, image);
    free(copy);
    assert_int_equal(lines->errors, result != STP_OK);
    return result;
}

static struct range_image expect_picture(const struct buffer *b, enum range_plane plane,
                                         uint32_t width, uint32_t height, unsigned channels)
{
    struct range_image image = { 0 };
    struct lines lines;
    if (read_picture(b, plane, &image, &lines) != STP_OK)
        fail_msg("%s", lines.error);
    assert_true(image.width == width && image.height == height && image.channels == channels);
    return image;
}

static void refuse_picture(const struct buffer *b, enum range_plane plane, const char *words)
{
    struct range_image image = { .width = 77 };
    struct lines lines;
    assert_int_equal(read_picture(b, plane, &image, &lines), STP_ERROR_FORMAT);
    assert_true(image.width == 77 && !image.value);
    if (!strstr(lines.error, words))
        fail_msg("'%s' does not say '%s'", lines.error, words);
}

static void pgm_and_ppm(void **state)
{
    struct buffer b = { 0 };
    put_text(&b, "P5\n# made here\n3 2\n65535\n");
    for (int i = 0; i < 6; i++)
        put_bytes(&b, (unsigned char[]){ (unsigned char)(i + 1), (unsigned char)(10 * i) }, 2);
    struct range_image image = expect_picture(&b, RANGE_DEPTH, 3, 2, 1);
    for (int i = 0; i < 6; i++)
        assert_true(image.value[i] == 256 * (i + 1) + 10 * i);
    range_image_release(&image);
    b.size--;
    refuse_picture(&b, RANGE_DEPTH, "take 12 bytes, the file has 11");
    drop(&b);
    b = (struct buffer){ 0 };
    put_text(&b, "P6 1 2 255 abcdef");
    image = expect_picture(&b, RANGE_COLOR, 1, 2, 3);
    assert_true(image.value[0] == 'a' && image.value[5] == 'f' && image.maximum == 255);
    range_image_release(&image);
    refuse_picture(&b, RANGE_DEPTH, "a depth has one channel");
    drop(&b);
}

/* libpng's own writer, grey of 16 bits or colours of 8. */
static struct buffer png_of(bool wide, uint32_t width, uint32_t height, const void *pixels)
{
    struct buffer b = { 0 };
    png_image image = { .version = PNG_IMAGE_VERSION,
                        .width = width,
                        .height = height,
                        .format = wide ? PNG_FORMAT_LINEAR_Y : PNG_FORMAT_RGB };
    png_alloc_size_t size = 65536;
    unsigned char *data = malloc(size);
    assert_true(png_image_write_to_memory(&image, data, &size, 0, pixels, 0, NULL));
    put_bytes(&b, data, size);
    free(data);
    return b;
}

static void png(void **state)
{
    uint16_t depth[6] = { 0, 1, 256, 4711, 65534, 65535 };
    unsigned char color[6] = { 0, 128, 255, 1, 2, 3 };
    struct buffer b = png_of(true, 2, 3, depth);
    struct range_image image = expect_picture(&b, RANGE_DEPTH, 2, 3, 1);
    for (int i = 0; i < 6; i++)
        assert_true(image.value[i] == depth[i]);
    assert_int_equal(image.maximum, 65535);
    range_image_release(&image);
    for (size_t cut = 9; cut < b.size - 12; cut += 5) { /* not a crash, wherever it ends */
        struct buffer part = { b.data, cut, cut };
        refuse_picture(&part, RANGE_DEPTH, "damaged");
    }
    b.data[b.size - 14] ^= 0x55; /* the checksum of the pixels */
    refuse_picture(&b, RANGE_DEPTH, "damaged");
    drop(&b);
    b = png_of(false, 2, 1, color);
    image = expect_picture(&b, RANGE_COLOR, 2, 1, 3);
    for (int i = 0; i < 6; i++)
        assert_true(image.value[i] == color[i]);
    range_image_release(&image);
    refuse_picture(&b, RANGE_DEPTH, "one channel");
    drop(&b);
}

static void pictures_that_are_none(void **state)
{
    static const char *const wrong[][2] = {
        { "", "not a picture" },
        { "GIF89a", "not a picture" },
        { "P5", "width, height" },
        { "P5 1", "width, height" },
        { "P5 0 4 255 ", "0 x 4" },
        { "P5 1 1 0 a", "maximum" },
        { "P5 1 1 65536 aaa", "maximum" },
        { "P5 -1 1 255 a", "width, height" },
        { "P6 99999 99999 255 a", "take" },
        { "P5 999999999 1 255 a", "take" },
        { "\x76\x2f\x31\x01nothing", "damaged" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct buffer b = { 0 };
        put_text(&b, "%s", wrong[i][0]);
        refuse_picture(&b, RANGE_COLOR, wrong[i][1]);
        drop(&b);
    }
}

static enum stp_result intrinsics(const char *text, struct range_camera *camera,
                                  struct range_units *units, struct lines *lines)
{
    struct stp_env env = quiet(lines);
    const struct file_bytes bytes = { .data = (const unsigned char *)text, .size = strlen(text) };
    enum stp_result result = range_intrinsics_from_bytes(&env, "i.txt", &bytes, camera, units);
    assert_int_equal(lines->errors, result != STP_OK);
    return result;
}

static void intrinsics_and_what_they_lack(void **state)
{
    static const char *const wrong[][2] = {
        { "", "must be positive" },
        { "fx 1\nfy 1\n", "cx and cy" },
        { "fx 0\nfy 1\ncx 0\ncy 0\n", "must be positive" },
        { "fx -3\nfy 1\ncx 0\ncy 0\n", "must be positive" },
        { "fx nan\nfy 1\ncx 0\ncy 0\n", "must be positive" },
        { "fx 1\nfy 1\ncx 0\ncy inf\n", "cx and cy" },
        { "fx 1\nfocal 2\n", "byte 5" },
        { "fx one\n", "a number" },
        { "fx 1 2\n", "a number" },
        { "fx 1\nfy 1\ncx 0\ncy 0\ndepth_scale 0\n", "must be positive" },
    };
    struct range_camera c = { 0 };
    struct range_units u = { 0 };
    struct lines lines;
    assert_int_equal(intrinsics("# a comment\nfx 518.0\r\nfy 519\ncx 325.5\ncy 253.5 # so\n"
                                "depth_scale 1000",
                                &c, &u, &lines),
                     STP_OK);
    assert_true(c.fx == 518 && c.fy == 519 && u.depth_scale == 1000);
    assert_true(c.cx == 326 && c.cy == 254); /* centres of pixels are whole numbers in the file */
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(intrinsics(wrong[i][0], &c, &u, &lines), STP_ERROR_FORMAT);
        if (!strstr(lines.error, wrong[i][1]))
            fail_msg("'%s' does not say '%s'", lines.error, wrong[i][1]);
    }
    assert_true(c.fx == 518 && u.depth_scale == 1000);
}

static enum stp_result read_poses(const char *text, double (**pose)[16], unsigned *count,
                                  struct lines *lines)
{
    struct stp_env env = quiet(lines);
    const struct file_bytes bytes = { .data = (const unsigned char *)text, .size = strlen(text) };
    enum stp_result result = range_poses_from_bytes(&env, "pose.txt", &bytes, pose, count);
    assert_int_equal(lines->errors, result != STP_OK);
    return result;
}

static void poses_turn_as_quaternions_do(void **state)
{
    double(*pose)[16] = NULL;
    unsigned count;
    struct lines lines;
    assert_int_equal(read_poses("# tx ty tz qx qy qz qw\n1 2 3 0 0 0 1\n\n"
                                "0 0 0 0.70710678 0 0 0.70710678\n0 0 0 0 0 1.001 0",
                                &pose, &count, &lines),
                     STP_OK);
    assert_int_equal(count, 3);
    assert_true(pose[0][0] == 1 && pose[0][3] == 1 && pose[0][7] == 2 && pose[0][11] == 3);
    /* A quarter turn about x takes y to z and z to -y. */
    assert_true(fabs(pose[1][9] - 1) < 1e-7 && fabs(pose[1][6] + 1) < 1e-7);
    assert_true(fabs(pose[2][0] + 1) < 1e-12 && pose[2][15] == 1); /* its length is taken out */
    mem_free(pose);
}

static void poses_that_are_none(void **state)
{
    static const char *const wrong[][2] = {
        { "", "no poses" },
        { "# none\n", "no poses" },
        { "1 2 3 0 0 0\n", "seven numbers" },
        { "1 2 3 0 0 0 1 9\n", "seven numbers" },
        { "1 2 3 0 0 0 1\nnan 2 3 0 0 0 1\n", "byte 14" },
        { "1 2 inf 0 0 0 1\n", "not finite" },
        { "1 2 3 0 0 0 0\n", "length" },
        { "1 2 3 4 5 6 7\n", "length" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        double(*pose)[16] = NULL;
        unsigned count = 99;
        struct lines lines;
        assert_int_equal(read_poses(wrong[i][0], &pose, &count, &lines), STP_ERROR_FORMAT);
        assert_true(!pose && count == 99);
        if (!strstr(lines.error, wrong[i][1]))
            fail_msg("'%s' does not say '%s'", lines.error, wrong[i][1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pgm_and_ppm),
        cmocka_unit_test(png),
        cmocka_unit_test(pictures_that_are_none),
        cmocka_unit_test(intrinsics_and_what_they_lack),
        cmocka_unit_test(poses_turn_as_quaternions_do),
        cmocka_unit_test(poses_that_are_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
