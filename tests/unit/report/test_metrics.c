/* Pictures with a known answer for every field of stp_comparison. */
#include "pictures.h"

#include <stdlib.h>

#include "base/memory.h"
#include "report/metrics.h"

static void near_to(double a, double b)
{
    assert_true(fabs(a - b) <= 1e-12 * (1 + fabs(b)));
}

static struct stp_comparison compare(struct stp_image *a, struct stp_image *b, double epsilon)
{
    struct stp_comparison c;
    struct stp_compare_params params = { .epsilon = epsilon };
    assert_int_equal(stp_compare(NULL, a, b, &params, &c), STP_OK);
    return c;
}

static void equal_pictures(void **state)
{
    struct stp_image *a = grey_picture(5, 4, 0.25f);
    set_empty(a, 3);
    struct stp_comparison c = compare(a, a, 0);
    const struct stp_color_error *both[2] = { &c.covered, &c.all };
    assert_int_equal(c.covered.pixels, 19);
    assert_int_equal(c.all.pixels, 20);
    for (int i = 0; i < 2; i++) {
        assert_true(both[i]->mean_absolute == 0 && both[i]->rmse == 0);
        assert_true(both[i]->psnr == INFINITY);
        assert_true(both[i]->p999 == 0 && both[i]->maximum == 0);
        assert_true(both[i]->over_1_255 == 0 && both[i]->over_8_255 == 0);
    }
    assert_int_equal(c.coverage_differs, 0);
    assert_true(c.depth_mean == 0 && c.depth_p999 == 0 && c.depth_max == 0);
    assert_true(c.normal_mean == 0 && c.normal_p99 == 0 && c.normal_max == 0);
    assert_true(c.flip == 0 && c.alpha_max == 0);
    stp_image_destroy(&a);
}

