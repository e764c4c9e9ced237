/* While auto decides: the ways to render, the cheapest first, each judged only as far as it takes
 * to accept or refuse it. */
#ifndef STP_PLAN_AUTO_H
#define STP_PLAN_AUTO_H

#include "plan/offer.h"
#include "prepare/groupings.h"

/* How well a candidate is known. */
enum auto_stage {
    AUTO_PRICED,   /* cost only; of groups that were found for the probe's splats alone */
    AUTO_GROUPED,  /* cost with the scene's own groups, or without any */
    AUTO_ACCEPTED, /* within the bound */
    AUTO_REFUSED,  /* beyond it */
};

struct auto_candidate {
    struct plan_candidate way;
    bool slow;  /* to judge: the scene is grouped for it, or a picture drawn */
    bool close; /* to the bound: samples leave it open */
    enum auto_stage stage;
    struct stp_grouping grouping; /* that the price is for */
    double ms;
    double error; /* at most; NaN: not judged */
};

struct auto_local {
    double overlap;
    struct stp_grouping facts;
    uint8_t *group; /* of the probe's splats */
};

struct choosing {
    const struct stp_env *env;
    struct stp_scene *scene;
    const struct stp_camera *camera;
    struct stp_group_params group;
    struct stp_render_params params;
    const struct stp_limits *limits;
    double bound;
    struct survey survey;
    struct probe probe[2]; /* few cells, and many; the second is made when it is needed */
    bool probed[2];
    struct groupings groupings;
    unsigned local_count, count;
    double levels_error; /* of rough light, that no probe sees */
    struct auto_local local[MAX_GROUPINGS];
    struct auto_candidate candidate[STP_MAX_CONSIDERED];
};

/* What comes first is judged first. Prices are right to about so much: what they say is saved by
 * less may be none, and is not worth groups that take seconds, or a greater error; nor are more
 * cells than a sample's where another way costs hardly more. */
#define AUTO_DOUBT 1.05
#define AUTO_WORTH 1.15
static inline double auto_reckoned(const struct auto_candidate *candidate)
{
    return candidate->ms * (candidate->slow ? AUTO_DOUBT : 1) * (candidate->close ? AUTO_WORTH : 1);
}

/* auto_judge.c: what a sample says of a way. */
struct auto_estimate {
    struct probe_error error;
    double more; /* that no probe sees */
    double rare; /* the error of a rare cell */
    double low, high;
};
/* How many cells decide where few do not. */
#define AUTO_CELLS 1536
/* Fills low and high from the rest. */
void auto_conclude(struct auto_estimate *estimate);

/* auto_judge.c: one step further with this candidate. */
enum stp_result auto_judge(struct choosing *choosing, struct auto_candidate *candidate);
/* The price under this grouping; *applies false: the candidate cannot be planned. */
enum stp_result auto_price(struct choosing *choosing, struct auto_candidate *candidate,
                           const struct stp_grouping *grouping, bool *applies);
/* A foretaste of the groups at this overlap. */
enum stp_result auto_local(struct choosing *choosing, double overlap,
                           const struct auto_local **local);
enum stp_result auto_probe(struct choosing *choosing, unsigned which);

#endif
