/* stipple info: what is in a file, what is wrong with it, what would be done. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

#define MAX_PROBLEMS 10

struct problems {
    unsigned count;
    char line[MAX_PROBLEMS][160];
};

/* What `stipple render` with no flags would do; the plan that the built-in profile gives. */
struct intent {
    char method[32], path[32], why[512];
    char command[512];
};

static const char *normals_text(const struct stp_facts *facts)
{
    switch (facts->normals) {
    case STP_NORMALS_GIVEN:
        return "given";
    case STP_NORMALS_ESTIMATED:
        return "estimated";
    default:
        return facts->eye_dome ? "none: shaded by depth" : "none";
    }
}

static void note(struct problems *problems, size_t count, const char *one, const char *many)
{
    if (count && problems->count < MAX_PROBLEMS)
        snprintf(problems->line[problems->count++], sizeof problems->line[0], "%zu %s", count,
                 count == 1 ? one : many);
}

static void find_problems(const struct stp_facts *facts, struct problems *problems)
{
    bool volume = facts->volume.dims[0] > 0;
    note(problems, facts->not_finite,
         volume ? "voxel is not finite: left out" : "point is not finite, or beyond 1e18: dropped",
         volume ? "voxels are not finite: left out"
                : "points are not finite, or beyond 1e18: dropped");
    note(problems, facts->duplicates, "splat is an exact copy of another: kept",
         "splats are exact copies of others: kept");
    note(problems, facts->bad_normals, "normal is zero or not finite: estimated instead",
         "normals are zero or not finite: estimated instead");
    note(problems, facts->bad_radii,
         "radius is zero, negative, not within 1e-18 and 1e18 or monstrous: set from the spacing",
         "radii are zero, negative, not within 1e-18 and 1e18 or monstrous: set from the spacing");
    note(problems, facts->bad_phong, "ellipse is not finite, flat or skew: drawn as a disc",
         "ellipses are not finite, flat or skew: drawn as discs");
    note(problems, facts->outliers, "point is far from everything: its radius is bounded",
         "points are far from everything: their radii are bounded");
    note(problems, facts->no_normal,
         "splat has no normal that could be estimated: it faces the eye",
         "splats have no normal that could be estimated: they face the eye");
    if (facts->normals == STP_NORMALS_GIVEN && facts->outwardness < -0.1 &&
        problems->count < MAX_PROBLEMS)
        snprintf(problems->line[problems->count++], sizeof problems->line[0],
                 "normals point inward: lit on both sides");
    if (facts_coarse(facts) && problems->count < MAX_PROBLEMS)
        snprintf(problems->line[problems->count++], sizeof problems->line[0],
                 "coordinates are float32 in steps of %.3g: too coarse for radii of %.3g",
                 facts->float_step, (double)facts->radius_median);
}

/* "NAME" of "a/b/NAME.ply.gz", for a suggested output in the current directory. */
static void stem_of(const char *path, char *stem, size_t size)
{
    const char *base = strrchr(path, '/');
    snprintf(stem, size, "%s", base ? base + 1 : path);
    char *dot = strrchr(stem, '.');
    if (dot && strcmp(dot, ".gz") == 0)
        *dot = 0;
    dot = strrchr(stem, '.');
    if (dot && dot != stem)
        *dot = 0;
}

static bool needs_quotes(const char *text)
{
    return strpbrk(text, " \t\"'\\$&|;<>()*?[]#~`!{}") != NULL;
}

static void suggest(const char *path, struct intent *intent)
{
    char stem[200];
    stem_of(path, stem, sizeof stem);
    const char *quote = needs_quotes(path) ? "\"" : "";
    snprintf(intent->command, sizeof intent->command,
             "stipple render %s%s%s -o %s%s.exr%s --preview %s%s.png%s", quote, path, quote, quote,
             stem, quote, quote, stem, quote);
}

