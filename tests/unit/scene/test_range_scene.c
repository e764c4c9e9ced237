/* Range images in scenes: a folder, a scene .json, discs, and what is refused. */
#include "json_files.h"

#include "base/memory.h"
#include "scene/scene.h"

#define SIDE 4

/* Depth `value` everywhere, but none at the first pixel; colours all (200, 100, 50). */
static void put_pictures(const char *folder, const char *depth, const char *color, unsigned value,
                         unsigned side)
{
    char path[PATH_MAX];
    FILE *file = fopen(in_folder(folder, depth, path), "wb");
    assert_non_null(file);
    fprintf(file, "P5 %u %u 65535\n", side, side);
    for (unsigned i = 0; i < side * side; i++) {
        fputc(i ? (int)(value >> 8) : 0, file);
        fputc(i ? (int)(value & 255) : 0, file);
    }
    assert_int_equal(fclose(file), 0);
    file = fopen(in_folder(folder, color, path), "wb");
    assert_non_null(file);
    fprintf(file, "P6 %u %u 255\n", side, side);
    for (unsigned i = 0; i < side * side; i++)
        fprintf(file, "%c%c%c", 200, 100, 50);
    assert_int_equal(fclose(file), 0);
}

static void put_folder(const char *folder)
{
    char path[PATH_MAX];
    mkdir(in_folder(folder, "depth", path), 0700);
    mkdir(in_folder(folder, "color", path), 0700);
    put_pictures(folder, "depth/1.pgm", "color/1.ppm", 2000, SIDE);
    put_pictures(folder, "depth/2.pgm", "color/2.ppm", 3000, SIDE);
    put_file(folder, "intrinsics.txt", "fx 10\nfy 10\ncx 1.5\ncy 1.5\ndepth_scale 1000\n");
    put_file(folder, "pose.txt", "0 0 0 0 0 0 1\n1 0 0 0 0 0 1\n");
}

static void a_folder(void **state)
{
    struct log_book book;
    struct stp_scene *scene;
    struct stp_camera camera;
    put_folder(*state);
    assert_int_equal(load_named(*state, "", NULL, &book, &scene), STP_OK);
    const struct stp_facts *f = stp_scene_facts(scene);
    assert_true(f->range.frames == 2 && f->points == 2 * SIDE * SIDE && f->up == STP_UP_NEG_Y);
    assert_true(stp_scene_camera(scene, 0, 0, &camera));
    assert_true(camera.width == SIDE && camera.fx == 10 && camera.cx == 2 &&
                camera.world_to_camera[5] == -1);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    assert_true(f->splats == 2 * (SIDE * SIDE - 1) && f->range.holes == 2);
    assert_true(fabs(f->bounds[5] - 3) < 1e-6 && fabs(f->bounds[2] - 2) < 1e-6);
    stp_scene_destroy(&scene);
    char path[PATH_MAX];
    unlink(in_folder(*state, "color/2.ppm", path));
    assert_int_equal(load_named(*state, "", NULL, &book, &scene), STP_ERROR_FORMAT);
    assert_non_null(strstr(book.error, "no color/2.png"));
}

/* Poses go with numbers: a picture that is lost, or one too many, shifts none silently. */
static void a_folder_by_numbers(void **state)
{
    struct log_book book;
    struct stp_scene *scene;
    char path[PATH_MAX];
    put_folder(*state);
    put_pictures(*state, "depth/3.pgm", "color/3.ppm", 4000, SIDE);
    put_file(*state, "depth/readme.txt", "no picture");
    put_file(*state, "depth/99999999999999999999.pgm", "nor this");
    assert_int_equal(load_named(*state, "", NULL, &book, &scene), STP_OK);
    assert_int_equal(book.warnings, 1);
    assert_non_null(strstr(book.warning, "1 picture of depth, from depth/3 on"));
    assert_int_equal(scene->volume->range.count, 2);
    stp_scene_destroy(&scene);
    put_pictures(*state, "depth/0.pgm", "color/0.ppm", 1000, SIDE);
    assert_int_equal(load_named(*state, "", NULL, &book, &scene), STP_OK);
    assert_non_null(strstr(book.warning, "2 pictures of depth, from depth/2 on"));
    assert_true(scene->volume->range.frame[0].depth[1] == 1);
    stp_scene_destroy(&scene);
    unlink(in_folder(*state, "depth/0.pgm", path));
    assert_int_equal(load_named(*state, "", NULL, &book, &scene), STP_ERROR_FORMAT);
    assert_non_null(strstr(book.error, "no depth/0.png"));
    static const char *const more[] = { "color/0.ppm", "depth/3.pgm", "color/3.ppm",
                                        "depth/readme.txt", "depth/99999999999999999999.pgm" };
    for (unsigned i = 0; i < sizeof more / sizeof *more; i++)
        unlink(in_folder(*state, more[i], path));
    assert_int_equal(load_named(*state, "", NULL, &book, &scene), STP_OK);
    assert_int_equal(book.warnings, 0);
    stp_scene_destroy(&scene);
}

