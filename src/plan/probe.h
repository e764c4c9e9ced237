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
    unsigned cells;
    size_t pixels; /* PROBE_CELL squared a cell, those outside the picture empty */
    struct ray *ray;
    size_t *first;                   /* pixels + 1 */
    struct probe_fragment *fragment; /* by pixel, then in canonical order */
    double *truth;                   /* three a pixel */
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

/* probe_judge.c, for probe.c: fills `truth`. */
enum stp_result probe_truth(const struct stp_env *env, struct probe *probe);

#endif
