/* A disk that fills up, and places that cannot be written: one line, the old file whole, nothing
 * left behind; for EXR, PNG and camera files. */
#include "helpers.h"

#include <signal.h>
#include <sys/resource.h>

typedef enum stp_result (*write_fn)(const struct stp_env *env, const struct stp_image *image,
                                    const char *path);

static enum stp_result write_zip(const struct stp_env *env, const struct stp_image *image,
                                 const char *path)
{
    return stp_image_write_exr(env, image, path, NULL);
}
static enum stp_result write_none(const struct stp_env *env, const struct stp_image *image,
                                  const char *path)
{
    const struct stp_exr_params params = { .compression = STP_COMPRESSION_NONE };
    return stp_image_write_exr(env, image, path, &params);
}
static enum stp_result write_deep(const struct stp_env *env, const struct stp_image *image,
                                  const char *path)
{
    return stp_image_write_deep_exr(env, image, path, NULL);
}
static enum stp_result write_png(const struct stp_env *env, const struct stp_image *image,
                                 const char *path)
{
    return stp_image_write_png(env, image, path, 0);
}
static enum stp_result write_camera(const struct stp_env *env, const struct stp_image *image,
                                    const char *path)
{
    return stp_camera_save(env, path, &image->camera);
}
static const write_fn writers[] = { write_zip, write_none, write_deep, write_png, write_camera };

static struct stp_image *make_image(void)
{
    const char *names[] = { "R", "G", "B", "A", "Z" };
    struct stp_image *image = NULL;
    uint32_t seed = 3;
    assert_int_equal(stp_image_create(NULL, 90, 70, &image), STP_OK);
    for (int c = 0; c < 5; c++) {
        float *plane = add_plane(image, names[c], STP_CHANNEL_FLOAT)->data.f;
        for (int i = 0; i < 90 * 70; i++)
            plane[i] = (float)(next_random(&seed) / 4294967296.0);
    }
    image->camera =
        (struct stp_camera){ .world_to_camera = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 },
                             .fx = 40,
                             .fy = 40,
                             .cx = 45,
                             .cy = 35,
                             .width = 90,
                             .height = 70,
                             .near_depth = 1,
                             .far_depth = INFINITY };
    return image;
}

static void limit_files(rlim_t bytes)
{
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void test_full_disk(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_image *image = make_image();
    in_scratch(*state, "out", path);
    for (size_t w = 0; w < sizeof writers / sizeof *writers; w++) {
        size_t whole, size;
        assert_int_equal(writers[w](NULL, image, path), STP_OK);
        free(slurp(path, &whole));
        spill(path, "old", 3);
        for (size_t room = 0; room < whole; room += whole / 13 + 1) {
            struct stp_env env = logged_env(&book, 2);
            limit_files(room);
            enum stp_result result = writers[w](&env, image, path);
            limit_files(RLIM_INFINITY);
            assert_int_equal(result, STP_ERROR_IO);
            assert_int_equal(book.errors, 1);
            assert_non_null(strstr(book.error, "out: cannot write: File too large"));
            unsigned char *old = slurp(path, &size);
            assert_int_equal(size, 3);
            assert_memory_equal(old, "old", 3);
            free(old);
            assert_int_equal(files_in(*state), 1);
        }
    }
    unlink(path);
    stp_image_destroy(&image);
}

static void test_no_such_place(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_image *image = make_image();
    spill(in_scratch(*state, "file", path), "old", 3);
    for (size_t w = 0; w < sizeof writers / sizeof *writers; w++) {
        struct stp_env env = logged_env(&book, 1);
        in_scratch(*state, "missing/out", path);
        assert_int_equal(writers[w](&env, image, path), STP_ERROR_IO);
        assert_non_null(strstr(book.error, "missing/out: cannot write: No such file"));
        in_scratch(*state, "file/out", path);
        assert_int_equal(writers[w](&env, image, path), STP_ERROR_IO);
        assert_non_null(strstr(book.error, "file/out: cannot write: Not a directory"));
        assert_int_equal(book.errors, 2);
    }
    assert_int_equal(files_in(*state), 1);
    stp_image_destroy(&image);
}

static int set_up(void **state)
{
    signal(SIGXFSZ, SIG_IGN);
    return enter_scratch(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_no_such_place),
    };
    return cmocka_run_group_tests(tests, set_up, leave_scratch);
}
