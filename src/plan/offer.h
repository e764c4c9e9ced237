/* What a method tells `auto` about itself: the ways it can be run, what a frame costs it, and how
 * far it is from the reference. One of these a method, in the method's own file; auto.c loops over
 * them. A new method adds its offer to `plan_offers` and its kinds of cost to `enum plan_cost`. */
#ifndef STP_PLAN_OFFER_H
#define STP_PLAN_OFFER_H

#include "plan/probe.h"

/* One way to run a method. */
struct plan_candidate {
    enum stp_method method;
    enum stp_path path;
    enum stp_payload payload; /* AUTO: what the plan says */
    enum stp_voronoi voronoi;
    double overlap;                     /* of the groups; 0: it needs none */
    enum stp_transparency transparency; /* AUTO: of opaque scenes */
    unsigned layers;                    /* that are peeled; 0: all, by other means */
};

/* A frame's time is a sum of amounts, each at a price in nanoseconds that calibration finds; what
 * an amount stands for is the method's to say (layers times pixels, say), its name only a hint. */
enum plan_term {
    PLAN_TERM_FRAME,     /* tiles */
    PLAN_TERM_SPLATS,    /* of the scene, once a tile */
    PLAN_TERM_DRAWN,     /* splats in the picture */
    PLAN_TERM_BOX,       /* pixels in the bounds of small splats */
    PLAN_TERM_LARGE,     /* splats that take a workgroup each */
    PLAN_TERM_LARGE_BOX, /* and pixels in their bounds */
    PLAN_TERM_FRAGMENTS,
    PLAN_TERM_PIXELS,   /* of the picture */
    PLAN_TERM_TOUCHED,  /* of the blocks that splats touch */
    PLAN_TERM_DEEP,     /* fragments, or pixels, that cost more than others */
    PLAN_TERM_OVERFLOW, /* what is done again */
    PLAN_TERMS
};
_Static_assert(PLAN_TERMS <= STP_COST_TERMS, "a profile holds every term");

/* Ways to run that have prices of their own. Profiles name them: plan_cost_name. */
enum plan_cost {
    PLAN_COST_EXACT_PACKED,
    PLAN_COST_EXACT_PACKED_IDS,
    PLAN_COST_EXACT_ID,
    PLAN_COST_EXACT_ID_COLOR,
    PLAN_COST_TWO_PASS,
    PLAN_COST_TWO_PASS_COLOR,
    PLAN_COST_TWO_PASS_RASTER,
    PLAN_COST_TWO_PASS_RASTER_COLOR,
    PLAN_COST_DEFERRED_PACKED,
    PLAN_COST_DEFERRED_ID,
    PLAN_COST_DEFERRED_EXACT,
    PLAN_COST_DEFERRED_RASTER,
    PLAN_COST_DEFERRED_RASTER_ID,
    PLAN_COST_PYRAMID,
    PLAN_COST_PYRAMID_COLOR,
    PLAN_COST_LAYERS_PACKED, /* exact's, of transparent scenes */
    PLAN_COST_LAYERS_PACKED_IDS,
    PLAN_COST_LAYERS_ID,
    PLAN_COST_PEEL,
    PLAN_COST_PEEL_COLOR,
    PLAN_COST_PEEL_RASTER,
    PLAN_COSTS
};
_Static_assert(PLAN_COSTS <= STP_COST_KINDS, "a profile holds every kind");
const char *plan_cost_name(enum plan_cost cost); /* "exact packed", ...; NULL: none such */
const char *plan_term_name(enum plan_term term);

#define PLAN_MAX_OFFERED 32 /* candidates of one method */

/* The probe's pixels as a method draws them that looks at more than a pixel's own fragments. */
typedef enum stp_result (*plan_draw_fn)(const struct stp_env *env, const struct probe *probe,
                                        const struct stp_plan *plan, struct probe_color *color);

struct plan_offer {
    enum stp_method method;
    enum stp_transparency transparency; /* AUTO: of opaque scenes */
    /* Every way, whether or not the scene and the device allow it; returns how many. */
    unsigned (*candidates)(struct plan_candidate candidate[PLAN_MAX_OFFERED]);
    /* The amounts of one frame of this plan, one sample a pixel; returns the kind. */
    enum plan_cost (*cost)(const struct stp_plan *plan, const struct survey *survey,
                           double amount[PLAN_TERMS]);
    /* Which fragments it keeps, and in how many bits: the probe then measures the error. */
    probe_keep_fn keep;
    plan_draw_fn draw; /* NULL, or in the place of keep */
    /* The error, summed over its pixels, of a cell that few others are like: 0 where all are alike.
     */
    double rare;
};

extern const struct plan_offer plan_exact_offer, plan_twopass_offer, plan_deferred_offer,
    plan_pyramid_offer, plan_layers_offer, plan_peel_offer;
extern const struct plan_offer *const plan_offers[];
extern const unsigned plan_offer_count;
const struct plan_offer *plan_offer_of(const struct stp_plan *plan); /* NULL: it makes none */

/* cost.c: amounts that most methods share, to begin with. */
void plan_common_amounts(const struct stp_plan *plan, const struct survey *survey,
                         double amount[PLAN_TERMS]);
/* Milliseconds of a warm frame, all samples; INFINITY where the profile has no price of its kind.
 */
double plan_predict(const struct stp_plan *plan, const struct survey *survey,
                    const struct stp_calibration *calibration);
/* What float arithmetic adds to the error beside what a probe says of it (probe_error.rounding). */
double plan_rounding(const struct stp_plan *plan);

/* probe_judge.c: the error of the plan over the probe's pixels, by its method's `keep` or `draw`;
 * group and local as of probe_judge. */
enum stp_result plan_judge(const struct stp_env *env, const struct probe *probe,
                           const struct stp_plan *plan, const uint8_t *group, bool local,
                           struct probe_error *error);

/* plan.c: a plan for this candidate, without a line in the log where it cannot be. grouping stands
 * for the scene's. *plan stays NULL where the candidate does not apply. */
enum stp_result plan_try(const struct stp_env *env, const struct stp_scene *scene,
                         const struct stp_camera *camera, const struct stp_render_params *params,
                         const struct stp_limits *limits, const struct plan_candidate *candidate,
                         const struct stp_grouping *grouping, struct stp_plan **plan);

/* quantise.c: a fragment as the device's keys hold it. */
void plan_quantise_packed(const struct stp_plan *plan, struct probe_fragment *fragment);

#endif
