/* The sweep behind stp_report: which configurations there are, and their frames kept on the device
 * at once, so that they are timed in turns. */
#ifndef STP_STUDY_STUDY_H
#define STP_STUDY_STUDY_H

#include <stipple/report.h>

#include "plan/offer.h"
#include "prepare/groupings.h"
#include "record/record.h"
#include "report/report.h"

/* configs.c: the parameters that are swept. */

struct study_config {
    enum stp_method method;
    enum stp_path path;
    enum stp_payload payload; /* AUTO: what the plan says */
    enum stp_voronoi voronoi;
    double overlap;                     /* deferred only, else 0 */
    double epsilon_scale;               /* of the reference's */
    enum stp_transparency transparency; /* AUTO: what is opaque, or a volume */
    unsigned peel_layers;
    enum stp_axis_merge merge; /* volumes only */
    double axis_h;             /* as in stp_render_params */
};

#define STUDY_MAX_CONFIGS 64
/* Every combination for such a scene (opaque, transparent, or a volume), applicable or not; methods
 * one after another. Returns how many. */
unsigned study_configs(const struct stp_facts *facts, bool quick,
                       struct study_config configs[STUDY_MAX_CONFIGS]);
/* The row's words and parameters; nothing that is measured. */
void study_describe(const struct study_config *config, struct report_row *row);
/* NULL when the plan does what the configuration says, else why it does not. */
const char *study_mismatch(const struct study_config *config, const struct stp_plan *plan);

/* frames.c: frames that live beside each other. */

struct study_frame {
    struct study_config config;
    struct stp_plan *plan;
    struct record_frame frame;
    bool alive;
    uint64_t used; /* the turn in which it ran last */
    double *ms;    /* timed frames so far */
    unsigned count;
    bool done; /* no more of them are needed: report_outclassed */
    struct heat heat;
};

struct study {
    const struct stp_env *env;
    struct stp_env quiet; /* env without progress */
    struct stp_context *context;
    struct stp_scene *scene;
    const struct stp_camera *camera;
    struct stp_report_params params;
    double epsilon;
    struct groupings groups;
    struct stp_image *reference;
    struct study_frame *frame;
    unsigned frame_count;
    struct report report;  /* row i is frame i's; the reference's comes after them */
    uint64_t budget, held; /* bytes on the device: most, and now */
    uint64_t turn;
    bool has_exact; /* one of the frames is of method exact: it takes any number of samples */
};

void study_frame_sleep(struct study *study, struct study_frame *frame);
/* Every frame in turns: the first visit also reads the picture and measures its error, and of each
 * visit the first frame is not timed. What is outclassed in the first round has that one only. */
enum stp_result study_time(struct study *study);
/* Times of passes of the rows that matter: the front, and the two-pass baseline. */
enum stp_result study_profile(struct study *study);
uint64_t study_budget(const struct stp_context *context);

/* study.c */

/* A frame for this configuration, or a line in the report that says why there is none. */
enum stp_result study_try(struct study *study, const struct study_config *config);

/* picks.c: what auto would take for a few bounds; joins the frames that are timed. */
enum stp_result study_pick(struct study *study);

/* samples.c: error against the number of samples a pixel, where method exact applies. */
enum stp_result study_samples(struct study *study);

/* amounts.c: what a frame's time is predicted from, and the time that was measured. */
void study_log_amounts(const struct stp_env *env, enum plan_cost kind,
                       const double amount[PLAN_TERMS], double ms);
/* A line for every frame of an opaque sweep that has a price; after study_time. */
enum stp_result study_log_costs(struct study *study);

/* files.c */

enum stp_result study_write(struct study *study, const char *folder);

#endif
