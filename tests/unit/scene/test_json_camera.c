/* Camera files: every lens, conventions, sizes, paths, mistakes, and exact round trips. */
#include "json_files.h"

#include "base/memory.h"

#define IDENTITY "\"world_to_camera\": [[1,0,0,0],[0,1,0,0],[0,0,1,-5],[0,0,0,1]]"

static enum stp_result load(const char *folder, const char *text, uint32_t width, uint32_t height,
                            struct stp_camera *camera, struct log_book *book)
{
    char path[PATH_MAX];
    struct stp_env env = logged_env(book, 0);
    put_file(folder, "c.json", text);
    return stp_camera_load(&env, in_folder(folder, "c.json", path), 0, width, height, camera, NULL);
}

static struct stp_camera loaded(const char *folder, const char *text, uint32_t width,
                                uint32_t height)
{
    struct log_book book;
    struct stp_camera camera;
    enum stp_result result = load(folder, text, width, height, &camera, &book);
    if (result != STP_OK || book.warnings)
        fail_msg("%s %s", book.error, book.warning);
    return camera;
}

static void check_lens(const struct stp_camera *c, double fx, double fy, double cx, double cy)
{
    assert_true(fabs(c->fx - fx) < 1e-9 && fabs(c->fy - fy) < 1e-9);
    assert_true(fabs(c->cx - cx) < 1e-9 && fabs(c->cy - cy) < 1e-9);
}

static void test_fov(void **state)
{
    const char *text = "{" IDENTITY ", \"fov_y_deg\": 90, \"width\": 640, \"height\": 480}";
    struct stp_camera c = loaded(*state, text, 0, 0);
    assert_int_equal(c.width, 640);
    assert_int_equal(c.height, 480);
    check_lens(&c, 240, 240, 320, 240);
    assert_true(!c.orthographic && c.near_depth == STP_DEFAULT_NEAR && isinf(c.far_depth));
    assert_true(c.world_to_camera[11] == -5 && c.world_to_camera[0] == 1);
    /* A size wins; the field of view stays. */
    c = loaded(*state, text, 1000, 100);
    check_lens(&c, 50, 50, 500, 50);
    c = loaded(*state, text, 0, 960);
    assert_int_equal(c.width, 640);
    check_lens(&c, 480, 480, 320, 480);
    c = loaded(*state, "{" IDENTITY ", \"fov_y_deg\": 90}", 0, 0);
    assert_int_equal(c.width, 1280);
    check_lens(&c, 360, 360, 640, 360);
}

static void test_orthographic(void **state)
{
    const char *text = "{" IDENTITY ", \"ortho_height\": 4, \"width\": 200, \"height\": 100, "
                       "\"near\": -3, \"far\": 9}";
    struct stp_camera c = loaded(*state, text, 0, 0);
    assert_true(c.orthographic && c.near_depth == -3 && c.far_depth == 9);
    check_lens(&c, 25, 25, 100, 50);
    c = loaded(*state, text, 400, 400);
    check_lens(&c, 100, 100, 200, 200);
}

static void test_intrinsics(void **state)
{
    const char *text = "{" IDENTITY ", \"intrinsics\": {\"fx\": 500, \"fy\": 510, \"cx\": 310, "
                       "\"cy\": 250}, \"width\": 640, \"height\": 480, \"far\": null}";
    struct stp_camera c = loaded(*state, text, 0, 0);
    check_lens(&c, 500, 510, 310, 250);
    c = loaded(*state, text, 1280, 480);
    check_lens(&c, 1000, 510, 620, 250);
    c = loaded(*state, text, 320, 240);
    check_lens(&c, 250, 255, 155, 125);
}

/* y and z of an OpenCV camera point the other way; 16 flat numbers are as good. */
static void test_opencv(void **state)
{
    struct stp_camera c = loaded(*state,
                                 "{\"world_to_camera\": [0.6,0.8,0,1, -0.8,0.6,0,2, 0,0,1,3, "
                                 "0,0,0,1], \"convention\": \"opencv\", \"fov_y_deg\": 60}",
                                 0, 0);
    const double expected[16] = { 0.6, 0.8, 0, 1, 0.8, -0.6, 0, -2, 0, 0, -1, -3, 0, 0, 0, 1 };
    assert_memory_equal(c.world_to_camera, expected, sizeof expected);
}

