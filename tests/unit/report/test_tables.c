/* report.csv, report.md and how figures and configurations are printed. */
#include "sweeps.h"

#define FIELDS 49

/* Splits in place; returns how many fields a line has. */
static unsigned split(char *line, char *field[64])
{
    unsigned count = 1;
    field[0] = line;
    for (char *at = line; *at; at++) {
        if (*at != ',')
            continue;
        *at = '\0';
        field[count++] = at + 1;
    }
    return count;
}

static const char *value_of(char *const *head, char *const *field, unsigned count, const char *name)
{
    for (unsigned i = 0; i < count; i++)
        if (strcmp(head[i], name) == 0)
            return field[i];
    fail_msg("no column %s", name);
    return NULL;
}

static void csv(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    rows[1].error.covered.p999 = 0.1; /* must read back bit for bit */
    rows[1].error.coverage_differs = 17;
    rows[1].transient_bytes = (uint64_t)5 << 32;
    report_find_front(&report);
    char *text = written(report_csv, &report), *line[MADE_ROWS + 2], *head[64], *field[64];
    unsigned lines = 0;
    for (char *at = strtok(text, "\n"); at; at = strtok(NULL, "\n"))
        line[lines++] = at;
    assert_int_equal(lines, MADE_ROWS + 1);
    assert_int_equal(split(line[0], head), FIELDS);
    for (unsigned i = 0; i < MADE_ROWS; i++) {
        assert_int_equal(split(line[i + 1], field), FIELDS);
        assert_string_equal(value_of(head, field, FIELDS, "method"), rows[i].method);
        assert_true(strtod(value_of(head, field, FIELDS, "ms_median"), NULL) == rows[i].ms.median);
        assert_true(strtod(value_of(head, field, FIELDS, "mean_absolute"), NULL) ==
                    rows[i].error.covered.mean_absolute);
        assert_string_equal(value_of(head, field, FIELDS, "front"), rows[i].on_front ? "1" : "0");
        assert_string_equal(value_of(head, field, FIELDS, "psnr"), "inf");
        assert_string_equal(value_of(head, field, FIELDS, "epsilon"), i == 4 ? "1" : "0.5");
        bool grouped = rows[i].overlap_asked > 0;
        assert_string_equal(value_of(head, field, FIELDS, "groups"), grouped ? "7" : "");
        assert_string_equal(value_of(head, field, FIELDS, "transparency"), "");
        assert_string_equal(value_of(head, field, FIELDS, "axis_h"), "");
        if (i != 1)
            continue;
        assert_true(strtod(value_of(head, field, FIELDS, "p999"), NULL) == 0.1);
        assert_string_equal(value_of(head, field, FIELDS, "coverage_differs"), "17");
        assert_string_equal(value_of(head, field, FIELDS, "transient_bytes"), "21474836480");
        assert_string_equal(value_of(head, field, FIELDS, "overlap"), "0.4");
    }
    free(text);
}

/* Every line of a table has as many cells as its head. */
static void check_tables(const char *text)
{
    unsigned bars = 0;
    for (const char *at = text; *at;) {
        size_t length = strcspn(at, "\n");
        unsigned count = 0;
        for (size_t i = 0; i < length; i++)
            count += at[i] == '|';
        if (count && bars)
            assert_int_equal(count, bars);
        bars = count;
        at += length + (at[length] == '\n');
    }
}

static void markdown(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    struct report_skip skip = { "deferred compute, id", "the device lacks it" };
    report.skip = &skip;
    report.skip_count = 1;
    strcpy(rows[3].pass[0].name, "visibility");
    rows[3].pass[0].milliseconds = 31;
    rows[3].pass_count = 1;
    rows[2].ms.frames = 3;
    report_find_front(&report);
    char *text = written(report_markdown, &report);
    check_tables(text);
    static const char *const expected[] = {
        "    stipple report scan.ply\n",
        "![milliseconds against error](report.svg)",
        "medians of 15 frames in 5 rounds",
        "by more than 3 times in the first round has the 3 frames of that one",
        "| deferred raster, c 0.4, Voronoi slab **front** | 20.00 (19.00 to 21.00) | 0.0070 | inf "
        "|",
        /* equal error 1e-3: exact wins over deferred at c = 1 and two-pass */
        "| 0.0010 | **40.00 ms**, compute, packed | 60.00 ms, raster, c 1, Voronoi slab | 50.00 "
        "ms, "
        "raster |",
        "| 1.00e-06 | - | - | **50.00 ms**, raster |",
        "| exact compute, packed, 40.00 ms | **1.00e-05**, compute, packed | 0.0070, raster, c "
        "0.4, "
        "Voronoi slab | - |",
        "The baseline is two-pass raster: 50.00 ms. Of the other 3 "
        "configurations 1 are slower",
        "| deferred raster, c 1, Voronoi slab | 1.20 | 2.00e-05 (2.00e-08) |",
        "| 0.4 | 0.4000 | 7 | 0 | 2.50 | 0 |",
        "| two-pass raster | 0 + 0 | visibility 31.00 |",
        "](error_2.png)",
        "- deferred compute, id: the device lacks it\n",
    };
    for (unsigned i = 0; i < sizeof expected / sizeof *expected; i++)
        if (!strstr(text, expected[i]))
            fail_msg("no '%s' in\n%s", expected[i], text);
    assert_int_equal(occurrences(text, "error_"), 1);
    free(text);
}

