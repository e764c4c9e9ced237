/* The picture as a whole: samples, planes, threads, hard coordinates, failures. */
#include "fixture.h"

#include "base/memory.h"
#include "scene/samples.h"

static void sample_positions(void **state)
{
    /* From the formula in docs/numerics.md, evaluated by other means. */
    static const struct {
        unsigned grid;
        uint32_t i, j, index;
        double px, py;
    } pinned[4] = {
        { 2, 0, 0, 0, 0.19567489624023438, 0.09546279907226562 },
        { 2, 0, 0, 3, 0.6431999206542969, 0.8011817932128906 },
        { 4, 100, 57, 6, 100.62054252624512, 57.28039741516113 },
        { 3, 16383, 1023, 8, 16383.964113871256, 1023.8871637980143 },
    };
    double px, py;
    for (int k = 0; k < 4; k++) {
        sample_position(pinned[k].grid, pinned[k].i, pinned[k].j, pinned[k].index, &px, &py);
        close_to(px, pinned[k].px, 1e-11);
        close_to(py, pinned[k].py, 1e-11);
    }
    sample_position(1, 7, 9, 0, &px, &py);
    assert_true(px == 7.5 && py == 9.5);
    assert_int_equal(sample_grid(0), 1);
    assert_int_equal(sample_grid(1), 1);
    assert_int_equal(sample_grid(2), 2);
    assert_int_equal(sample_grid(4), 2);
    assert_int_equal(sample_grid(5), 3);
    assert_int_equal(sample_grid(65536), 256);
}

static void samples_stay_in_their_cells(void **state)
{
    double mean = 0;
    for (unsigned grid = 2; grid <= 5; grid++)
        for (uint32_t p = 0; p < 400; p++)
            for (uint32_t k = 0; k < grid * grid; k++) {
                double px, py;
                sample_position(grid, p % 20, p / 20, k, &px, &py);
                double x = (px - p % 20) * grid, y = (py - p / 20) * grid;
                assert_true(floor(x) == k % grid && floor(y) == k / grid);
                mean += (x - k % grid - 0.5) + (y - k / grid - 0.5);
            }
    close_to(mean / (2 * 400 * 54), 0, 0.01);
}

/* The area of a disc of 3.7 pixels, over all pixels' coverage. */
static void samples_converge_to_area(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = flat_camera(12, 12, 1);
    struct stp_render_params params = exact_params();
    add_splat(f, v3(0.3, -0.2, -5), v3(0, 0, 1), 3.7);
    for (unsigned samples = 16; samples <= 1024; samples *= 8) {
        params.samples = samples;
        struct stp_image *image = render(f, &camera, &params);
        double area = 0;
        for (uint32_t i = 0; i < 144; i++) {
            area += value(image, "coverage", i % 12, i / 12);
            assert_true(value(image, "A", i % 12, i / 12) ==
                        value(image, "coverage", i % 12, i / 12));
        }
        close_to(area, M_PI * 3.7 * 3.7, samples < 1024 ? 0.5 : 0.05);
        stp_image_destroy(&image);
    }
    free(f);
}

/* Colour is the mean; Z, id, N and albedo are the nearest hit sample's. */
static void samples_resolve(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = flat_camera(2, 1, 1);
    struct stp_render_params params = exact_params();
    params.samples = 4;
    paint(f, add_splat(f, v3(-1e7 - 0.5, 0, -10), v3(0, 0, 1), 1e7), 1, 0, 0);
    paint(f, add_splat(f, v3(1e7 - 0.5, 0, -20), v3(0, 0, 1), 1e7), 0, 0, 1);
    struct stp_image *image = render(f, &camera, &params);
    close_to(value(image, "R", 0, 0), (0.8 + 0.2 + 0.2) / 2, 1e-6);
    close_to(value(image, "G", 0, 0), 0.2, 1e-6);
    close_to(value(image, "B", 0, 0), (0.8 + 0.2 + 0.2) / 2, 1e-6);
    assert_true(value(image, "A", 0, 0) == 1 && value(image, "Z", 0, 0) == 10);
    assert_true(value(image, "albedo.R", 0, 0) == 1 && value(image, "albedo.B", 0, 0) == 0);
    assert_true(value(image, "fragments", 0, 0) == 1);
    assert_int_equal(id_at(image, 0, 0), 1000);
    assert_int_equal(id_at(image, 1, 0), 1001);
    stp_image_destroy(&image);
    free(f);
}

