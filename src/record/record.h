/* Walks a plan: makes its resources and pipelines, records its passes with the barriers that their
 * accesses ask for, and reads the outputs back. */
#ifndef STP_RECORD_RECORD_H
#define STP_RECORD_RECORD_H

#include "passes/passes.h"

struct stp_scene;

struct record_frame {
    const struct stp_plan *plan;
    struct stp_context *context;
    struct pass_resources resources;
    VkPipeline pipeline[PLAN_MAX_PASSES];
    struct gpu_buffer read_back[PLAN_MAX_RESOURCES]; /* of outputs that are not mapped */
    struct gpu_buffer remaining;                     /* STP_WORK_REMAINING, where the plan loops */
    VkQueryPool queries;                             /* RECORD_MAX_STEPS + 1; may be null */
};

/* frame.c */
enum stp_result record_frame_create(const struct stp_env *env, struct stp_context *context,
                                    const struct stp_plan *plan, struct record_frame *frame);
void record_frame_destroy(struct record_frame *frame);

/* upload.c: the scene's buffers of the plan. */
enum stp_result record_upload(const struct stp_env *env, struct record_frame *frame,
                              const struct stp_scene *scene);

/* order.c: puts the splats of a plan that blends in order for its camera; nothing for others.
 * Once a frame, before it is recorded. The other: what of that buffer no frame changes. */
enum stp_result record_order(const struct stp_env *env, struct record_frame *frame,
                             const struct stp_scene *scene);
enum stp_result record_upload_homes(const struct stp_env *env, struct record_frame *frame,
                                    const struct stp_scene *scene, struct gpu_buffer *buffer);

/* walk.c: a tile is recorded in parts of at most RECORD_SAMPLES samples, so that no submission
 * grows with their number. The steps of a part are passes in the order of execution: those before
 * the repeated ones in the first part, the repeated ones once a sample, those after in the last.
 * Where the plan loops, every sample takes two parts, the second being RECORD_TURNS turns of the
 * loop, and what comes after takes one of its own: a part that loops is run while `remaining` is
 * set, which the part before it has left too. */
#define RECORD_SAMPLES   16
#define RECORD_TURNS     16
#define RECORD_MAX_STEPS (PLAN_MAX_PASSES * RECORD_SAMPLES)
struct record_steps {
    const struct stp_plan *plan;
    uint32_t count, before, repeated;
    uint32_t first, length; /* of the passes that are repeated */
    uint32_t first_sample;
    bool loops; /* turns of one sample's loop */
    bool last;  /* outputs are handed to the host after it */
};
uint32_t record_parts(const struct stp_plan *plan);
struct record_steps record_steps(const struct stp_plan *plan, uint32_t part);
/* The pass of step i, and the sample it is for. */
uint32_t record_step(const struct record_steps *steps, uint32_t i, uint32_t *sample);

/* walk.c: records one part of one tile; nothing is allocated, submitted or waited for. timed: a
 * full barrier and a timestamp after every step. skip_barrier: leaves out the barrier before that
 * pass (tests prove with it that validation sees). */
#define RECORD_NO_PASS     UINT32_MAX
void record_walk(struct record_frame *frame, VkCommandBuffer commands, const struct plan_tile *tile,
                 uint32_t part, bool timed, uint32_t skip_barrier);

/* picture.c: outputs of one tile into the picture. */
enum stp_result record_picture(const struct stp_env *env, const struct stp_scene *scene,
                               const struct stp_plan *plan, struct stp_image **image);
enum stp_result record_read_back(const struct stp_env *env, struct record_frame *frame,
                                 const struct stp_scene *scene, const struct plan_tile *tile,
                                 struct stp_image *image);

/* render.c: all tiles once, from record to fence; *ms leaves reading back apart. image NULL:
 * nothing is read. The scene must have been uploaded. */
enum stp_result record_run(const struct stp_env *env, struct record_frame *frame,
                           const struct stp_scene *scene, struct stp_image *image, double *ms,
                           double *read_back_ms);
/* A few more frames, timed pass by pass: stats->pass gets the medians. */
enum stp_result record_profile(const struct stp_env *env, struct record_frame *frame,
                               struct stp_render_stats *stats);

#endif
