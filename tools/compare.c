/* stipple compare: the error of one EXR against another. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>

#include "cli.h"

/* Every metric of the pictures' colours, twice: over covered pixels and over all. */
struct color_row {
    const char *name, *key;
    double covered, all;
};
#define COLOR_ROWS 7
struct row {
    const char *name, *key;
    double value;
    bool there;
};
#define ROWS 9

static void color_rows(const struct stp_comparison *c, struct color_row rows[COLOR_ROWS])
{
    const struct stp_color_error *a = &c->covered, *b = &c->all;
    const struct color_row filled[COLOR_ROWS] = {
        { "PSNR, dB", "psnr", a->psnr, b->psnr },
        { "RMSE", "rmse", a->rmse, b->rmse },
        { "mean absolute error", "mean_absolute", a->mean_absolute, b->mean_absolute },
        { "99.9th percentile", "p999", a->p999, b->p999 },
        { "maximum", "maximum", a->maximum, b->maximum },
        { "share off by over 1/255", "over_1_255", a->over_1_255, b->over_1_255 },
        { "share off by over 8/255", "over_8_255", a->over_8_255, b->over_8_255 },
    };
    for (int i = 0; i < COLOR_ROWS; i++)
        rows[i] = filled[i];
}

static bool both_have(const struct stp_image *a, const struct stp_image *b, const char *channel)
{
    return stp_image_find(a, channel) && stp_image_find(b, channel);
}

static void other_rows(const struct stp_comparison *c, const struct stp_image *a,
                       const struct stp_image *b, bool epsilon, struct row rows[ROWS])
{
    bool depth = both_have(a, b, "Z"), normal = both_have(a, b, "N.X");
    bool alpha = both_have(a, b, "A");
    const struct row filled[ROWS] = {
        { "coverage differs, pixels", "coverage_differs", (double)c->coverage_differs, alpha },
        { "alpha, maximum", "alpha_max", c->alpha_max, alpha },
        { epsilon ? "depth / epsilon, mean" : "depth, mean", "depth_mean", c->depth_mean, depth },
        { epsilon ? "depth / epsilon, p99.9" : "depth, p99.9", "depth_p999", c->depth_p999, depth },
        { epsilon ? "depth / epsilon, max" : "depth, max", "depth_max", c->depth_max, depth },
        { "normal angle, mean, deg", "normal_mean", c->normal_mean, normal },
        { "normal angle, p99, deg", "normal_p99", c->normal_p99, normal },
        { "normal angle, max, deg", "normal_max", c->normal_max, normal },
        { "FLIP (LDR), mean", "flip", c->flip, true },
    };
    for (int i = 0; i < ROWS; i++)
        rows[i] = filled[i];
}

static void print_text(const struct stp_comparison *c, const struct color_row *colors,
                       const struct row *rows)
{
    printf("%-26s %14s %14s\n", "", "covered", "all");
    printf("%-26s %14llu %14llu\n", "pixels", (unsigned long long)c->covered.pixels,
           (unsigned long long)c->all.pixels);
    for (int i = 0; i < COLOR_ROWS; i++)
        printf("%-26s %14.8g %14.8g\n", colors[i].name, colors[i].covered, colors[i].all);
    putchar('\n');
    for (int i = 0; i < ROWS; i++) {
        if (rows[i].there)
            printf("%-26s %14.8g\n", rows[i].name, rows[i].value);
        else
            printf("%-26s %14s\n", rows[i].name, "not in both");
    }
}

/* Infinity has no JSON: null, as for what is not in both pictures. */
static int print_json(struct console *console, const struct stp_comparison *c,
                      const struct color_row *colors, const struct row *rows)
{
    struct json_out building = { 0 }, *out = &building;
    cJSON *json = json_begin(out, cJSON_CreateObject());
    cJSON *covered = json_object(out, json, "covered");
    cJSON *all = json_object(out, json, "all");
    json_number(out, covered, "pixels", (double)c->covered.pixels);
    json_number(out, all, "pixels", (double)c->all.pixels);
    for (int i = 0; i < COLOR_ROWS; i++) {
        json_number(out, covered, colors[i].key, colors[i].covered);
        json_number(out, all, colors[i].key, colors[i].all);
    }
    for (int i = 0; i < ROWS; i++)
        json_number(out, json, rows[i].key, rows[i].there ? rows[i].value : NAN);
    int status = json_print(console, out, json);
    cJSON_Delete(json);
    return status;
}

static int print_comparison(struct console *console, const struct settings *settings,
                            const struct stp_comparison *c, const struct stp_image *a,
                            const struct stp_image *b)
{
    struct color_row colors[COLOR_ROWS];
    struct row rows[ROWS];
    color_rows(c, colors);
    other_rows(c, a, b, settings->compare.epsilon > 0, rows);
    if (settings->json)
        return print_json(console, c, colors, rows);
    print_text(c, colors, rows);
    return EXIT_DONE;
}

static int judge(struct console *console, const struct settings *settings,
                 const struct stp_comparison *c)
{
    if (!option_given(settings, "fail-under-psnr") || c->covered.psnr >= settings->least_psnr)
        return EXIT_DONE;
    console_error(console, "PSNR %.2f dB is under %.2f dB", c->covered.psnr, settings->least_psnr);
    return EXIT_FAILED;
}

int run_compare(struct settings *settings)
{
    struct console console;
    struct stp_image *a = NULL, *b = NULL;
    struct stp_comparison comparison;
    console_open(&console, settings);
    const struct stp_env *env = &console.env;
    enum stp_result result = stp_image_read_exr(env, settings->files[0], &a);
    if (result == STP_OK)
        result = stp_image_read_exr(env, settings->files[1], &b);
    if (result == STP_OK)
        result = stp_compare(env, a, b, &settings->compare, &comparison);
    console_close(&console);
    /* Pictures of different sizes are bad input, not a wrong command line. */
    int status = result == STP_ERROR_ARGUMENT ? EXIT_BAD_INPUT : exit_of_input(result);
    if (status == EXIT_DONE) {
        status = print_comparison(&console, settings, &comparison, a, b);
        if (status == EXIT_DONE)
            status = judge(&console, settings, &comparison);
    }
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    return status;
}