/* Two of ten pixels are empty in both; one covered pixel is off by 0.5 in red, 0.25 in green. */
static void color_errors_by_hand(void **state)
{
    struct stp_image *a = grey_picture(10, 1, 0.25f), *b = grey_picture(10, 1, 0.25f);
    for (int i = 8; i < 10; i++) {
        set_empty(a, (size_t)i);
        set_empty(b, (size_t)i);
    }
    set_color(a, 2, 0.75f, 0.5f, 0.25f);
    struct stp_comparison c = compare(a, b, 0);
    assert_int_equal(c.covered.pixels, 8);
    near_to(c.covered.mean_absolute, 0.75 / 24);
    near_to(c.covered.rmse, sqrt(0.3125 / 24));
    near_to(c.covered.psnr, 10 * log10(24 / 0.3125));
    near_to(c.covered.maximum, 0.5);
    near_to(c.covered.p999, 0.5);
    near_to(c.covered.over_1_255, 1.0 / 8);
    near_to(c.covered.over_8_255, 1.0 / 8);
    assert_int_equal(c.all.pixels, 10);
    near_to(c.all.mean_absolute, 0.75 / 30);
    near_to(c.all.psnr, 10 * log10(30 / 0.3125));
    near_to(c.all.over_1_255, 0.1);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* Strictly more than 1/255 and 8/255 count: 4/1024 < 1/255 < 5/1024, 32/1024 < 8/255 < 33/1024. */
static void shares_have_sharp_limits(void **state)
{
    static const int steps[8] = { 0, 4, 5, 32, 33, -4, -5, -33 };
    struct stp_image *a = grey_picture(8, 1, 0.5f), *b = grey_picture(8, 1, 0.5f);
    for (size_t i = 0; i < 8; i++)
        set_color(a, i, 0.5f, 0.5f, 0.5f + (float)steps[i] / 1024);
    struct stp_comparison c = compare(a, b, 0);
    near_to(c.covered.over_1_255, 5.0 / 8);
    near_to(c.covered.over_8_255, 2.0 / 8);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* 2000 pixels off by i / 2048: nearest rank 1998 of 2000 is the 1998th smallest. */
static void percentile_is_exact(void **state)
{
    struct stp_image *a = grey_picture(2000, 1, 0), *b = grey_picture(2000, 1, 0);
    for (size_t i = 0; i < 2000; i++) {
        size_t shuffled = i * 1217 % 2000; /* 1217 and 2000 share no factor */
        set_color(a, shuffled, 0, (float)i / 2048, 0);
        plane_of(a, "Z")[shuffled] = 1 + (float)i / 2048;
    }
    struct stp_comparison c = compare(a, b, 0.5);
    near_to(c.all.p999, 1997.0 / 2048);
    near_to(c.all.maximum, 1999.0 / 2048);
    near_to(c.depth_p999, 2 * 1997.0 / 2048);
    near_to(c.depth_max, 2 * 1999.0 / 2048);
    near_to(c.depth_mean, 2 * 999.5 / 2048);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void selection_agrees_with_sorting(void **state)
{
    uint32_t seed = 12345;
    double value[500], sorted[500];
    for (size_t n = 0; n <= 500; n += 7) {
        for (size_t i = 0; i < n; i++)
            value[i] = sorted[i] = n % 2 ? uniform(&seed) : floor(8 * uniform(&seed)) * 1e-200;
        qsort(sorted, n, sizeof *sorted, ascending);
        struct samples samples = { value, n };
        for (unsigned permille = 1; permille <= 1000; permille += 37) {
            size_t rank = (size_t)ceil((double)(n * permille) / 1000 - 1e-9);
            double expected = n ? sorted[rank - 1] : 0;
            assert_true(samples_permille(&samples, permille) == expected);
        }
    }
}

static void depth_counts_where_both_are_finite(void **state)
{
    struct stp_image *a = grey_picture(4, 1, 0.5f), *b = grey_picture(4, 1, 0.5f);
    set_empty(a, 0);
    set_empty(a, 1);
    set_empty(b, 1);
    plane_of(a, "Z")[2] = 1.75f;
    struct stp_comparison c = compare(a, b, 0.25);
    assert_int_equal(c.coverage_differs, 1);
    near_to(c.depth_mean, 1.5); /* 0.75 / 0.25 over the two pixels with a depth in both */
    near_to(c.depth_max, 3);
    near_to(c.depth_p999, 3);
    near_to(compare(a, b, 0).depth_max, 0.75); /* epsilon 0: absolute */
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* With a background alpha is 1 everywhere: the depths still tell. Counted once a pixel. */
static void coverage_by_alpha_or_depth(void **state)
{
    struct stp_image *a = grey_picture(5, 1, 0.5f), *b = grey_picture(5, 1, 0.5f);
    plane_of(a, "Z")[0] = INFINITY;
    plane_of(a, "A")[1] = 0;
    plane_of(b, "A")[2] = 0;
    plane_of(b, "Z")[2] = INFINITY;
    plane_of(a, "A")[3] = 0.25f;
    plane_of(b, "A")[4] = 1e-30f;
    struct stp_comparison c = compare(a, b, 0);
    assert_int_equal(c.coverage_differs, 3);
    near_to(c.alpha_max, 1);
    assert_int_equal(c.covered.pixels, 5);
    plane_of(a, "A")[1] = plane_of(b, "A")[2] = plane_of(b, "A")[4] = 1;
    near_to(compare(a, b, 0).alpha_max, 0.75);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void normal_angles(void **state)
{
    struct stp_image *a = grey_picture(4, 1, 0.5f), *b = grey_picture(4, 1, 0.5f);
    plane_of(a, "N.X")[0] = 1; /* 45 degrees; length does not matter */
    plane_of(a, "N.Y")[1] = 1e-6f;
    plane_of(a, "N.Z")[2] = -1;
    plane_of(a, "N.Z")[3] = 0; /* no normal: not counted */
    struct stp_comparison c = compare(a, b, 0);
    double tiny = atan((double)1e-6f) * 180 / M_PI;
    near_to(c.normal_max, 180);
    near_to(c.normal_p99, 180);
    near_to(c.normal_mean, (45 + tiny + 180) / 3);
    plane_of(a, "N.Z")[2] = 1;
    plane_of(a, "N.X")[0] = 0;
    assert_true(fabs(compare(a, b, 0).normal_max - tiny) < 1e-12 * tiny); /* digits kept */
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* 200 angles: the 198th is the 99th percentile. */
static void normal_percentile(void **state)
{
    struct stp_image *a = grey_picture(200, 1, 0.5f), *b = grey_picture(200, 1, 0.5f);
    for (size_t i = 0; i < 200; i++)
        plane_of(a, "N.X")[i] = (float)i / 256;
    struct stp_comparison c = compare(a, b, 0);
    near_to(c.normal_p99, atan(197.0 / 256) * 180 / M_PI);
    near_to(c.normal_max, atan(199.0 / 256) * 180 / M_PI);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void planes_that_one_lacks_are_left_out(void **state)
{
    struct stp_image *a = grey_picture(2, 1, 0.5f), *b;
    assert_int_equal(stp_image_create(NULL, 2, 1, &b), STP_OK);
    for (int i = 0; i < 3; i++)
        add_plane(b, i == 0 ? "R" : i == 1 ? "G" : "B");
    add_plane(b, "N.X")[0] = 1;
    struct stp_comparison c = compare(a, b, 0);
    assert_int_equal(c.covered.pixels, 2);
    near_to(c.covered.maximum, 0.5);
    assert_int_equal(c.coverage_differs, 0);
    assert_true(c.depth_max == 0 && c.normal_max == 0 && c.alpha_max == 0);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void expect_failure(struct stp_image *a, struct stp_image *b,
                           const struct stp_compare_params *params, enum stp_result expected,
                           const char *text, const char *more)
{
    struct last_line last = { 0 };
    struct stp_env env = { .log = keep_line, .user = &last };
    struct stp_comparison c, before;
    memset(&c, 0x5a, sizeof c);
    before = c;
    assert_int_equal(stp_compare(&env, a, b, params, &c), expected);
    assert_int_equal(last.count, 1);
    assert_non_null(strstr(last.text, text));
    assert_non_null(strstr(last.text, more));
    assert_memory_equal(&c, &before, sizeof c);
}

static void what_is_not_finite_is_named(void **state)
{
    static const char *const channel[4] = { "G", "A", "N.Y", "Z" };
    struct stp_image *a = grey_picture(7, 3, 0.5f), *b = grey_picture(7, 3, 0.5f);
    for (int i = 0; i < 4; i++) {
        float *value = &plane_of(a, channel[i])[7 + 4], kept = *value;
        *value = NAN;
        expect_failure(a, b, NULL, STP_ERROR_FORMAT, channel[i], "(4, 1)");
        *value = i < 3 ? INFINITY : -INFINITY; /* +Inf is the depth of nothing */
        expect_failure(a, b, NULL, STP_ERROR_FORMAT, channel[i], "(4, 1)");
        *value = kept;
    }
    plane_of(b, "G")[20] = INFINITY;
    expect_failure(a, b, NULL, STP_ERROR_FORMAT, "reference: channel G", "(6, 2)");
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* In a plane that no metric reads, or that the other picture has not. */
static void what_is_not_compared_may_be_anything(void **state)
{
    struct stp_image *a = grey_picture(7, 3, 0.5f), *b = grey_picture(7, 3, 0.5f), *flat;
    struct stp_comparison c;
    add_plane(a, "weight")[20] = NAN;
    add_plane(b, "weight")[1] = NAN;
    assert_int_equal(stp_compare(NULL, a, b, NULL, &c), STP_OK);
    assert_int_equal(stp_image_create(NULL, 7, 3, &flat), STP_OK);
    for (int k = 0; k < 3; k++)
        add_plane(flat, (const char *const[]){ "R", "G", "B" }[k]);
    static const char *const absent[5] = { "A", "Z", "N.X", "N.Y", "N.Z" };
    for (int k = 0; k < 5; k++)
        plane_of(b, absent[k])[3] = NAN;
    assert_int_equal(stp_compare(NULL, flat, b, NULL, &c), STP_OK);
    assert_int_equal(stp_compare(NULL, b, flat, NULL, &c), STP_OK);
    add_plane(flat, "N.X"); /* a part of a normal is none */
    assert_int_equal(stp_compare(NULL, flat, b, NULL, &c), STP_OK);
    stp_image_destroy(&flat);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void what_cannot_be_compared_is_said(void **state)
{
    struct stp_image *a = grey_picture(7, 3, 0.5f), *b = grey_picture(3, 7, 0.5f), *c;
    struct stp_compare_params bad[4] = {
        { .epsilon = -1 }, { .epsilon = NAN }, { .exposure = INFINITY }, { .pixels_per_degree = -3 }
    };
    expect_failure(a, b, NULL, STP_ERROR_ARGUMENT, "7x3", "3x7");
    for (int i = 0; i < 4; i++)
        expect_failure(a, a, &bad[i], STP_ERROR_ARGUMENT, "epsilon", "out of range");
    assert_int_equal(stp_image_create(NULL, 7, 3, &c), STP_OK);
    add_plane(c, "R");
    expect_failure(a, c, NULL, STP_ERROR_FORMAT, "reference", "G");
    expect_failure(c, a, NULL, STP_ERROR_FORMAT, "picture", "G");
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    stp_image_destroy(&c);
}

static void every_allocation_may_fail(void **state)
{
    struct stp_image *a = grey_picture(9, 9, 0.5f);
    enum stp_result result = STP_ERROR_MEMORY;
    unsigned long n = 1;
    for (; result != STP_OK; n++) {
        struct stp_comparison c = { .flip = 42 };
        struct last_line last = { 0 };
        struct stp_env env = { .log = keep_line, .user = &last };
        mem_fail_at(n);
        result = stp_compare(&env, a, a, NULL, &c);
        mem_fail_at(0);
        assert_true(result == STP_OK || result == STP_ERROR_MEMORY);
        assert_true(result == STP_OK || (last.count == 1 && c.flip == 42));
    }
    assert_true(n > 3);
    stp_image_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_pictures),
        cmocka_unit_test(color_errors_by_hand),
        cmocka_unit_test(shares_have_sharp_limits),
        cmocka_unit_test(percentile_is_exact),
        cmocka_unit_test(selection_agrees_with_sorting),
        cmocka_unit_test(depth_counts_where_both_are_finite),
        cmocka_unit_test(coverage_by_alpha_or_depth),
        cmocka_unit_test(normal_angles),
        cmocka_unit_test(normal_percentile),
        cmocka_unit_test(planes_that_one_lacks_are_left_out),
        cmocka_unit_test(what_is_not_finite_is_named),
        cmocka_unit_test(what_is_not_compared_may_be_anything),
        cmocka_unit_test(what_cannot_be_compared_is_said),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