/* A matrix of seven digits becomes an exact rotation about the same eye. */
static void test_polish(void **state)
{
    struct stp_camera c = loaded(
        *state,
        "{\"world_to_camera\": [[0.2752179,-0.9613807,-0.0015192,-2.5],[-0.2117574,-0.0590790,"
        "-0.9755350,100],[0.9377708,0.2688064,-0.2198391,7],[0,0,0,1]],\"fov_y_deg\":40}",
        0, 0);
    const double *m = c.world_to_camera;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double dot =
                m[4 * i] * m[4 * j] + m[4 * i + 1] * m[4 * j + 1] + m[4 * i + 2] * m[4 * j + 2];
            assert_true(fabs(dot - (i == j)) < 1e-15);
        }
    assert_true(fabs(m[0] - 0.2752179) < 1e-6 && fabs(m[6] + 0.9755350) < 1e-6);
    assert_true(fabs(m[7] - 100) < 1e-4);
}

static void test_path(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 0);
    struct stp_camera c;
    uint32_t count = 0;
    put_file(*state, "p.json",
             "[{" IDENTITY ", \"fov_y_deg\": 90, \"near\": 1}, {" IDENTITY
             ", \"fov_y_deg\": 90, \"near\": 2}, {}]");
    in_folder(*state, "p.json", path);
    assert_int_equal(stp_camera_load(&env, path, 1, 0, 0, &c, &count), STP_OK);
    assert_int_equal(count, 3);
    assert_true(c.near_depth == 2);
    assert_int_equal(stp_camera_load(&env, path, 3, 0, 0, &c, &count), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(book.error, "no frame 3"));
    assert_int_equal(stp_camera_load(&env, path, 2, 0, 0, &c, &count), STP_ERROR_FORMAT);
    assert_non_null(strstr(book.error, "p.json: [2].world_to_camera: missing"));
    put_file(*state, "p.json", "[]");
    assert_int_equal(stp_camera_load(&env, path, 0, 0, 0, &c, &count), STP_ERROR_FORMAT);
    assert_int_equal(book.errors, 3);
}