static void planes_follow_the_list(void **state)
{
    static const struct {
        unsigned aovs, planes;
        const char *first;
    } wanted[] = { { 0, 8, "N.Z" },
                   { STP_AOV_ALBEDO, 11, "albedo.G" },
                   { STP_AOV_POSITION, 11, "P.Z" },
                   { STP_AOV_WEIGHT, 9, "weight" },
                   { STP_AOV_FRAGMENTS, 9, "fragments" },
                   { STP_AOV_COVERAGE, 9, "coverage" },
                   { STP_AOV_ID, 9, "id" },
                   { STP_AOV_LAYERS, 9, "layers" },
                   { 127, 19, "id" } };
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = flat_camera(2, 3, 1);
    struct stp_render_params params = exact_params();
    f->scene.facts.two_sided = true;
    f->scene.splats.origin[1] = 5;
    add_splat(f, v3(0, 0, -10), v3(0, 0, 1), 5);
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++) {
        params.aovs = wanted[k].aovs;
        struct stp_image *image = render(f, &camera, &params);
        assert_int_equal(image->channel_count, wanted[k].planes);
        assert_non_null(stp_image_find(image, wanted[k].first));
        assert_string_equal(image->channels[3].name, "A");
        assert_true(image->has_camera && image->two_sided && image->origin[1] == 5);
        assert_memory_equal(&image->camera, &camera, sizeof camera);
        stp_image_destroy(&image);
    }
    free(f);
}

static struct stp_image *with_threads(struct fixture *f, unsigned threads, unsigned samples)
{
    struct stp_env env = { .threads = threads };
    struct stp_camera camera = hard_view(0, 150, 100);
    struct stp_render_params params = exact_params();
    struct stp_image *image;
    params.samples = samples;
    params.min_splat = 2;
    assert_int_equal(reference_render(&env, &f->scene, &camera, &params, &image), STP_OK);
    return image;
}

static void same_bits_for_any_threads(void **state)
{
    struct fixture *f = fixture_create(0.1);
    fill_randomly(f, 31, 1500);
    for (unsigned samples = 1; samples <= 4; samples += 3) {
        struct stp_image *one = with_threads(f, 1, samples);
        for (unsigned threads = 2; threads <= 7; threads += 5) {
            struct stp_image *many = with_threads(f, threads, samples);
            for (unsigned c = 0; c < one->channel_count; c++)
                assert_memory_equal(one->channels[c].data.u, many->channels[c].data.u,
                                    150 * 100 * sizeof(float));
            stp_image_destroy(&many);
        }
        stp_image_destroy(&one);
    }
    free(f);
}

/* The same scene about (6e6, -4e6, 5e6) is the same picture. */
static void coordinates_far_from_zero(void **state)
{
    const double far[3] = { 6e6, -4e6, 5e6 };
    struct fixture *f = fixture_create(0.1);
    fill_randomly(f, 8, 600);
    struct stp_camera camera = hard_view(0, 64, 64);
    struct stp_render_params params = exact_params();
    struct stp_image *here = render(f, &camera, &params);
    for (size_t i = 0; i < f->scene.splats.count; i++)
        for (int k = 0; k < 3; k++)
            f->position[i][k] += far[k];
    memcpy(f->scene.splats.origin, far, sizeof far);
    for (int i = 0; i < 3; i++) {
        double *m = &camera.world_to_camera[4 * i];
        m[3] -= m[0] * far[0] + m[1] * far[1] + m[2] * far[2];
    }
    struct stp_image *there = render(f, &camera, &params);
    size_t differ = 0;
    for (uint32_t i = 0; i < 64 * 64; i++) {
        double a = value(here, "Z", i % 64, i / 64), b = value(there, "Z", i % 64, i / 64);
        differ += !(a == b || fabs(a - b) < 1e-6) ||
                  fabs(value(here, "R", i % 64, i / 64) - value(there, "R", i % 64, i / 64)) > 1e-5;
        differ +=
            fabs(value(here, "P.X", i % 64, i / 64) - value(there, "P.X", i % 64, i / 64)) > 1e-5;
    }
    assert_int_equal(differ, 0);
    stp_image_destroy(&here);
    stp_image_destroy(&there);
    free(f);
}

/* Position goes back to its own pixel's centre. */
static void position_reprojects(void **state)
{
    struct fixture *f = fixture_create(0.1);
    fill_randomly(f, 21, 500);
    for (int view = 0; view < VIEWS; view++) {
        struct stp_camera c = hard_view(view, 60, 40);
        struct stp_render_params params = exact_params();
        struct stp_image *image = render(f, &c, &params);
        for (uint32_t i = 0; i < 60 * 40; i++) {
            uint32_t x = i % 60, y = i / 60;
            if (value(image, "A", x, y) == 0)
                continue;
            struct vec3 p =
                m4_point(c.world_to_camera, v3(value(image, "P.X", x, y), value(image, "P.Y", x, y),
                                               value(image, "P.Z", x, y)));
            double w = c.orthographic ? 1 : -p.z, blur = 1e-6 * (1 + c.fx * v3_length(p) / w);
            close_to(-p.z, value(image, "Z", x, y), 1e-6 * (1 + v3_length(p)));
            close_to(c.cx + c.fx * p.x / w, x + 0.5, blur);
            close_to(c.cy - c.fy * p.y / w, y + 0.5, blur);
        }
        stp_image_destroy(&image);
    }
    free(f);
}

