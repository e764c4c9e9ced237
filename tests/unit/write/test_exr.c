/* EXR files out and in: every compression, every size class, bit for bit; independence of the
 * number of threads; damage. */
#include "helpers.h"

#include "base/memory.h"
#include "write/half.h"

static const enum stp_compression compressions[] = { STP_COMPRESSION_NONE, STP_COMPRESSION_ZIPS,
                                                     STP_COMPRESSION_ZIP, STP_COMPRESSION_PIZ };

/* Channels in no order, of every type; smooth, noisy and special values. */
static struct stp_image *make_image(uint32_t width, uint32_t height, uint32_t seed)
{
    static const float special[] = {
        0.0f, -0.0f, 1e-42f, INFINITY, -INFINITY, 65504, 1e9f, -3e-8f
    };
    const char *names[] = { "Z", "R", "G", "N.X", "B", "A" };
    struct stp_image *image = NULL;
    assert_int_equal(stp_image_create(NULL, width, height, &image), STP_OK);
    size_t pixels = (size_t)width * height;
    for (int c = 0; c < 6; c++) {
        struct stp_channel *channel = add_plane(image, names[c], STP_CHANNEL_FLOAT);
        channel->half = c >= 3;
        for (size_t i = 0; i < pixels; i++) {
            uint32_t r = next_random(&seed);
            channel->data.f[i] = c % 2        ? sinf((float)i * 0.01f)
                                 : r % 4 == 0 ? special[r / 4 % 8]
                                              : (float)(r / 4294967296.0) * 100 - 50;
        }
    }
    struct stp_channel *id = add_plane(image, "id", STP_CHANNEL_UINT);
    for (size_t i = 0; i < pixels; i++)
        id->data.u[i] = i % 3 ? next_random(&seed) : UINT32_MAX;
    image->two_sided = true;
    return image;
}

static double half_value(unsigned half)
{
    int exponent = (int)(half >> 10 & 31), mantissa = (int)(half & 1023);
    double magnitude = exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24);
    return half & 0x8000 ? -magnitude : magnitude;
}

/* read is what written must come back as. */
static void check_same(const struct stp_image *written, const struct stp_image *read)
{
    assert_int_equal(read->width, written->width);
    assert_int_equal(read->height, written->height);
    assert_int_equal(read->channel_count, written->channel_count);
    size_t pixels = (size_t)written->width * written->height;
    for (unsigned c = 0; c < written->channel_count; c++) {
        const struct stp_channel *a = &written->channels[c];
        const struct stp_channel *b = stp_image_find(read, a->name);
        assert_non_null(b);
        assert_int_equal(b->type, a->type);
        assert_int_equal(b->half, a->half);
        if (!a->half)
            assert_memory_equal(a->data.u, b->data.u, 4 * pixels);
        for (size_t i = 0; a->half && i < pixels; i++) {
            float expected = (float)half_value(half_from_float(a->data.f[i]));
            assert_memory_equal(&b->data.f[i], &expected, sizeof expected);
        }
    }
}

static void test_round_trip(void **state)
{
    static const uint32_t sizes[][2] = { { 1, 1 },     { 1, 300 }, { 300, 1 },  { 7, 3 },
                                         { 130, 257 }, { 64, 16 }, { 4099, 17 } };
    const char *folder = *state;
    char path[PATH_MAX];
    struct log_book book;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int c = 0; c < 4; c++) {
            struct stp_env env = logged_env(&book, c % 2 ? 3 : 0);
            struct stp_exr_params params = { .compression = compressions[c] };
            struct stp_image *image = make_image(sizes[s][0], sizes[s][1], 7 + (uint32_t)s);
            struct stp_image *read = NULL;
            in_scratch(folder, "a.exr", path);
            assert_int_equal(stp_image_write_exr(&env, image, path, &params), STP_OK);
            assert_int_equal(stp_image_read_exr(&env, path, &read), STP_OK);
            check_same(image, read);
            assert_true(read->two_sided);
            assert_int_equal(book.errors + book.warnings, 0);
            stp_image_destroy(&image);
            stp_image_destroy(&read);
        }
}

static void test_nan_survives(void **state)
{
    char path[PATH_MAX];
    struct stp_image *image = NULL, *read = NULL;
    assert_int_equal(stp_image_create(NULL, 2, 1, &image), STP_OK);
    add_plane(image, "R", STP_CHANNEL_FLOAT)->data.f[0] = NAN;
    struct stp_channel *half = add_plane(image, "G", STP_CHANNEL_FLOAT);
    half->half = true;
    half->data.f[1] = NAN;
    in_scratch(*state, "nan.exr", path);
    assert_int_equal(stp_image_write_exr(NULL, image, path, NULL), STP_OK);
    assert_int_equal(stp_image_read_exr(NULL, path, &read), STP_OK);
    assert_true(isnan(stp_image_find(read, "R")->data.f[0]));
    assert_true(isnan(stp_image_find(read, "G")->data.f[1]));
    assert_float_equal(stp_image_find(read, "G")->data.f[0], 0, 0);
    stp_image_destroy(&image);
    stp_image_destroy(&read);
}

static void test_threads_same_bytes(void **state)
{
    char path[PATH_MAX];
    struct stp_image *image = make_image(700, 401, 99);
    in_scratch(*state, "t.exr", path);
    for (int c = 0; c < 4; c++) {
        unsigned char *first = NULL;
        size_t first_size = 0;
        for (unsigned threads = 1; threads <= 7; threads += 3) {
            struct stp_env env = { .threads = threads };
            struct stp_exr_params params = { .compression = compressions[c], .comment = "a" };
            size_t size;
            assert_int_equal(stp_image_write_exr(&env, image, path, &params), STP_OK);
            unsigned char *bytes = slurp(path, &size);
            if (!first) {
                first = bytes;
                first_size = size;
                continue;
            }
            assert_int_equal(size, first_size);
            assert_memory_equal(bytes, first, size);
            free(bytes);
        }
        free(first);
    }
    stp_image_destroy(&image);
}