static void test_mistakes(void **state)
{
    static const char *const cases[][2] = {
        { "", "byte 0" },
        { "{\n \"near\": 1,\n}", "broken JSON at byte 14 (line 3, column 1)" },
        { "{} x", "broken JSON at byte 3 (line 1, column 4)" },
        { "3", "an object is needed" },
        { "{\"fov_y_deg\": 30}", "world_to_camera: missing" },
        { "{\"world_to_camera\": [1,2,3]}", "world_to_camera: an array of 16 finite numbers" },
        { "{\"world_to_camera\": \"a\"}", "world_to_camera: an array of 16" },
        { "{\"world_to_camera\": [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]}", "row lengths 2 2 2" },
        { "{\"world_to_camera\": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}", "determinant -1" },
        { "{\"world_to_camera\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 3,4,5,1]}", "last row" },
        { "{" IDENTITY ", \"convention\": \"maya\", \"fov_y_deg\": 3}", "convention: opengl or" },
        { "{" IDENTITY "}", "exactly one of fov_y_deg, ortho_height and intrinsics" },
        { "{" IDENTITY ", \"fov_y_deg\": 3, \"ortho_height\": 3}", "exactly one of" },
        { "{" IDENTITY ", \"fov_y_deg\": 180}", "fov_y_deg: degrees between" },
        { "{" IDENTITY ", \"fov_y_deg\": \"30\"}", "fov_y_deg: a finite number" },
        { "{" IDENTITY ", \"fov_y_deg\": 1e999}", "fov_y_deg: a finite number" },
        { "{" IDENTITY ", \"ortho_height\": -1}", "ortho_height: must be positive" },
        { "{" IDENTITY ", \"intrinsics\": {\"fx\": 1, \"fy\": 1, \"cx\": 1, \"cy\": 1}}",
          "intrinsics need width and height" },
        { "{" IDENTITY ", \"intrinsics\": {\"fx\": 1}, \"width\": 4, \"height\": 4}",
          "intrinsics.fy: missing" },
        { "{" IDENTITY ", \"intrinsics\": 4, \"width\": 4, \"height\": 4}", "intrinsics." },
        { "{" IDENTITY ", \"fov_y_deg\": 30, \"width\": 1.5, \"height\": 4}", "width: a whole" },
        { "{" IDENTITY ", \"fov_y_deg\": 30, \"width\": 4}", "go together" },
        { "{" IDENTITY ", \"fov_y_deg\": 30, \"near\": 0}", "near: must be positive" },
        { "{" IDENTITY ", \"fov_y_deg\": 30, \"near\": 2, \"far\": 2}", "far: must be beyond" },
        { "{" IDENTITY ", \"fov_y_deg\": 30, \"far\": \"a\"}", "far: a finite number" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct log_book book;
        struct stp_camera camera, untouched;
        memset(&camera, 0x5a, sizeof camera);
        memset(&untouched, 0x5a, sizeof untouched);
        assert_int_equal(load(*state, cases[i][0], 0, 0, &camera, &book), STP_ERROR_FORMAT);
        assert_int_equal(book.errors, 1);
        if (!strstr(book.error, cases[i][1]) || !strstr(book.error, "c.json"))
            fail_msg("%s: %s", cases[i][0], book.error);
        assert_memory_equal(&camera, &untouched, sizeof camera);
    }
}

static void test_unknown_keys(void **state)
{
    struct log_book book;
    struct stp_camera camera;
    assert_int_equal(
        load(*state, "{" IDENTITY ", \"fov_y_deg\": 30, \"fov\": 3}", 0, 0, &camera, &book),
        STP_OK);
    assert_int_equal(book.warnings, 1);
    assert_non_null(strstr(book.warning, "fov: unknown key"));
}

static double random_double(void)
{
    return rand() / (double)RAND_MAX + rand() / (double)RAND_MAX * 1e-9;
}

/* A random rotation from a random quaternion. */
static void random_view(double m[16])
{
    double q[4], length = 0;
    for (int i = 0; i < 4; i++) {
        q[i] = random_double() - 0.5;
        length += q[i] * q[i];
    }
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(length);
    double w = q[0], x = q[1], y = q[2], z = q[3];
    const double view[16] = { 1 - 2 * (y * y + z * z),
                              2 * (x * y - w * z),
                              2 * (x * z + w * y),
                              random_double() * 1e7,
                              2 * (x * y + w * z),
                              1 - 2 * (x * x + z * z),
                              2 * (y * z - w * x),
                              random_double(),
                              2 * (x * z - w * y),
                              2 * (y * z + w * x),
                              1 - 2 * (x * x + y * y),
                              -random_double(),
                              0,
                              0,
                              0,
                              1 };
    memcpy(m, view, sizeof view);
}

static void test_round_trip(void **state)
{
    char path[PATH_MAX];
    srand(4);
    in_folder(*state, "r.json", path);
    for (int i = 0; i < 600; i++) {
        struct stp_camera c = { .orthographic = i % 2,
                                .width = 1 + (uint32_t)rand() % 4000,
                                .height = 1 + (uint32_t)rand() % 4000,
                                .near_depth = random_double() + 1e-9,
                                .far_depth = i % 3 ? INFINITY : 2 + random_double() },
                          back;
        memset(&back, 0, sizeof back);
        random_view(c.world_to_camera);
        c.fx = c.fy = random_double() * 1000 + 1e-3;
        c.cx = c.width / 2.0;
        c.cy = c.height / 2.0;
        if (i % 5 == 0) {
            c.fx = random_double() * 1000 + 1e-3;
            c.cx = random_double() * 100;
        }
        assert_int_equal(stp_camera_save(NULL, path, &c), STP_OK);
        assert_int_equal(stp_camera_load(NULL, path, 0, 0, 0, &back, NULL), STP_OK);
        assert_memory_equal(back.world_to_camera, c.world_to_camera, sizeof c.world_to_camera);
        assert_true(back.fx == c.fx && back.fy == c.fy && back.cx == c.cx && back.cy == c.cy);
        assert_true(back.near_depth == c.near_depth && back.far_depth == c.far_depth);
        assert_true(back.width == c.width && back.height == c.height);
        assert_int_equal(back.orthographic, c.orthographic);
    }
}

static void test_save_refuses(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 0);
    struct stp_camera c = { .fx = 1, .fy = NAN, .width = 1, .height = 1 };
    in_folder(*state, "never.json", path);
    assert_int_equal(stp_camera_save(&env, path, &c), STP_ERROR_ARGUMENT);
    assert_int_equal(book.errors, 1);
    assert_int_equal(access(path, F_OK), -1);
}

static void test_memory(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 0);
    struct stp_camera c = loaded(*state, "{" IDENTITY ", \"fov_y_deg\": 90}", 0, 0);
    in_folder(*state, "m.json", path);
    for (unsigned long n = 1;; n++) {
        mem_fail_at(n);
        enum stp_result result = stp_camera_save(&env, path, &c);
        bool reached = mem_count() >= n;
        mem_fail_at(0);
        if (!reached)
            break;
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_int_equal(book.errors, n);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fov),        cmocka_unit_test(test_orthographic),
        cmocka_unit_test(test_intrinsics), cmocka_unit_test(test_opencv),
        cmocka_unit_test(test_polish),     cmocka_unit_test(test_path),
        cmocka_unit_test(test_mistakes),   cmocka_unit_test(test_unknown_keys),
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_save_refuses),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
