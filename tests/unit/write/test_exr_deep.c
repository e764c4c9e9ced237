/* Deep files: read back by OpenImageIO, through OpenEXR's own library; failures leave nothing. */
#include "helpers.h"

#include "base/memory.h"
#include "scene/deep.h"

#define WIDTH  37
#define HEIGHT 70 /* more lines than are packed at once */

/* Values that half holds exactly. Every ninth line is empty, and so are many pixels. */
static struct stp_image *make_image(bool half)
{
    static const char *const names[] = { "R", "G", "B", "A", "Z" };
    struct stp_image *image = NULL;
    struct deep_list list = { 0 };
    uint32_t seed = 5;
    assert_int_equal(stp_image_create(NULL, WIDTH, HEIGHT, &image), STP_OK);
    for (int c = 0; c < 5; c++)
        add_plane(image, names[c], STP_CHANNEL_FLOAT)->half = half && c < 4;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        uint32_t count = i / WIDTH % 9 == 4 ? 0 : next_random(&seed) % 5;
        if (i == 1234)
            count = 333;
        for (uint32_t k = 0; k < count; k++) {
            struct stp_deep_layer layer = { .z = (float)(k + 1) / 3,
                                            .alpha = (float)(next_random(&seed) % 64) / 64 };
            for (int c = 0; c < 3; c++)
                layer.color[c] = (float)(next_random(&seed) % 2048) / 64;
            assert_int_equal(deep_add(&list, i, &layer), STP_OK);
        }
    }
    assert_int_equal(deep_build(NULL, &list, 1, WIDTH * HEIGHT, &image->deep), STP_OK);
    deep_list_release(&list);
    return image;
}

static void write_as(const struct stp_image *image, const char *folder, const char *name,
                     enum stp_compression compression, unsigned threads)
{
    char path[PATH_MAX];
    const struct stp_env env = { .threads = threads };
    const struct stp_exr_params params = { .compression = compression, .comment = "one sentence" };
    assert_int_equal(stp_image_write_deep_exr(&env, image, in_scratch(folder, name, path), &params),
                     STP_OK);
}

static const char *expect_layer(const char *at, const struct stp_deep_layer *layer)
{
    float r, g, b, a, z, back;
    int length = 0;
    int found =
        sscanf(at, " R=%f G=%f B=%f A=%f Z=%f ZBack=%f %n", &r, &g, &b, &a, &z, &back, &length);
    if (found != 6)
        fail_msg("%.80s", at);
    assert_true(r == layer->color[0] && g == layer->color[1] && b == layer->color[2]);
    assert_true(a == layer->alpha && z == layer->z && back == layer->z);
    return at + length + (at[length] == '/');
}

/* What `oiiotool --dumpdata` prints is the picture's layers, every digit of them. */
static void expect_dump(const struct stp_image *image, char *text)
{
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        size_t first = image->deep->first[i], count = image->deep->first[i + 1] - first;
        char start[64];
        snprintf(start, sizeof start, "Pixel (%u, %u): %zu samples", i % WIDTH, i / WIDTH, count);
        const char *at = find_line(&text, start);
        if (!at)
            fail_msg("no %s", start);
        at += strlen(start);
        if (count)
            at = strchr(at, ':') + 1;
        for (size_t k = 0; k < count; k++)
            at = expect_layer(at, &image->deep->layer[first + k]);
    }
}

static void test_read_by_others(void **state)
{
    static const enum stp_compression compressions[] = { STP_COMPRESSION_NONE, STP_COMPRESSION_ZIPS,
                                                         STP_COMPRESSION_ZIP, STP_COMPRESSION_PIZ };
    for (int i = 0; i < 8; i++) {
        struct stp_image *image = make_image(i % 2);
        write_as(image, *state, "deep.exr", compressions[i / 2], 2);
        char *text = run_tool(*state, "oiiotool --dumpdata deep.exr");
        expect_dump(image, text);
        free(text);
        text = run_tool(*state, "exrheader deep.exr");
        assert_non_null(strstr(text, "maxSamplesPerPixel (type int): 333"));
        assert_non_null(strstr(text, "type (type string): \"deepscanline\""));
        assert_non_null(
            strstr(text, i < 2 ? "compression): none" : "compression): zip, individual"));
        assert_non_null(strstr(text, i % 2 ? "A, 16-bit floating-point" : "A, 32-bit"));
        assert_non_null(strstr(text, "one sentence"));
        free(text);
        stp_image_destroy(&image);
    }
}

