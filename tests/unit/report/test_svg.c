/* report.svg: axes, labels, and what stands in the file. */
#include "sweeps.h"

#include "report/labels.h"
#include "report/plot.h"

static void axes(void **state)
{
    struct axis axis = { 10, 1000, 100, 300 };
    double ticks[AXIS_MAX_TICKS];
    assert_true(fabs(axis_at(&axis, 10) - 100) < 1e-9);
    assert_true(fabs(axis_at(&axis, 100) - 200) < 1e-9);
    assert_true(fabs(axis_at(&axis, 1000) - 300) < 1e-9);
    assert_int_equal(axis_decades(&axis, ticks), 3);
    assert_int_equal(axis_ticks(&axis, ticks), 7); /* 10 20 50 ... 1000 */
    assert_true(fabs(ticks[1] - 20) < 1e-9);
}

/* Whatever the range: ticks inside, ascending, not too many, and enough unless it is tiny. */
static void ticks_of_many_ranges(void **state)
{
    uint32_t seed = 3;
    for (int i = 0; i < 2000; i++) {
        double low = pow(10, 8 * uniform(&seed) - 4), ratio = pow(10, 0.2 + 9 * uniform(&seed));
        struct axis axis = { low, low * ratio, 0, 100 };
        double ticks[AXIS_MAX_TICKS];
        unsigned count = axis_ticks(&axis, ticks);
        assert_true(count >= (ratio > 3 ? 3 : 1));
        for (unsigned k = 0; k < count; k++) {
            assert_true(ticks[k] >= low * (1 - 1e-6) && ticks[k] <= low * ratio * (1 + 1e-6));
            assert_true(k == 0 || ticks[k] > ticks[k - 1]);
        }
    }
}

static void overlap_of_boxes(void **state)
{
    struct box a = { 0, 0, 4, 4 }, b = { 2, 1, 6, 3 }, c = { 4, 0, 5, 5 };
    assert_true(box_overlap(&a, &b) == 4);
    assert_true(box_overlap(&a, &c) == 0);
}

/* A dozen labels of one plot: inside, and none over another, however the points fall. */
static void labels_do_not_overlap(void **state)
{
    uint32_t seed = 11;
    for (int round = 0; round < 50; round++) {
        struct label labels[12];
        struct box markers[12];
        for (unsigned i = 0; i < 12; i++) {
            double x = 100 + 800 * uniform(&seed), y = 130 + 400 * uniform(&seed);
            labels[i] = (struct label){ .x = x, .y = y, .width = 150, .height = 15 };
            markers[i] = (struct box){ x - 6, y - 6, x + 6, y + 6 };
        }
        struct label_scene scene = { { 96, 122, 928, 532 }, markers, 12, NULL, 0 };
        labels_place(labels, 12, &scene);
        for (unsigned i = 0; i < 12; i++) {
            const struct box *b = &labels[i].box;
            assert_true(b->left >= 96 && b->right <= 928 && b->top >= 122 && b->bottom <= 532);
            for (unsigned k = 0; k < i; k++)
                assert_true(box_overlap(b, &labels[k].box) == 0);
        }
    }
}

/* Twelve points in one heap: still apart. */
static void crowded_labels(void **state)
{
    struct label labels[12];
    for (unsigned i = 0; i < 12; i++)
        labels[i] = (struct label){ .x = 500 + i, .y = 300, .width = 150, .height = 15 };
    struct label_scene scene = { { 96, 122, 928, 532 }, NULL, 0, NULL, 0 };
    labels_place(labels, 12, &scene);
    for (unsigned i = 0; i < 12; i++)
        for (unsigned k = 0; k < i; k++)
            assert_true(box_overlap(&labels[i].box, &labels[k].box) == 0);
}

static void page(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    report_find_front(&report);
    char *text = written(report_svg, &report);
    assert_int_equal(strncmp(text, "<svg xmlns=\"http://www.w3.org/2000/svg\"", 38), 0);
    assert_non_null(strstr(text, "a &lt;b&gt; &amp; &quot;c&quot;"));
    assert_non_null(strstr(text, "The reference takes 3000 ms on the CPU."));
    assert_int_equal(occurrences(text, "<title>"), 5); /* a tooltip for every contender */
    assert_int_equal(occurrences(text, "class=\"front\" d="), 2); /* the line, and the legend's */
    assert_int_equal(occurrences(text, "fill-opacity=\"0.28\""), 2); /* one beaten, one variant */
    assert_non_null(strstr(text, ">c 0.4 slab, 20.00 ms<"));
    assert_non_null(strstr(text, ">1/255<"));
    assert_int_equal(occurrences(text, "nan") + occurrences(text, "inf,"), 0);
    assert_string_equal(text + strlen(text) - 7, "</svg>\n");
    free(text);
}

static void odd_sweeps(void **state)
{
    struct report_row rows[2] = { made_row("exact", "compute", 0, 0),
                                  made_row("exact", "compute", 0, 0) };
    struct report report = { .title = "", .device = "", .row = rows, .row_count = 2 };
    for (unsigned count = 0; count <= 2; count++) {
        report.row_count = count;
        report_find_front(&report);
        char *text = written(report_svg, &report);
        assert_int_equal(occurrences(text, "nan"), 0);
        assert_string_equal(text + strlen(text) - 7, "</svg>\n");
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes),
        cmocka_unit_test(ticks_of_many_ranges),
        cmocka_unit_test(overlap_of_boxes),
        cmocka_unit_test(labels_do_not_overlap),
        cmocka_unit_test(crowded_labels),
        cmocka_unit_test(page),
        cmocka_unit_test(odd_sweeps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
