/* Pictures of the error: the reduction, the scale, and failures. */
#include "pictures.h"

#include "base/memory.h"
#include "report/report.h"

static void equal_pictures(void **state)
{
    struct stp_image *a = grey_picture(20, 10, 0.5f);
    struct heat heat;
    set_empty(a, 3);
    assert_int_equal(heat_measure(NULL, a, a, &heat), STP_OK);
    assert_int_equal(heat.width, 20);
    assert_int_equal(heat.height, 10);
    for (unsigned i = 0; i < 200; i++)
        assert_true(heat.error[i] == (i == 3 ? -1.0f : 0.0f));
    heat_release(&heat);
    stp_image_destroy(&a);
}

/* Cells hold the mean of what is covered, of the worst channel. */
static void reduced(void **state)
{
    struct stp_image *a = grey_picture(2 * HEAT_WIDTH, 4, 0.5f);
    struct stp_image *b = grey_picture(2 * HEAT_WIDTH, 4, 0.5f);
    struct heat heat;
    size_t row = 2 * HEAT_WIDTH;
    set_color(a, 0, 0.5f, 0.75f, 0.25f + 0.125f); /* the worst is 0.25 */
    set_color(a, row + 2, 1, 0.5f, 0.5f);
    for (size_t y = 0; y < 2; y++) {
        set_empty(a, y * row + 3);
        set_empty(b, y * row + 3);
    }
    assert_int_equal(heat_measure(NULL, a, b, &heat), STP_OK);
    assert_int_equal(heat.width, HEAT_WIDTH);
    assert_int_equal(heat.height, 2);
    assert_true(heat.error[0] == 0.0625f); /* 0.25 in one of four */
    assert_true(heat.error[1] == 0.25f);   /* 0.5 in one of two that are covered */
    assert_true(heat.error[2] == 0);
    heat_release(&heat);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void scale(void **state)
{
    float low[3], below[3], high[3], above[3], middle[3];
    heat_color(HEAT_LOW, low);
    heat_color(0, below);
    heat_color(HEAT_HIGH, high);
    heat_color(7, above);
    heat_color(sqrt(HEAT_LOW * HEAT_HIGH), middle);
    assert_memory_equal(low, below, sizeof low);
    assert_memory_equal(high, above, sizeof high);
    float last = -1;
    for (int i = 0; i <= 60; i++) { /* lighter all the way */
        float c[3];
        heat_color(HEAT_LOW * pow(HEAT_HIGH / HEAT_LOW, i / 60.0), c);
        float luminance = 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
        assert_true(luminance > last);
        last = luminance;
    }
    assert_true(middle[1] > low[1] && middle[1] < high[1]);
}

static void picture(void **state)
{
    struct stp_image *a = grey_picture(30, 7, 0.5f), *b = grey_picture(30, 7, 0.5f), *out;
    struct heat heat;
    float high[3], paper;
    set_color(b, 31, 0, 0, 0);
    set_empty(a, 5);
    set_empty(b, 5);
    assert_int_equal(heat_measure(NULL, a, b, &heat), STP_OK);
    assert_int_equal(heat_picture(NULL, &heat, &out), STP_OK);
    assert_int_equal(out->width, 30);
    assert_true(out->height > 7);
    heat_color(0.5, high);
    paper = plane_of(out, "R")[5];
    assert_true(plane_of(out, "R")[31] == high[0]);
    assert_true(paper > 0.8f && plane_of(out, "R")[7 * 30] == paper);
    /* The bar at the foot runs from the low to the high end. */
    const float *green = plane_of(out, "G") + 30 * (out->height - 1);
    for (unsigned i = 1; i < 30; i++)
        assert_true(green[i] > green[i - 1]);
    heat_release(&heat);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    stp_image_destroy(&out);
}

static void failures(void **state)
{
    struct last_line line = { 0 };
    struct stp_env env = { .threads = 1, .log = keep_line, .user = &line };
    struct stp_image *a = grey_picture(8, 8, 0.5f), *b = grey_picture(8, 9, 0.5f), *out = NULL;
    struct heat heat = { 0 };
    assert_int_equal(heat_measure(&env, a, b, &heat), STP_ERROR_ARGUMENT);
    assert_int_equal(line.count, 1);
    mem_fail_at(1);
    assert_int_equal(heat_measure(&env, a, a, &heat), STP_ERROR_MEMORY);
    mem_fail_at(0);
    assert_null(heat.error);
    assert_int_equal(heat_measure(&env, a, a, &heat), STP_OK);
    for (unsigned long n = 1;; n++) {
        line.count = 0;
        mem_fail_at(n);
        enum stp_result result = heat_picture(&env, &heat, &out);
        mem_fail_at(0);
        if (result == STP_OK)
            break;
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_int_equal(line.count, 1);
        assert_null(out);
    }
    heat_release(&heat);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    stp_image_destroy(&out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_pictures), cmocka_unit_test(reduced),  cmocka_unit_test(scale),
        cmocka_unit_test(picture),        cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
