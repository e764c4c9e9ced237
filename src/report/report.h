/* What a sweep has measured, and the tables and plots that are made of it: data to text. Nothing
 * here renders or knows how a row came about. */
#ifndef STP_REPORT_REPORT_H
#define STP_REPORT_REPORT_H

#include <stdio.h>
#include <stipple/compare.h>
#include <stipple/render.h>

/* Mean absolute errors below this count as equal: half a step of float32 at 1. */
#define REPORT_ERROR_FLOOR 5.9604644775390625e-8

/* Of the timed frames, milliseconds. */
struct report_times {
    unsigned frames;
    double min, quartile1, median, quartile3, max;
};

struct report_row {
    const char *method, *path;     /* as on the command line */
    const char *payload, *voronoi; /* "" where the method has none */
    const char *transparency;      /* NULL: nothing is transparent */
    const char *merge;             /* of axis lists; NULL: not a volume */
    unsigned peel_layers;          /* 0: nothing is peeled */
    double axis_h;                 /* of lists that are blended */
    double overlap_asked;          /* 0: nothing is grouped */
    struct stp_grouping grouping;
    double epsilon_scale; /* of the reference's epsilon; 1 but for variants */
    bool is_reference;    /* what errors are measured against; not a contender */
    bool is_baseline;     /* one of those that the others are set beside */
    struct report_times ms;
    struct stp_comparison error;
    uint64_t scene_bytes, transient_bytes;
    unsigned tiles, pass_count;
    struct stp_pass_time pass[STP_MAX_PASSES];
    bool on_front;    /* report_find_front */
    char picture[32]; /* the error picture's file; "": none */
};

struct report_skip {
    char name[80], why[256];
};

/* What auto takes for a bound on the mean absolute error. */
struct report_pick {
    double bound;
    unsigned row;     /* the configuration that it takes */
    double ms, error; /* predicted; the error at most */
    bool met;         /* auto is sure of the bound */
};
#define REPORT_MAX_PICKS 8

/* One sample a pixel and more, against the reference of many. */
struct report_samples {
    unsigned count; /* a pixel */
    struct report_times ms;
    struct stp_comparison error;
};
#define REPORT_MAX_SAMPLES 8

#define REPORT_MAX_ROWS 128

struct report {
    const char *title, *command; /* command may be NULL */
    const char *device, *driver, *version;
    uint32_t width, height;
    size_t splats; /* or kernels of a volume */
    bool is_volume;
    double epsilon, min_splat;
    const char *kernel, *cull;
    unsigned rounds;
    double seconds; /* the sweep took */
    struct report_row *row;
    unsigned row_count; /* at most REPORT_MAX_ROWS */
    struct report_skip *skip;
    unsigned skip_count;
    struct report_pick pick[REPORT_MAX_PICKS];
    unsigned pick_count;
    struct report_samples samples[REPORT_MAX_SAMPLES];
    unsigned samples_count, samples_truth; /* the reference's */
    uint32_t samples_width, samples_height;
};

/* front.c */

/* Mean absolute error over covered pixels, at least the floor: what configurations are ranked by.
 */
double report_error(const struct report_row *row);
/* False for the reference, and for variants of epsilon: those show another picture. */
bool report_contends(const struct report_row *row);
/* Marks every row that no other beats in one of time and error without losing in the other. Of
 * equal rows the first is kept. */
void report_find_front(struct report *report);
/* The front from the fastest to the most exact; returns how many. */
unsigned report_front(const struct report *report, const struct report_row **front);
/* What tells rows apart at a glance: of surfaces the method, of transparent ones how their layers
 * are composited, of volumes how their lists are merged. */
const char *report_kind(const struct report_row *row);
/* The fastest row with at most this error, the most exact within this time, NULL when there is
 * none. kind NULL: any. */
const struct report_row *report_fastest(const struct report *report, const char *kind,
                                        double most_error);
const struct report_row *report_most_exact(const struct report *report, const char *kind,
                                           double most_ms);
/* Something at least as exact takes less than a REPORT_OUTCLASSED-th of its median: more frames of
 * it would not bring it to the front. Never true of baselines. */
#define REPORT_OUTCLASSED 3
bool report_outclassed(const struct report *report, const struct report_row *row);
/* NULL: the sweep has no baseline. */
const struct report_row *report_baseline(const struct report *report);
/* The kinds in order of appearance, the reference apart. */
#define REPORT_MAX_KINDS 8
unsigned report_kinds(const struct report *report, const char *kinds[REPORT_MAX_KINDS]);
/* Sorts and summarises; quartiles are interpolated. count > 0. */
struct report_times report_times(double *ms, unsigned count);

/* "deferred compute, c 0.4, Voronoi slab, packed", "peel raster, 8 layers", "blend compute, h 0.85"
 */
#define REPORT_NAME_SIZE 96
const char *report_row_name(const struct report_row *row, char name[REPORT_NAME_SIZE]);
/* "splats", or what else the scene is drawn of, in the number of report->splats. */
const char *report_splats(const struct report *report);
/* Four significant digits at most, no exponent from 0.001 to 99999; "inf" for infinity. */
#define REPORT_NUMBER_SIZE 32
const char *report_number(double value, char text[REPORT_NUMBER_SIZE]);

/* All expect the C locale, and report failures through ferror. */
void report_csv(FILE *out, const struct report *report);
void report_markdown(FILE *out, const struct report *report);
void report_svg(FILE *out, const struct report *report);
/* picks.c: beside the fastest row within the bound. */
void report_picks_csv(FILE *out, const struct report *report);
void report_picks_markdown(FILE *out, const struct report *report);

/* samples.c */
void report_samples_csv(FILE *out, const struct report *report);
void report_samples_markdown(FILE *out, const struct report *report);

/* heat.c: pictures of the error. */

/* Errors at or below the low end are drawn in its colour, likewise at the high end. */
#define HEAT_LOW   1e-4
#define HEAT_HIGH  1e-1
#define HEAT_WIDTH 480 /* pictures are reduced to at most this */

/* The largest channel difference a pixel, averaged over the pixels that fall into one of the
 * picture's; -1 where neither picture is covered. Both need R G B A. */
struct heat {
    uint32_t width, height;
    float *error;
};
enum stp_result heat_measure(const struct stp_env *env, const struct stp_image *image,
                             const struct stp_image *reference, struct heat *heat);
/* Linear R G B A, to be written as PNG; with the scale as a bar along the bottom. */
enum stp_result heat_picture(const struct stp_env *env, const struct heat *heat,
                             struct stp_image **picture);
void heat_release(struct heat *heat);
/* Linear colour of an error on the scale. */
void heat_color(double error, float rgb[3]);

#endif
