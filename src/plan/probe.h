/* A scene's own error under a method, from a sample of its pixels: all fragments of these pixels
 * are found in double, then resolved twice, as Eq. 1 says and as the method would. What methods
 * differ in is which fragments they keep and in how many bits; shading is the reference's. */
#ifndef STP_PLAN_PROBE_H
#define STP_PLAN_PROBE_H

#include "plan/plan.h"
#include "plan/survey.h"
#include "reference/tile.h"

#define PROBE_CELL        4 /* pixels a side; a quarter of a block */
#define PROBE_CELL_PIXELS (PROBE_CELL * PROBE_CELL)
#define PROBE_ACROSS      (SURVEY_BLOCK / PROBE_CELL) /* places for cells of a block, a side */
#define PROBE_NO_CELL     UINT32_MAX                  /* in maps from places to cells */
#define PROBE_UNSEEN      3 /* of what is rare a sample may have missed so many: once in 20 */

struct probe_fragment {
    double depth, rho2, weight;
    struct vec3 normal; /* camera frame, turned */
    uint32_t splat;     /* canonical id */
    uint32_t pixel;     /* of the probe */
    uint8_t group;
    bool kept;
};

struct probe {
    struct view view;
    float background[4]; /* behind it all; alpha 0: nothing */
    bool environment_behind;
    unsigned cells;
    unsigned parts;        /* this one counted: every cell of a touched block is in one of them */
    double all_cells;      /* of all parts */
    double amplify;        /* probe_perturb: so many times a float's roundings */
    uint32_t (*corner)[2]; /* of each cell, pixels of the picture */
    size_t pixels;         /* PROBE_CELL squared a cell, those outside the picture empty */
    struct ray *ray;
    size_t *first;                   /* pixels + 1 */
    struct probe_fragment *fragment; /* by pixel, then in canonical order */
    double *truth;                   /* three a pixel, the background included */
    double layers;                   /* a pixel, in the mean */
    size_t splats;                   /* that have a fragment, or nearly */
    uint32_t *splat;                 /* ascending */
};

/* Which pixels: at most `cells` cells, spread over the touched blocks. As many parts as it takes,
 * each so large or a cell smaller, have no cell in common and leave out none. Where many fragments
 * lie one behind another cells are fewer, but never fewer than PROBE_LEAST_CELLS. */
#define PROBE_FRAGMENTS   8388608 /* 0.6 GB, twice while they are sorted */
#define PROBE_LEAST_CELLS 64      /* fewer say too little of how cells differ */
struct probe_sample {
    unsigned cells, part;
    bool alone;       /* stands for the picture by itself: no other part will be looked at */
    double fragments; /* at most so many, about; 0: PROBE_FRAGMENTS */
};
enum stp_result probe_make(const struct stp_env *env, const struct stp_scene *scene,
                           const struct stp_camera *camera, const struct stp_render_params *params,
                           const struct survey *survey, const struct probe_sample *sample,
                           struct probe *probe);
void probe_release(struct probe *probe);

/* What the method that `plan` stands for does with one pixel's fragments (count > 0, canonical
 * order): clears `kept` of those that it loses, and rounds depth, weight and normal as it would. */
typedef void (*probe_keep_fn)(const struct stp_plan *plan, struct probe_fragment *fragment,
                              size_t count);

/* A pixel as some other means than `keep` drew it. */
struct probe_color {
    double color[3]; /* with what is behind */
    bool covered;
};

/* What estimates are made of: sums over cells, e being a cell's error and n its covered pixels. */
struct probe_tally {
    double cells, all_cells, e, n, ee, en, nn, most; /* most: the largest e */
    double growth,
        growth2;      /* of pixels' errors, that roundings are expected to make; and squares */
    double tossed;    /* pixels, each times what its roundings were enlarged by */
    double bright[3]; /* the most of each channel that a pixel has */
};

struct probe_error {
    double mean;     /* absolute error of linear R G B over covered pixels */
    double spread;   /* standard error of that mean, from the spread over the cells; 0: all were
                        looked at */
    double rounding; /* that float arithmetic may add to the mean: probe_rounding.c */
    double flips;    /* and pixels that change sides by it, though none was seen to */
    size_t pixels;   /* covered */
    struct probe_tally tally;
};
/* group: of every splat of the scene, or, when `local`, of every splat of the probe; NULL: none. */
enum stp_result probe_judge(const struct stp_env *env, const struct probe *probe,
                            const struct stp_plan *plan, probe_keep_fn keep, const uint8_t *group,
                            bool local, struct probe_error *error);

/* `part` is of other cells: both together. */
void probe_error_join(struct probe_error *error, const struct probe_error *part);

/* probe_environment.c: how far the levels that rough light is looked up in are off the light
 * itself, in the mean over directions; 0 where nothing is rough. Tenths of a second a roughness. */
double probe_levels_error(const struct stp_env *env, const struct view *view);

/* Groups the probe's splats among themselves, as a foretaste of grouping the whole scene: K is
 * then too low, and the error about right. To be freed. */
enum stp_result probe_group(const struct stp_env *env, const struct probe *probe,
                            const struct stp_group_params *params, uint8_t **group,
                            struct stp_grouping *facts);

/* probe_rounding.c: a pixel's fragments as if all roundings of float arithmetic were so many times
 * as large, by signs that hang on splat and pixel alone; returns how many are left. */
size_t probe_perturb(const struct probe *probe, struct probe_fragment *fragment, size_t count);
double probe_amplify(const struct probe_sample *sample, unsigned parts);
/* What roundings may add to the mean error of the whole picture; 0 where nothing was perturbed. */
double probe_rounding(const struct probe_tally *tally);
/* What pixels may add to it that change sides by roundings and are like none of those seen: so many
 * as happen more often than once in a hundred pictures, each as large as a change can be. */
double probe_flips(const struct probe_tally *tally);

/* probe_resolve.c: a pixel's kept fragments, in canonical order. */
struct probe_pixel {
    const struct probe_fragment *fragment;
    size_t count;
    unsigned most_layers; /* those behind are left out */
    double slack;         /* of an epsilon's end, where depths are in steps: less than one */
    float color_steps;    /* from 0 to 1, to which colours are rounded; 0: they are not */
};
/* Its colour, with what is behind; returns its layers, 0 where nothing is kept. */
unsigned probe_resolve(const struct probe *probe, size_t at, const struct probe_pixel *pixel,
                       double color[3]);
/* For probe.c: fills `truth` and `layers`. */
enum stp_result probe_truth(const struct stp_env *env, struct probe *probe);

#endif