static void without_two_pass(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    report.row_count = 2;
    report.command = NULL;
    report_find_front(&report);
    char *text = written(report_markdown, &report);
    assert_null(strstr(text, "baseline"));
    assert_null(strstr(text, "Made by"));
    assert_null(strstr(text, "Left out"));
    free(text);
}

/* Layers and lists: a row's kind stands for its method, and their figures are columns. */
static void layers_and_lists(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    rows[0] = made_row("two-pass", "raster", 9, 0.2);
    rows[1] = made_row("exact", "compute", 3, 1e-4);
    rows[2] = made_row("axis", "compute", 5, 1e-3);
    rows[3] = made_row("axis", "compute", 4, 1e-2);
    rows[0].transparency = "peel", rows[0].peel_layers = 8, rows[0].is_baseline = true;
    rows[1].transparency = "exact";
    rows[2].merge = "blend", rows[2].axis_h = 0.85;
    rows[3].merge = "clip", rows[3].axis_h = 0.85;
    report.row_count = 4;
    report.is_volume = true;
    report_find_front(&report);
    char *text = written(report_csv, &report), name[REPORT_NAME_SIZE];
    assert_non_null(strstr(text, "\ntwo-pass,raster,,,peel,8,,,"));
    assert_non_null(strstr(text, "\nexact,compute,,,exact,,,,"));
    assert_non_null(strstr(text, "\naxis,compute,,,,,blend,0.85,"));
    assert_non_null(strstr(text, "\naxis,compute,,,,,clip,,"));
    free(text);
    assert_string_equal(report_row_name(&rows[0], name), "peel raster, 8 layers");
    assert_string_equal(report_row_name(&rows[2], name), "blend compute, h 0.85");
    assert_string_equal(report_row_name(&rows[3], name), "clip compute");
    text = written(report_markdown, &report);
    check_tables(text);
    assert_non_null(strstr(text, "| mean error at most | peel | exact | blend | clip |"));
    assert_non_null(strstr(text, "The baseline is peel raster, 8 layers: 9.00 ms."));
    assert_non_null(strstr(text, "1234 kernels, 640 x 480 pixels. Milli"));
    free(text);
}

static void samples(void **state)
{
    struct report_row rows[MADE_ROWS];
    struct report report = made_report(rows);
    char *text = written(report_samples_markdown, &report);
    assert_string_equal(text, "");
    free(text);
    report.samples_count = 2;
    report.samples_truth = 64;
    report.samples_width = 128, report.samples_height = 96;
    report.samples[0] = (struct report_samples){ .count = 1, .ms.median = 5 };
    report.samples[1] = (struct report_samples){ .count = 16, .ms.median = 80 };
    report.samples[1].error.covered.mean_absolute = 0.125;
    text = written(report_samples_markdown, &report);
    check_tables(text);
    assert_non_null(strstr(text, "128 x 96 pixels"));
    assert_non_null(strstr(text, "picture of 64 samples"));
    assert_non_null(strstr(text, "| 16 | 80.00 | 0.1250 |"));
    free(text);
    text = written(report_samples_csv, &report);
    assert_non_null(strstr(text, "\n16,80,0,0,0.125,"));
    assert_int_equal(occurrences(text, "\n"), 3);
    free(text);
}

/* One is one, in the table's heading and in the plot's. */
static void counts(void **state)
{
    static const char *const words[2][2] = { { "; 1 splat, ", "; 2 splats, " },
                                             { "; 1 kernel, ", "; 2 kernels, " } };
    for (unsigned i = 0; i < 4; i++) {
        struct report_row rows[MADE_ROWS];
        struct report report = made_report(rows);
        report.splats = 1 + i % 2;
        report.is_volume = i / 2;
        report_find_front(&report);
        char *table = written(report_markdown, &report), *plot = written(report_svg, &report);
        assert_non_null(strstr(table, words[i / 2][i % 2]));
        assert_non_null(strstr(plot, words[i / 2][i % 2] + 2));
        free(table);
        free(plot);
    }
}

static void numbers(void **state)
{
    static const struct {
        double value;
        const char *text;
    } known[] = {
        { 0, "0" },         { 1, "1.00" },       { 12.345, "12.35" },    { 123.45, "123.5" },
        { 12345, "12345" }, { 0.001, "0.0010" }, { 0.0001, "1.00e-04" }, { 2e5, "2.00e+05" },
        { INFINITY, "inf" }
    };
    char text[REPORT_NUMBER_SIZE];
    for (unsigned i = 0; i < sizeof known / sizeof *known; i++)
        assert_string_equal(report_number(known[i].value, text), known[i].text);
}

static void names(void **state)
{
    struct report_row row = made_deferred(0.85, 1, 1);
    char name[REPORT_NAME_SIZE];
    assert_string_equal(report_row_name(&row, name), "deferred raster, c 0.85, Voronoi slab");
    row.payload = "id";
    row.epsilon_scale = 0.5;
    assert_string_equal(report_row_name(&row, name),
                        "deferred raster, c 0.85, Voronoi slab, id, epsilon x 0.5");
    row = made_row("reference", "", 1, 0);
    assert_string_equal(report_row_name(&row, name), "reference");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csv),
        cmocka_unit_test(markdown),
        cmocka_unit_test(counts),
        cmocka_unit_test(without_two_pass),
        cmocka_unit_test(layers_and_lists),
        cmocka_unit_test(samples),
        cmocka_unit_test(numbers),
        cmocka_unit_test(names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
