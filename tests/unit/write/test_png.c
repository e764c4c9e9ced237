/* Previews, read back with libpng and compared with the definition of sRGB in double. */
#include "helpers.h"

#include <png.h>

#include "base/memory.h"

static const float values[] = { -1.0f, 0.0f,  1e-5f, 0.0015f, 0.0031308f, 0.0032f,
                                0.01f, 0.05f, 0.18f, 0.25f,   0.5f,       0.73f,
                                0.99f, 1.0f,  1.5f,  1e30f,   NAN,        INFINITY };
static const float alphas[] = { 0.0f, 1e-6f, 0.25f, 0.501f, 1.0f, 2.0f, NAN };
enum { WIDTH = sizeof values / sizeof *values, HEIGHT = sizeof alphas / sizeof *alphas };

static struct stp_image *make_image(bool alpha)
{
    struct stp_image *image = NULL;
    const char *names[] = { "R", "G", "B", "A" };
    assert_int_equal(stp_image_create(NULL, WIDTH, HEIGHT, &image), STP_OK);
    for (int c = 0; c < (alpha ? 4 : 3); c++) {
        float *plane = add_plane(image, names[c], STP_CHANNEL_FLOAT)->data.f;
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            plane[i] = c == 3 ? alphas[i / WIDTH] : values[(i % WIDTH + 5 * c) % WIDTH];
    }
    return image;
}

static unsigned char *decode(const char *path)
{
    png_image png = { .version = PNG_IMAGE_VERSION };
    assert_true(png_image_begin_read_from_file(&png, path));
    assert_int_equal(png.width, WIDTH);
    assert_int_equal(png.height, HEIGHT);
    assert_int_equal(png.format, PNG_FORMAT_RGBA);
    unsigned char *pixels = malloc(PNG_IMAGE_SIZE(png));
    assert_true(png_image_finish_read(&png, NULL, pixels, 0, NULL));
    return pixels;
}

static int expected(double linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 255;
    double s = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (int)floor(s * 255 + 0.5);
}

static void check(const char *folder, bool with_alpha, double stops)
{
    char path[PATH_MAX];
    struct stp_image *image = make_image(with_alpha);
    in_scratch(folder, "p.png", path);
    assert_int_equal(stp_image_write_png(NULL, image, path, stops), STP_OK);
    unsigned char *pixels = decode(path);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double alpha = with_alpha ? (double)alphas[i / WIDTH] : 1;
        for (int c = 0; c < 3; c++) {
            double linear = image->channels[c].data.f[i] * exp2(stops) / alpha;
            assert_int_equal(pixels[4 * i + c], alpha > 0 ? expected(linear) : 0);
        }
        int opaque = !(alpha > 0) ? 0 : alpha >= 1 ? 255 : (int)floor(alpha * 255 + 0.5);
        assert_int_equal(pixels[4 * i + 3], opaque);
    }
    free(pixels);
    stp_image_destroy(&image);
}

static void test_values(void **state)
{
    check(*state, true, 0);
    check(*state, true, -2.5);
    check(*state, false, 1);
}

static void test_no_color(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 1);
    struct stp_image *image = NULL;
    assert_int_equal(stp_image_create(NULL, 2, 2, &image), STP_OK);
    add_plane(image, "R", STP_CHANNEL_FLOAT);
    assert_int_equal(stp_image_write_png(&env, image, in_scratch(*state, "x.png", path), 0),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(book.errors, 1);
    stp_image_destroy(&image);
}

static void test_memory(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 1);
    struct stp_image *image = make_image(true);
    in_scratch(*state, "m.png", path);
    for (unsigned long n = 1;; n++) {
        mem_fail_at(n);
        enum stp_result result = stp_image_write_png(&env, image, path, 0);
        bool reached = mem_count() >= n;
        mem_fail_at(0);
        if (!reached) {
            assert_int_equal(result, STP_OK);
            break;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_int_equal(book.errors, n);
        assert_int_equal(access(path, F_OK), -1);
    }
    stp_image_destroy(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_no_color),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, enter_scratch, leave_scratch);
}