/* The same points as an ordinary object, unlit. */
static void discs(void **state)
{
    struct log_book book;
    struct stp_scene *scene;
    struct stp_load_params params = { .range = { .splats = STP_RANGE_DISCS } };
    put_folder(*state);
    assert_int_equal(load_named(*state, "", &params, &book, &scene), STP_OK);
    assert_null(scene->volume);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    const struct splats *s = &scene->splats;
    assert_int_equal(s->count, 2 * (SIDE * SIDE - 1));
    for (size_t i = 0; i < s->count; i++) {
        assert_true(fabsf(s->normal[i][2] + 1) < 1e-6f); /* back to the camera */
        double cell = s->position[i][2] / 10;
        assert_true(fabs((double)s->radius[i] - cell * sqrt(0.5)) < 1e-6);
        assert_true(fabsf(s->color[i][0] - 0.57758f) < 1e-4f);
    }
    assert_true(scene->objects[0].material.ambient == 1 && scene->objects[0].material.diffuse == 0);
    stp_scene_destroy(&scene);
}

#define LENS  "\"intrinsics\": {\"fx\": 10, \"fy\": 11, \"cx\": 2, \"cy\": 2}"
#define FILES "\"depth\": \"d.pgm\", \"color\": \"c.ppm\""
#define POSE  "\"pose\": [0,0,0,0,0,0,1]"

static struct stp_scene *expect_json(const char *folder, const char *text)
{
    struct log_book book;
    struct stp_scene *scene;
    put_pictures(folder, "d.pgm", "c.ppm", 2000, SIDE);
    put_file(folder, "s.json", text);
    if (load_named(folder, "s.json", NULL, &book, &scene) != STP_OK || book.warnings)
        fail_msg("%s%s", book.error, book.warning);
    return scene;
}

/* What a frame says wins over what the whole says. */
static void a_scene_file(void **state)
{
    struct stp_scene *scene = expect_json(
        *state,
        "{\"range\": {" LENS ", \"depth_scale\": 500, \"uncertainty\": 2, \"frames\": [{" FILES
        ", " POSE "}, {" FILES ", \"camera_to_world\": [[0,0,1,5],[0,1,0,0],[-1,0,0,0],"
        "[0,0,0,1]], \"depth_scale\": 1000, \"margin\": 1, \"sensor\": {\"type\": "
        "\"stereo\", \"baseline\": 0.1, \"sigma_disparity\": 0.25}}]}}");
    const struct range *range = &scene->volume->range;
    assert_true(range->count == 2 && range->uncertainty == 2 && !range->by_views);
    assert_true(range->frame[0].depth[5] == 4 && range->frame[1].depth[5] == 2);
    assert_true(range->frame[0].depth[0] == 0 && range->frame[1].depth[3] == 0);
    assert_true(range->frame[1].camera.fy == 11 && range->frame[1].camera.to_world[3] == 5);
    assert_int_equal(range->frame[0].sensor.kind, RANGE_STRUCTURED_LIGHT);
    assert_true(range->frame[1].sensor.kind == RANGE_STEREO);
    assert_true(range->frame[1].sensor.sigma_disparity == 0.25);
    stp_scene_destroy(&scene);
}

static void disparities(void **state)
{
    struct stp_scene *scene = expect_json(
        *state, "{\"range\": {" LENS ", \"disparity\": {\"baseline\": 3, \"offset\": 40}, "
                "\"depth_scale\": 100, \"frames\": [{" FILES ", " POSE "}]}}");
    const struct range_frame *f = &scene->volume->range.frame[0];
    assert_true(fabsf(f->depth[5] - 10 * 3 / (20 + 40.f)) < 1e-6f && f->depth[0] == 0);
    assert_true(f->sensor.kind == RANGE_STEREO && f->sensor.baseline == 3);
    stp_scene_destroy(&scene);
}