static int find_intent(struct console *console, const struct settings *settings,
                       struct stp_scene *scene, const char *path, struct intent *intent)
{
    struct stp_limits limits;
    struct stp_camera camera;
    struct stp_plan *plan = NULL;
    struct stp_plan_summary summary;
    suggest(path, intent);
    stp_limits_lavapipe(&limits);
    struct stp_choice choice;
    if (find_camera(console, settings, scene, 0, &camera, NULL) != EXIT_DONE ||
        choose_way(console, settings, scene, &camera, &limits, &choice) != EXIT_DONE ||
        stp_plan_create(&console->env, scene, &camera, &choice.params, &limits, &plan) != STP_OK)
        return EXIT_FAILED;
    stp_plan_summarize(plan, &summary);
    snprintf(intent->method, sizeof intent->method, "%s", stp_method_name(summary.method));
    snprintf(intent->path, sizeof intent->path, "%s", stp_path_name(summary.path));
    snprintf(intent->why, sizeof intent->why, "%s", summary.why);
    stp_plan_destroy(&plan);
    return EXIT_DONE;
}

static void row(const char *name)
{
    printf("  %-9s ", name);
}

static void print_points(const struct stp_facts *facts)
{
    row("points");
    printf("%zu in %u object%s\n", facts->points, facts->objects, facts->objects == 1 ? "" : "s");
    row("splats");
    printf("%zu\n", facts->splats);
    if (facts->phong) {
        row("ellipses");
        printf("%zu with normal fields, %zu of them with clip lines\n", facts->phong,
               facts->clip_lines);
    }
    if (facts->clipped) {
        row("clipped");
        printf("%zu\n", facts->clipped);
    }
}

/* So many that they tell a millionth of the extent apart, however far it is from the origin. */
static int corner_digits(double low, double high)
{
    double most = fmax(fabs(low), fabs(high)), extent = high - low;
    double digits = extent > 0 ? ceil(log10(most / extent)) + 7 : 9;
    return digits < 9 ? 9 : digits > 17 ? 17 : (int)digits;
}

static void print_corners(const double b[6])
{
    for (int c = 0; c < 2; c++) {
        row(c ? "to" : "from");
        for (int i = 0; i < 3; i++)
            printf("%.*g%c", corner_digits(b[i], b[i + 3]), b[3 * c + i], i < 2 ? ' ' : '\n');
    }
}

static void print_shape(const struct stp_facts *facts)
{
    const double *b = facts->bounds;
    static const char *const up[] = { "?", "x", "y", "z", "-y" };
    print_corners(b);
    row("size");
    printf("%.6g x %.6g x %.6g, up is %s\n", b[3] - b[0], b[4] - b[1], b[5] - b[2], up[facts->up]);
}

/* Aerial scans are often z up in formats that do not say so. */
static bool lies_flat(const struct stp_facts *facts)
{
    if (facts->volume.dims[0] || facts->range.frames)
        return false;
    const double *b = facts->bounds;
    return facts->up == STP_UP_Y && b[5] - b[2] < 0.3 * fmin(b[3] - b[0], b[4] - b[1]);
}

static void print_surface(const struct stp_facts *facts)
{
    row("normals");
    printf("%s; %s (outwardness %.2f)\n", normals_text(facts),
           facts->two_sided ? "lit on both sides" : "lit from outside only", facts->outwardness);
    row("radii");
    printf("%.6g to %.6g, median %.6g\n", (double)facts->radius_min, (double)facts->radius_max,
           (double)facts->radius_median);
    row("colours");
    if (facts->has_color)
        printf("yes, the largest component is %.4g\n", (double)facts->color_max);
    else
        printf("none: the material's\n");
    row("opacity");
    if (facts->transparent)
        printf("transparent, from %.4g%s%s\n", (double)facts->opacity_min,
               facts->uniform_opacity ? ", one for each object" : ", it varies",
               facts->mixed ? ", among opaque splats" : "");
    else
        printf("opaque\n");
    row("lights");
    printf("%u%s\n", facts->lights, facts->positional_lights ? ", some with a position" : "");
    if (facts->grouping.groups) {
        row("groups");
        printf("%u at overlap %.3g\n", facts->grouping.groups, facts->grouping.overlap);
    }
}