/* 10^4 splats in one pixel: the sums hold. */
static void many_in_one_pixel(void **state)
{
    struct fixture *f = fixture_create(1);
    struct stp_camera camera = flat_camera(1, 1, 1);
    struct stp_render_params params = exact_params();
    for (int i = 0; i < MOST; i++)
        paint(f, add_splat(f, v3(0, 0, -10 - i * 0.0001), v3(0, 0, 1), 2), i & 1, 0.5f, 0.25f);
    struct stp_image *image = render(f, &camera, &params);
    assert_true(value(image, "fragments", 0, 0) == MOST);
    close_to(value(image, "albedo.R", 0, 0), 0.5, 1e-7);
    close_to(value(image, "Z", 0, 0), 10 + (MOST - 1) / 2.0 * 0.0001, 1e-6);
    stp_image_destroy(&image);
    free(f);
}

struct last_line {
    unsigned count;
    char text[256];
};

static void keep_line(void *user, enum stp_log_level level, const char *line)
{
    struct last_line *last = user;
    last->count++;
    snprintf(last->text, sizeof last->text, "%s", line);
}

static void refused(struct fixture *f, const struct stp_camera *camera,
                    const struct stp_render_params *params, enum stp_result expected,
                    const char *text)
{
    struct last_line last = { 0 };
    struct stp_env env = { .log = keep_line, .user = &last };
    struct stp_image *image = NULL;
    assert_int_equal(reference_render(&env, &f->scene, camera, params, &image), expected);
    assert_null(image);
    assert_int_equal(last.count, 1);
    assert_non_null(strstr(last.text, text));
}

static void what_is_refused(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera good = plain_camera(4, 4, 4), bad[8];
    struct stp_render_params params = exact_params();
    refused(f, &good, &params, STP_ERROR_NO_POINTS, "no splats");
    add_splat(f, v3(0, 0, -5), v3(0, 0, 1), 1);
    for (int i = 0; i < 8; i++)
        bad[i] = good;
    bad[0].width = 0;
    bad[1].fx = 0;
    bad[2].fy = NAN;
    bad[3].near_depth = 0;
    bad[4].far_depth = good.near_depth;
    bad[5].world_to_camera[7] = INFINITY;
    bad[6].cx = NAN;
    bad[7].near_depth = NAN;
    for (int i = 0; i < 8; i++)
        refused(f, &bad[i], &params, STP_ERROR_ARGUMENT, "camera: ");
    params.epsilon = NAN;
    refused(f, &good, &params, STP_ERROR_ARGUMENT, "epsilon");
    params = exact_params();
    params.samples = 65537;
    refused(f, &good, &params, STP_ERROR_ARGUMENT, "samples");
    params = exact_params();
    f->scene.prepared = false;
    refused(f, &good, &params, STP_ERROR_ARGUMENT, "prepared");
    free(f);
}

static void every_allocation_may_fail(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(40, 40, 40);
    struct stp_render_params params = exact_params();
    add_splat(f, v3(0, 0, -5), v3(0, 0, 1), 1);
    enum stp_result result = STP_ERROR_MEMORY;
    unsigned long n = 1;
    for (; result != STP_OK; n++) {
        struct last_line last = { 0 };
        struct stp_env env = { .threads = 2, .log = keep_line, .user = &last };
        struct stp_image *image = NULL;
        mem_fail_at(n);
        result = reference_render(&env, &f->scene, &camera, &params, &image);
        mem_fail_at(0);
        if (result != STP_OK) {
            assert_int_equal(result, STP_ERROR_MEMORY);
            assert_null(image);
            assert_int_equal(last.count, 1);
        }
        stp_image_destroy(&image);
    }
    assert_true(n > 40); /* two a plane, and the tiles' */
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sample_positions),          cmocka_unit_test(samples_stay_in_their_cells),
        cmocka_unit_test(samples_converge_to_area),  cmocka_unit_test(samples_resolve),
        cmocka_unit_test(planes_follow_the_list),    cmocka_unit_test(same_bits_for_any_threads),
        cmocka_unit_test(coordinates_far_from_zero), cmocka_unit_test(position_reprojects),
        cmocka_unit_test(many_in_one_pixel),         cmocka_unit_test(what_is_refused),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