#define RANGE(rest) "{\"range\": {" rest "}}"
#define FRAME(rest) RANGE(LENS ", \"frames\": [{" rest "}]")
static void what_is_refused(void **state)
{
    static const char *const wrong[][2] = {
        { RANGE(LENS), "range.frames" },
        { RANGE(LENS ", \"frames\": []"), "1 to 1024" },
        { RANGE("\"frames\": [{" FILES ", " POSE "}]"), "intrinsics" },
        { RANGE("\"intrinsics\": {\"fx\": 0, \"fy\": 1, \"cx\": 0, \"cy\": 0}, \"frames\": [{}]"),
          "intrinsics.fx: must be positive" },
        { RANGE("\"intrinsics\": {\"fx\": 1}, \"frames\": [{}]"), "fx, fy, cx and cy" },
        { RANGE("\"intrinsics_file\": \"none.txt\", \"frames\": [{}]"), "none.txt" },
        { FRAME(FILES), "pose or camera_to_world" },
        { FRAME(FILES ", \"pose\": [0,0,0,0,0,0,0]"), "unit quaternion" },
        { FRAME(FILES ", \"pose\": [0,0,0,0,0,1]"), "7 finite numbers" },
        { FRAME(FILES ", \"pose\": [1e999,0,0,0,0,0,1]"), "7 finite numbers" },
        { FRAME(FILES ", \"camera_to_world\": [2,0,0,0,0,2,0,0,0,0,2,0,0,0,0,1]"), "rotation" },
        { FRAME("\"depth\": \"d.pgm\", " POSE), "frames[0].color" },
        { FRAME("\"depth\": \"d.pgm\", \"color\": \"none.png\", " POSE), "none.png" },
        { FRAME("\"depth\": \"d.pgm\", \"color\": \"big.ppm\", " POSE), "must have one size" },
        { FRAME("\"depth\": \"c.ppm\", \"color\": \"c.ppm\", " POSE), "one channel" },
        { FRAME(FILES ", " POSE ", \"sensor\": {\"type\": \"radar\"}"), "structured-light stereo" },
        { FRAME(FILES ", " POSE ", \"sensor\": {\"type\": \"stereo\"}"), "needs a baseline" },
        { FRAME(FILES ", " POSE ", \"sensor\": {\"type\": \"constant\"}"), "sensor.sigma" },
        { FRAME(FILES ", " POSE ", \"margin\": -1"), "margin" },
        { FRAME(FILES ", " POSE ", \"disparity\": {}"), "disparity.baseline" },
        { RANGE(LENS ", \"splats\": \"cubes\", \"frames\": [{}]"), "ellipsoids discs" },
        { RANGE(LENS ", \"uncertainty\": -1, \"frames\": [{}]"), "uncertainty" },
        { "{\"points\": [\"p.xyz\"], \"range\": {" LENS ", \"frames\": [{" FILES ", " POSE "}]}}",
          "range images, or points" },
    };
    put_pictures(*state, "d.pgm", "c.ppm", 2000, SIDE);
    put_pictures(*state, "e.pgm", "big.ppm", 2000, SIDE + 1);
    put_file(*state, "p.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct log_book book;
        struct stp_scene *scene;
        put_file(*state, "s.json", wrong[i][0]);
        assert_int_not_equal(load_named(*state, "s.json", NULL, &book, &scene), STP_OK);
        if (!strstr(book.error, wrong[i][1]))
            fail_msg("%zu: '%s' does not say '%s'", i, book.error, wrong[i][1]);
    }
}

static void colours_that_it_has_not(void **state)
{
    struct log_book book;
    struct stp_scene *scene;
    struct stp_load_params params = { .color_by = "height" };
    put_folder(*state);
    assert_int_equal(load_named(*state, "", &params, &book, &scene), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(book.error, "rgb or views"));
    params =
        (struct stp_load_params){ .color_by = "views", .range = { .splats = STP_RANGE_DISCS } };
    assert_int_equal(load_named(*state, "", &params, &book, &scene), STP_ERROR_ARGUMENT);
    params.range.splats = STP_RANGE_AUTO;
    assert_int_equal(load_named(*state, "", &params, &book, &scene), STP_OK);
    assert_true(scene->volume->range.by_views);
    stp_scene_destroy(&scene);
}

static void every_allocation_fails_once(void **state)
{
    struct stp_load_params params = { 0 };
    put_folder(*state);
    for (int splats = STP_RANGE_ELLIPSOIDS; splats <= STP_RANGE_DISCS; splats++) {
        params.range.splats = (enum stp_range_splats)splats;
        for (unsigned long n = 1;; n++) {
            struct log_book book;
            struct stp_scene *scene = NULL;
            struct stp_env env = logged_env(&book, 1);
            mem_fail_at(n);
            enum stp_result result = stp_scene_load(&env, *state, &params, &scene);
            unsigned long used = mem_count();
            mem_fail_at(0);
            if (result == STP_OK) {
                stp_scene_destroy(&scene);
                assert_true(used < n && n > 10);
                break;
            }
            assert_true(!scene && book.errors == 1);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_folder),
        cmocka_unit_test(a_folder_by_numbers),
        cmocka_unit_test(discs),
        cmocka_unit_test(a_scene_file),
        cmocka_unit_test(disparities),
        cmocka_unit_test(what_is_refused),
        cmocka_unit_test(colours_that_it_has_not),
        cmocka_unit_test(every_allocation_fails_once),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