static void print_volume(const struct stp_facts *facts)
{
    const struct stp_volume_facts *v = &facts->volume;
    const double size[3] = { v->dims[0] * v->spacing[0], v->dims[1] * v->spacing[1],
                             v->dims[2] * v->spacing[2] };
    static const char *const up[] = { "?", "x", "y", "z", "-y" };
    row("voxels");
    printf("%zu: %u x %u x %u\n", facts->points, v->dims[0], v->dims[1], v->dims[2]);
    row("spacing");
    printf("%.6g x %.6g x %.6g\n", v->spacing[0], v->spacing[1], v->spacing[2]);
    row("size");
    printf("%.6g x %.6g x %.6g, up is %s\n", size[0], size[1], size[2], up[facts->up]);
    row("values");
    printf("%.6g to %.6g\n", v->low, v->high);
    row("transfer");
    printf("%s: opacity up to %.3g per unit of the finest spacing\n", v->transfer_function,
           v->opacity_max);
    row("kernels");
    printf("%zu voxels have any opacity (%.1f %%)\n", facts->splats,
           100.0 * (double)facts->splats / (double)facts->points);
}

static void print_range(const struct stp_facts *facts)
{
    const struct stp_range_facts *r = &facts->range;
    row("frames");
    printf("%u, of %zu pixels; %zu have no reading\n", r->frames, facts->points, r->holes);
    print_shape(facts);
    row("ellipsoids");
    printf("%zu; the median deviation of a depth is %.4g\n", facts->splats, r->deviation_median);
    row("seen by");
    printf("%.3g frames each, on average\n", r->sources);
    row("colours");
    printf("%s\n", r->by_views ? "of all frames, by their angles" : "of their own frames");
}

static void print_text(const char *path, const struct stp_facts *facts,
                       const struct problems *problems, const struct intent *intent)
{
    printf("%s\n", path);
    row("format");
    printf("%s\n", facts->format);
    if (facts->volume.dims[0]) {
        print_volume(facts);
    } else if (facts->range.frames) {
        print_range(facts);
    } else {
        print_points(facts);
        print_shape(facts);
        print_surface(facts);
    }
    row("wrong");
    if (!problems->count)
        printf("nothing\n");
    for (unsigned i = 0; i < problems->count; i++)
        printf("%s%s\n", i ? "            " : "", problems->line[i]);
    if (intent->method[0]) {
        row("would be");
        printf("%s, %s: %s\n", intent->method, intent->path, intent->why);
    }
    row("try");
    printf("%s\n", intent->command);
    if (lies_flat(facts))
        printf("            and --up z, should it lie on its side\n");
}

static void add_counts(struct json_out *out, cJSON *json, const struct stp_facts *facts)
{
    const struct {
        const char *key;
        size_t value;
    } counts[] = {
        { "points", facts->points },          { "splats", facts->splats },
        { "objects", facts->objects },        { "lights", facts->lights },
        { "not_finite", facts->not_finite },  { "clipped", facts->clipped },
        { "duplicates", facts->duplicates },  { "bad_normals", facts->bad_normals },
        { "bad_radii", facts->bad_radii },    { "outliers", facts->outliers },
        { "bad_phong", facts->bad_phong },    { "no_normal", facts->no_normal },
        { "ellipses", facts->phong },         { "clipped_splats", facts->clip_lines },
        { "groups", facts->grouping.groups },
    };
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        json_number(out, json, counts[i].key, (double)counts[i].value);
}

static void add_shape(struct json_out *out, cJSON *json, const struct stp_facts *facts)
{
    static const char *const up[] = { "auto", "x", "y", "z", "-y" };
    const double radius[] = { facts->radius_min, facts->radius_median, facts->radius_max };
    json_numbers(out, json, "bounds", facts->bounds, 6);
    json_numbers(out, json, "origin", facts->origin, 3);
    json_number(out, json, "float_step", facts->float_step);
    json_text(out, json, "up", up[facts->up]);
    cJSON *radii = json_object(out, json, "radius");
    json_number(out, radii, "min", radius[0]);
    json_number(out, radii, "median", radius[1]);
    json_number(out, radii, "max", radius[2]);
    json_text(out, json, "normals",
              facts->normals == STP_NORMALS_GIVEN       ? "given"
              : facts->normals == STP_NORMALS_ESTIMATED ? "estimated"
                                                        : "none");
    json_number(out, json, "outwardness", facts->outwardness);
    json_bool(out, json, "two_sided", facts->two_sided);
    json_bool(out, json, "eye_dome", facts->eye_dome);
    json_bool(out, json, "has_color", facts->has_color);
    json_number(out, json, "color_max", facts->color_max);
    json_bool(out, json, "transparent", facts->transparent);
    json_bool(out, json, "mixed", facts->mixed);
    json_bool(out, json, "uniform_opacity", facts->uniform_opacity);
    json_number(out, json, "opacity_min", facts->opacity_min);
    json_bool(out, json, "positional_lights", facts->positional_lights);
}