static void test_bad_pictures(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 1);
    struct stp_image *image = NULL;
    assert_int_equal(stp_image_create(NULL, 2, 2, &image), STP_OK);
    in_scratch(*state, "bad.exr", path);
    assert_int_equal(stp_image_write_exr(&env, image, path, NULL), STP_ERROR_ARGUMENT);
    add_plane(image, "R", STP_CHANNEL_FLOAT);
    add_plane(image, "G", STP_CHANNEL_FLOAT);
    strcpy(image->channels[1].name, "R");
    assert_int_equal(stp_image_write_exr(&env, image, path, NULL), STP_ERROR_ARGUMENT);
    assert_int_equal(book.errors, 2);
    assert_int_equal(access(path, F_OK), -1);
    stp_image_destroy(&image);
}

/* Every prefix of a file, and many flipped bytes: an error with one line, or a picture. */
static void test_damage(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    uint32_t seed = 5;
    for (int c = 0; c < 4; c++) {
        struct stp_image *image = make_image(9, 20, 3), *read = NULL;
        struct stp_exr_params params = { .compression = compressions[c] };
        size_t size;
        in_scratch(*state, "damaged.exr", path);
        assert_int_equal(stp_image_write_exr(NULL, image, path, &params), STP_OK);
        unsigned char *bytes = slurp(path, &size);
        for (size_t cut = 0; cut < size; cut += cut < 500 ? 7 : 97) {
            struct stp_env env = logged_env(&book, 2);
            spill(path, bytes, cut);
            assert_int_equal(stp_image_read_exr(&env, path, &read), STP_ERROR_FORMAT);
            assert_null(read);
            assert_int_equal(book.errors, 1);
            assert_non_null(strstr(book.error, "damaged.exr"));
        }
        for (int flip = 0; flip < 300; flip++) {
            struct stp_env env = logged_env(&book, 2);
            size_t at = next_random(&seed) % (flip % 2 ? size : 600);
            unsigned char old = bytes[at];
            bytes[at] = (unsigned char)next_random(&seed);
            spill(path, bytes, size);
            enum stp_result result = stp_image_read_exr(&env, path, &read);
            assert_int_equal(book.errors, result != STP_OK);
            stp_image_destroy(&read);
            bytes[at] = old;
        }
        free(bytes);
        stp_image_destroy(&image);
    }
}

/* A small part of a large picture is read; a few hundred bytes that claim one of gigabytes are not.
 */
static void test_display_window(void **state)
{
    static const struct {
        int32_t last;
        enum stp_result result;
    } cases[] = { { 1999, STP_OK }, { 65534, STP_ERROR_FORMAT }, { 65536, STP_ERROR_FORMAT } };
    char folder[64], path[PATH_MAX];
    struct stp_image *image = make_image(8, 8, 1), *read = NULL;
    make_scratch(folder);
    in_scratch(folder, "a.exr", path);
    assert_int_equal(stp_image_write_exr(NULL, image, path, NULL), STP_OK);
    size_t size;
    unsigned char *data = slurp(path, &size);
    unsigned char *window = memmem(data, size, "displayWindow\0box2i", 19);
    assert_non_null(window);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const int32_t box[4] = { 0, 0, cases[i].last, cases[i].last };
        struct log_book book;
        struct stp_env env = logged_env(&book, 1);
        memcpy(window + 24, box, sizeof box);
        spill(path, data, size);
        assert_int_equal(stp_image_read_exr(&env, path, &read), cases[i].result);
        assert_int_equal(book.errors, cases[i].result != STP_OK);
        assert_true(!read || read->width == 2000);
        stp_image_destroy(&read);
    }
    free(data);
    stp_image_destroy(&image);
    remove_scratch(folder);
}

static void test_memory(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_image *image = make_image(40, 70, 3);
    in_scratch(*state, "memory.exr", path);
    for (int c = 0; c < 4; c++) {
        struct stp_env env = logged_env(&book, 1);
        struct stp_exr_params params = { .compression = compressions[c] };
        unsigned files = files_in(*state);
        for (unsigned long n = 1;; n++) {
            mem_fail_at(n);
            enum stp_result result = stp_image_write_exr(&env, image, path, &params);
            bool reached = mem_count() >= n;
            mem_fail_at(0);
            if (!reached) {
                assert_int_equal(result, STP_OK);
                break;
            }
            assert_int_equal(result, STP_ERROR_MEMORY);
            assert_int_equal(book.errors, n);
            assert_int_equal(files_in(*state), files);
        }
        for (unsigned long n = 1, errors = book.errors;; n++) {
            struct stp_image *read = NULL;
            mem_fail_at(n);
            enum stp_result result = stp_image_read_exr(&env, path, &read);
            bool reached = mem_count() >= n;
            mem_fail_at(0);
            if (!reached) {
                assert_int_equal(result, STP_OK);
                stp_image_destroy(&read);
                break;
            }
            assert_int_equal(result, STP_ERROR_MEMORY);
            assert_null(read);
            assert_int_equal(book.errors, errors + n);
        }
        unlink(path);
    }
    stp_image_destroy(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_nan_survives),
        cmocka_unit_test(test_threads_same_bytes),
        cmocka_unit_test(test_bad_pictures),
        cmocka_unit_test(test_damage),
        cmocka_unit_test(test_display_window),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, enter_scratch, leave_scratch);
}
