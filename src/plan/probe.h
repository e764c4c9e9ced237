/* A scene's own error under a method, from a sample of its pixels: all fragments of these pixels
 * are found in double, then resolved twice, as Eq. 1 says and as the method would. What methods
 * differ in is which fragments they keep and in how many bits; shading is the reference's. */
#ifndef STP_PLAN_PROBE_H
#define STP_PLAN_PROBE_H

#include "plan/plan.h"
#include "plan/survey.h"
#include "reference/tile.h"

#define PROBE_CELL 4 /* pixels a side; one to a block at most */

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

/* At most `cells` cells, spread over the touched blocks. */
enum stp_result probe_make(const struct stp_env *env, const struct stp_scene *scene,
                           const struct stp_camera *camera, const struct stp_render_params *params,
                           const struct survey *survey, unsigned cells, struct probe *probe);
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

struct probe_error {
    double mean;   /* absolute error of linear R G B over covered pixels */
    double spread; /* standard error of that mean, from the spread over the cells */
    size_t pixels; /* covered */
};
/* group: of every splat of the scene, or, when `local`, of every splat of the probe; NULL: none. */
enum stp_result probe_judge(const struct stp_env *env, const struct probe *probe,
                            const struct stp_plan *plan, probe_keep_fn keep, const uint8_t *group,
                            bool local, struct probe_error *error);

/* Groups the probe's splats among themselves, as a foretaste of grouping the whole scene: K is
 * then too low, and the error about right. To be freed. */
enum stp_result probe_group(const struct stp_env *env, const struct probe *probe,
                            const struct stp_group_params *params, uint8_t **group,
                            struct stp_grouping *facts);

/* Of a picture drawn by other means, over the pixels that it or the truth covers; color: one a
 * pixel. */
enum stp_result probe_compare(const struct stp_env *env, const struct probe *probe,
                              const struct probe_color *color, struct probe_error *error);

/* probe_resolve.c: a pixel's kept fragments, in canonical order. */
struct probe_pixel {
    const struct probe_fragment *fragment;
    size_t count;
    unsigned most_layers; /* those behind are left out */
    double slack;         /* of an epsilon's end, where depths are in steps: less than one */
};
/* Its colour, with what is behind; returns its layers, 0 where nothing is kept. */
unsigned probe_resolve(const struct probe *probe, size_t at, const struct probe_pixel *pixel,
                       double color[3]);
/* For probe.c: fills `truth` and `layers`. */
enum stp_result probe_truth(const struct stp_env *env, struct probe *probe);

#endif