static void add_volume(struct json_out *out, cJSON *json, const struct stp_volume_facts *v)
{
    const double dims[3] = { v->dims[0], v->dims[1], v->dims[2] };
    if (!v->dims[0])
        return;
    cJSON *volume = json_object(out, json, "volume");
    json_numbers(out, volume, "dims", dims, 3);
    json_numbers(out, volume, "spacing", v->spacing, 3);
    json_number(out, volume, "low", v->low);
    json_number(out, volume, "high", v->high);
    json_number(out, volume, "opacity_max", v->opacity_max);
    json_text(out, volume, "transfer_function", v->transfer_function);
}

static void add_range(struct json_out *out, cJSON *json, const struct stp_range_facts *r)
{
    if (!r->frames)
        return;
    cJSON *range = json_object(out, json, "range");
    json_number(out, range, "frames", r->frames);
    json_number(out, range, "holes", (double)r->holes);
    json_number(out, range, "deviation_median", r->deviation_median);
    json_number(out, range, "sources", r->sources);
    json_text(out, range, "colors", r->by_views ? "views" : "rgb");
}

/* One file's object of the list. */
static void add_json(struct json_out *out, cJSON *list, const char *path,
                     const struct stp_facts *facts, const struct problems *problems,
                     const struct intent *intent)
{
    cJSON *json = json_object(out, list, NULL);
    json_text(out, json, "file", path);
    json_text(out, json, "format", facts->format);
    add_counts(out, json, facts);
    add_shape(out, json, facts);
    add_volume(out, json, &facts->volume);
    add_range(out, json, &facts->range);
    cJSON *wrong = json_array(out, json, "wrong");
    for (unsigned i = 0; i < problems->count; i++)
        json_text(out, wrong, NULL, problems->line[i]);
    cJSON *would = json_object(out, json, "would");
    json_text(out, would, "method", intent->method);
    json_text(out, would, "path", intent->path);
    json_text(out, would, "why", intent->why);
    json_text(out, would, "command", intent->command);
}

static int describe(struct console *console, const struct settings *settings, const char *path,
                    struct json_out *out, cJSON *list)
{
    struct stp_scene *scene = NULL;
    struct problems problems = { 0 };
    struct intent intent = { 0 };
    int status = load_and_prepare(console, settings, path, &scene, NULL);
    if (status != EXIT_DONE)
        return status;
    status = find_intent(console, settings, scene, path, &intent);
    const struct stp_facts *facts = stp_scene_facts(scene);
    find_problems(facts, &problems);
    if (settings->json)
        add_json(out, list, path, facts, &problems, &intent);
    else
        print_text(path, facts, &problems, &intent);
    stp_scene_destroy(&scene);
    return status;
}

/* Goes on after a bad file; the worst status is the command's. */
int run_info(struct settings *settings)
{
    struct console console;
    int worst = EXIT_DONE;
    struct json_out out = { 0 };
    cJSON *list = settings->json ? json_begin(&out, cJSON_CreateArray()) : NULL;
    console_open(&console, settings);
    for (int i = 0; i < settings->file_count; i++) {
        int status = describe(&console, settings, settings->files[i], &out, list);
        if (i + 1 < settings->file_count && status == EXIT_DONE && !settings->json)
            putchar('\n');
        worst = status > worst ? status : worst;
    }
    int printed = settings->json ? json_print(&console, &out, list) : EXIT_DONE;
    console_close(&console);
    cJSON_Delete(list);
    return printed > worst ? printed : worst;
}
