/* The front, equal error, equal time and quantiles, against brute force and answers by hand. */
#include "sweeps.h"

static void front_by_hand(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    const struct report_row *front[MADE_ROWS];
    report_find_front(&report);
    assert_int_equal(report_front(&report, front), 3);
    const unsigned expected[] = { 1, 0, 3 };
    for (unsigned i = 0; i < 3; i++)
        assert_ptr_equal(front[i], &rows[expected[i]]);
    assert_false(rows[2].on_front);
    assert_false(rows[4].on_front); /* another epsilon: another picture */
    assert_false(rows[5].on_front); /* the reference contends with nobody */
}

/* Errors below the floor are equal: the faster wins, and of twins the first. */
static void below_the_floor(void **state)
{
    struct report_row rows[4] = { made_row("a", "compute", 10, 3e-8),
                                  made_row("b", "compute", 20, 0),
                                  made_row("c", "compute", 10, 1e-9),
                                  made_row("d", "compute", 10, 1e-7) };
    struct report report = { .row = rows, .row_count = 4 };
    report_find_front(&report);
    assert_true(rows[0].on_front);
    assert_false(rows[1].on_front);
    assert_false(rows[2].on_front);
    assert_false(rows[3].on_front);
}

static bool beaten(const struct report_row *rows, unsigned count, unsigned i)
{
    for (unsigned k = 0; k < count; k++) {
        double dt = rows[k].ms.median - rows[i].ms.median;
        double de = report_error(&rows[k]) - report_error(&rows[i]);
        if (dt <= 0 && de <= 0 && (dt < 0 || de < 0))
            return true;
    }
    return false;
}

static void front_of_random_rows(void **state)
{
    uint32_t seed = 7;
    for (int round = 0; round < 200; round++) {
        struct report_row rows[40];
        const struct report_row *front[40];
        unsigned count = 1 + next_random(&seed) % 40;
        struct report report = { .row = rows, .row_count = count };
        for (unsigned i = 0; i < count; i++)
            rows[i] = made_row("m", "compute", 1 + next_random(&seed) % 20,
                               1e-5 * (1 + next_random(&seed) % 20));
        report_find_front(&report);
        for (unsigned i = 0; i < count; i++) {
            bool twin = false;
            for (unsigned k = 0; k < i; k++)
                twin |= rows[k].ms.median == rows[i].ms.median &&
                        report_error(&rows[k]) == report_error(&rows[i]);
            assert_int_equal(rows[i].on_front, !twin && !beaten(rows, count, i));
        }
        unsigned found = report_front(&report, front);
        assert_true(found >= 1);
        for (unsigned i = 1; i < found; i++) {
            assert_true(front[i]->ms.median > front[i - 1]->ms.median);
            assert_true(report_error(front[i]) < report_error(front[i - 1]));
        }
    }
}

/* Baselines, however slow, and what is exact or fast enough, stay; equals do not put each other
 * out. */
static void outclassed_by_hand(void **state)
{
    struct report_row rows[7] = {
        made_row("exact", "compute", 10, 1e-5), made_row("two-pass", "compute", 31, 1e-5),
        made_row("a", "raster", 30, 1e-5),      made_row("b", "raster", 31, 1e-5),
        made_row("c", "raster", 90, 9e-6),      made_row("d", "raster", 5, 1e-3),
        made_row("reference", "", 1, 0)
    };
    struct report report = { .row = rows, .row_count = 7 };
    rows[1].is_baseline = true;
    rows[6].is_reference = true;
    const bool expected[] = { false, false, false, true, false, false };
    for (unsigned i = 0; i < 6; i++)
        assert_int_equal(report_outclassed(&report, &rows[i]), expected[i]);
}

/* Frames that take less than two thirds from the median of what is left out change no front. */
static void outclassed_never_on_the_front(void **state)
{
    uint32_t seed = 11;
    unsigned left_out = 0;
    for (int round = 0; round < 200; round++) {
        struct report_row rows[20];
        struct report report = { .row = rows, .row_count = 20 };
        for (unsigned i = 0; i < 20; i++)
            rows[i] = made_row("m", "compute", 1 + next_random(&seed) % 100,
                               1e-5 * (1 + next_random(&seed) % 20));
        for (unsigned i = 0; i < 20; i++) {
            struct report_row kept = rows[i];
            if (!report_outclassed(&report, &rows[i]))
                continue;
            left_out++;
            rows[i].ms.median /= REPORT_OUTCLASSED - 0.1;
            report_find_front(&report);
            assert_false(rows[i].on_front);
            rows[i] = kept;
        }
    }
    assert_true(left_out > 200);
}

static void equal_error_and_time(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    assert_ptr_equal(report_fastest(&report, NULL, 1e-2), &rows[1]);
    assert_ptr_equal(report_fastest(&report, NULL, 1e-3), &rows[0]);
    assert_ptr_equal(report_fastest(&report, "deferred", 1e-3), &rows[2]);
    assert_ptr_equal(report_fastest(&report, NULL, 1e-7), &rows[3]);
    assert_null(report_fastest(&report, "exact", 1e-6));
    assert_null(report_fastest(&report, "pyramid", 1));
    assert_ptr_equal(report_most_exact(&report, NULL, 45), &rows[0]);
    assert_ptr_equal(report_most_exact(&report, "deferred", 45), &rows[1]);
    assert_ptr_equal(report_most_exact(&report, NULL, INFINITY), &rows[3]);
    assert_null(report_most_exact(&report, NULL, 5));
    /* A variant of epsilon is on no list, nor is the reference. */
    assert_ptr_equal(report_fastest(&report, "exact", 1), &rows[0]);
    assert_null(report_fastest(&report, "reference", 1));
}

static void kinds(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    const char *names[REPORT_MAX_KINDS];
    assert_int_equal(report_kinds(&report, names), 3);
    assert_string_equal(names[0], "exact");
    assert_string_equal(names[1], "deferred");
    assert_string_equal(names[2], "two-pass");
    assert_ptr_equal(report_baseline(&report), &rows[3]);
    report.row_count = 3;
    assert_null(report_baseline(&report));
}

static void quantiles(void **state)
{
    double one[] = { 3 }, four[] = { 4, 1, 3, 2 }, five[] = { 50, 10, 30, 20, 40 };
    struct report_times t = report_times(one, 1);
    assert_true(t.frames == 1 && t.min == 3 && t.quartile1 == 3 && t.median == 3 && t.max == 3);
    t = report_times(four, 4);
    assert_true(t.min == 1 && t.quartile1 == 1.75 && t.median == 2.5 && t.quartile3 == 3.25);
    t = report_times(five, 5);
    assert_true(t.quartile1 == 20 && t.median == 30 && t.quartile3 == 40 && t.max == 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(front_by_hand),
        cmocka_unit_test(below_the_floor),
        cmocka_unit_test(front_of_random_rows),
        cmocka_unit_test(outclassed_by_hand),
        cmocka_unit_test(outclassed_never_on_the_front),
        cmocka_unit_test(equal_error_and_time),
        cmocka_unit_test(kinds),
        cmocka_unit_test(quantiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