/* One layer a pixel with a finite Z, from the planes; without a camera, and with one. */
static void test_planes(void **state)
{
    struct stp_image *image = make_image(false);
    struct stp_deep *layers = image->deep;
    image->deep = NULL;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++)
        for (unsigned c = 0; c < 5; c++)
            image->channels[c].data.f[i] = i % 3 == 0 ? (c == 4 ? INFINITY : 0)
                                           : c == 3   ? 1
                                                      : (float)(i * 7 + c) / 16;
    write_as(image, *state, "deep.exr", STP_COMPRESSION_ZIP, 2);
    char *text = run_tool(*state, "oiiotool --dumpdata deep.exr");
    assert_non_null(strstr(text, "Pixel (0, 0): 0 samples"));
    struct stp_deep_layer second = { 11.0f / 16, { 7.0f / 16, 8.0f / 16, 9.0f / 16 }, 1 };
    expect_layer(strstr(text, "Pixel (1, 0): 1 samples :") + 25, &second);
    free(text);
    image->deep = layers;
    stp_image_destroy(&image);
}

static void test_same_bytes(void **state)
{
    char path[PATH_MAX];
    size_t one, many;
    struct stp_image *image = make_image(false);
    write_as(image, *state, "a.exr", STP_COMPRESSION_ZIP, 1);
    write_as(image, *state, "b.exr", STP_COMPRESSION_ZIP, 7);
    unsigned char *a = slurp(in_scratch(*state, "a.exr", path), &one);
    unsigned char *b = slurp(in_scratch(*state, "b.exr", path), &many);
    assert_int_equal(one, many);
    assert_memory_equal(a, b, one);
    free(a);
    free(b);
    stp_image_destroy(&image);
}

static void test_refused(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 1);
    struct stp_image *image = NULL;
    assert_int_equal(stp_image_create(NULL, 2, 2, &image), STP_OK);
    in_scratch(*state, "refused.exr", path);
    assert_int_equal(stp_image_write_deep_exr(&env, image, path, NULL), STP_ERROR_ARGUMENT);
    add_plane(image, "R", STP_CHANNEL_FLOAT);
    assert_int_equal(stp_image_write_deep_exr(&env, image, path, NULL), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(book.error, "no channel G"));
    assert_int_equal(book.errors, 2);
    assert_int_equal(access(path, F_OK), -1);
    stp_image_destroy(&image);
}

/* Each allocation fails in turn: one line, no file, and nothing is leaked (under the sanitizer). */
static void test_memory(void **state)
{
    char path[PATH_MAX];
    bool done = false;
    struct stp_image *image = make_image(true);
    struct stp_deep *layers = image->deep;
    in_scratch(*state, "memory.exr", path);
    for (int planes = 0; planes < 2; planes++) {
        image->deep = planes ? NULL : layers;
        done = false;
        for (unsigned long n = 1; !done; n++) {
            struct log_book book;
            struct stp_env env = logged_env(&book, 1);
            mem_fail_at(n);
            enum stp_result result = stp_image_write_deep_exr(&env, image, path, NULL);
            done = mem_count() < n;
            mem_fail_at(0);
            assert_int_equal(result, done ? STP_OK : STP_ERROR_MEMORY);
            assert_int_equal(book.errors, done ? 0 : 1);
            assert_int_equal(access(path, F_OK), done ? 0 : -1);
        }
        unlink(path);
    }
    image->deep = layers;
    stp_image_destroy(&image);
}

static int set_up(void **state)
{
    static char folder[64];
    make_scratch(folder);
    *state = folder;
    return 0;
}

static int tear_down(void **state)
{
    remove_scratch(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_read_by_others), cmocka_unit_test(test_planes),
        cmocka_unit_test(test_same_bytes),     cmocka_unit_test(test_refused),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
