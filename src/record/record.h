/* Walks a plan: makes its resources and pipelines, records its passes with the barriers that their
 * accesses ask for, and reads the outputs back. */
#ifndef STP_RECORD_RECORD_H
#define STP_RECORD_RECORD_H

#include <stipple/machines.h>

#include "passes/passes.h"
#include "scene/deep.h"

struct splats;
struct stp_scene;
struct record_share;

/* What frames share whose plans are alike but for sizes and splats; the context keeps it. */
struct record_pipelines {
    struct gpu_kept kept;
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline[PLAN_MAX_PASSES]; /* passes that are alike have the same */
    VkPipeline host;                      /* the last pass of a host's frame */
};

/* Of a deep picture: the layers that have been read so far. */
struct record_deep {
    struct deep_list list;
    uint32_t *taken;     /* of each pixel of a tile; NULL: none are kept */
    uint32_t first;      /* of the window */
    bool more;           /* some pixel has layers behind the window */
    const float *layers; /* what the device keeps */
};

struct record_frame {
    const struct stp_plan *plan;
    struct stp_context *context;
    struct pass_resources resources;
    struct record_pipelines *pipelines;
    struct gpu_block scratch;                        /* of a hosted frame */
    struct gpu_buffer read_back[PLAN_MAX_RESOURCES]; /* of outputs that are not mapped */
    struct gpu_buffer remaining;                     /* STP_WORK_REMAINING, where the plan loops */
    VkQueryPool queries;                             /* RECORD_MAX_STEPS + 1; may be null */
    struct record_share *share;                      /* NULL: one process makes the picture */
    struct axis_lists axis;                          /* of record_view */
    struct axis_blocks axis_blocks;
    struct record_deep *deep; /* NULL: layers are not read */
};

/* resources.c: buffers and images of the lifetimes in `wanted` (1 << enum plan_lifetime, or-ed);
 * from the block when that is not NULL. On failure the caller destroys what there is. */
#define RECORD_WITHOUT_SCENE (RECORD_ALL & ~(1u << PLAN_SCENE))
#define RECORD_ALL           ((1u << PLAN_SCENE) | (1u << PLAN_TRANSIENT) | (1u << PLAN_OUTPUT))
enum stp_result record_resources_create(const struct stp_env *env, struct stp_context *context,
                                        const struct stp_plan *plan, unsigned wanted,
                                        struct gpu_block *block, struct pass_resources *resources);
void record_resources_destroy(struct stp_context *context, struct pass_resources *resources);
/* What record_resources_create would take of a block, with the frame's constants. */
VkMemoryRequirements record_resources_need(const struct stp_context *context,
                                           const struct stp_plan *plan, unsigned wanted);

/* What is bound beside the frame block, whose binding is 0: images and texels. */
struct record_bindings {
    uint32_t count;
    uint32_t binding[PLAN_SLOTS];
    uint8_t resource[PLAN_SLOTS];
    VkDescriptorType type[PLAN_SLOTS];
};

/* pipelines.c. What is taken is left with gpu_leave_kept; host NULL: no host's frame. */
struct record_bindings record_bindings(const struct stp_plan *plan);
enum stp_result record_pipelines_take(const struct stp_env *env, struct stp_context *context,
                                      const struct stp_plan *plan, const struct pass_host *host,
                                      struct record_pipelines **pipelines);

/* frame.c: with the scene's buffers, outputs that can be read back, and queries. */
enum stp_result record_frame_create(const struct stp_env *env, struct stp_context *context,
                                    const struct stp_plan *plan, struct record_frame *frame);
void record_frame_destroy(struct record_frame *frame);

/* A frame of a host's: the scene's buffers are a resident's, and nothing is read back. */
struct record_host {
    struct pass_host pass;
    const struct stp_device_memory *scratch; /* NULL: memory of its own */
};
enum stp_result record_frame_create_hosted(const struct stp_env *env, struct stp_context *context,
                                           const struct stp_plan *plan,
                                           const struct record_host *host,
                                           struct record_frame *frame);

/* upload.c: the scene's buffers of the plan; but not those of points that come in chunks. */
enum stp_result record_upload(const struct stp_env *env, struct record_frame *frame,
                              const struct stp_scene *scene);
/* upload_range.c: the kernels of a plan whose kernels are ellipsoids. */
enum stp_result upload_ellipsoids(const struct stp_env *env, struct record_frame *frame,
                                  const struct stp_scene *scene, struct gpu_buffer *buffer);
/* upload_points.c: the points of one chunk, in the place of those before. Nothing of the frame may
 * be running. */
enum stp_result record_upload_chunk(const struct stp_env *env, struct record_frame *frame,
                                    const struct stp_scene *scene, uint32_t chunk);
/* One resource of points: splats [first, first + count). False: it is none. */
bool record_upload_points(const struct stp_env *env, struct record_frame *frame,
                          const struct splats *splats, uint32_t resource, size_t first,
                          size_t count, enum stp_result *result);
/* 32 bits of an octahedral map, as unpackSnorm2x16 reads them. */
uint32_t record_octahedral(const float n[3]);

/* upload_clusters.c: splats [first, first + count), STP_CLUSTER by STP_CLUSTER. */
enum stp_result record_upload_clusters(const struct stp_env *env, struct record_frame *frame,
                                       const struct splats *splats, size_t first, size_t count,
                                       struct gpu_buffer *buffer);

/* upload_phong.c */
enum stp_result record_upload_ellipses(const struct stp_env *env, struct record_frame *frame,
                                       const struct splats *splats, struct gpu_buffer *buffer);
enum stp_result record_upload_clips(const struct stp_env *env, struct record_frame *frame,
                                    const struct splats *splats, struct gpu_buffer *buffer);

/* axis.c: the lists of a view, or of its blocks, into the frame's buffers. */
enum stp_result record_lists(const struct stp_env *env, struct record_frame *frame,
                             const struct axis_lists *lists, const struct axis_blocks *blocks);
/* What a changed camera takes of the CPU before a frame of a volume: its lists made again and
 * handed to the device. For frames that are timed; the camera is the plan's, so that the lists are
 * the ones that lie there. Nothing for other methods. */
enum stp_result record_view(const struct stp_env *env, struct record_frame *frame,
                            const struct stp_scene *scene);

/* exchange.c: what several processes need beside a frame. */
struct record_share {
    const struct stp_machines *machines;
    bool agreed;       /* that the picture has failed: everyone knows */
    int64_t *values;   /* RECORD_CHUNK * RECORD_MOST_VALUES */
    uint64_t *sums;    /* of a chunk, where the host does not see the device's */
    uint32_t *hit;     /* pixels of a chunk that have a fragment */
    float (*ghost)[8]; /* the root: splats of a chunk that others hold, and their colours */
    float (*ghost_color)[3];
    uint32_t *ghost_input; /* the root, where ids are asked for: of each ghost of each sample */
};
#define RECORD_CHUNK       65536 /* pixels that are exchanged at once */
#define RECORD_MOST_VALUES STP_SUM_WORDS

enum stp_result record_share_create(const struct stp_env *env, const struct stp_plan *plan,
                                    const struct stp_machines *machines,
                                    struct record_share *share);
void record_share_destroy(struct record_share *share);
/* The result of all processes: see agree in stipple/machines.h. */
enum stp_result record_agree(struct record_share *share, enum stp_result mine);
/* Ghosts of the processes that are not the root; after record_upload. */
enum stp_result record_ghosts(const struct stp_env *env, struct record_frame *frame);
/* Exchanges by an EXCHANGE pass, after what comes before it has been waited for; collective. mine:
 * what this process has come to. */
enum stp_result record_exchange(const struct stp_env *env, struct record_frame *frame,
                                const struct stp_scene *scene, const struct plan_pass *pass,
                                uint32_t sample, enum stp_result mine);
/* The input index of ghost id `id` in the picture that `sample` of the pixel gave. */
uint32_t record_ghost_input(const struct record_frame *frame, uint32_t id, uint32_t sample);
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
 * set, which the part before it has left too.
 * Where processes exchange, a part ends before each exchange, and the next begins after it.
 * Where points come in chunks, a part is one chunk of one sample, with the passes that take it, or
 * that take it again: before it the caller brings the chunk's points to the device. */
#define RECORD_SAMPLES   16
#define RECORD_TURNS     16
#define RECORD_MAX_STEPS (PLAN_MAX_PASSES * RECORD_SAMPLES)
struct record_steps {
    const struct stp_plan *plan;
    uint32_t count, before, repeated;
    uint32_t first, length; /* of the passes that are repeated */
    uint32_t first_sample, first_pass;
    uint32_t chunk;    /* of points */
    bool keeps;        /* the images hold what the chunks before left */
    uint32_t exchange; /* pass that processes exchange by after it; RECORD_NO_PASS: none */
    bool loops;        /* turns of one sample's loop */
    bool last;         /* outputs are handed to the host after it */
};
uint32_t record_parts(const struct stp_plan *plan);
struct record_steps record_steps(const struct stp_plan *plan, uint32_t part);
/* The pass of step i, and the sample it is for. */
uint32_t record_step(const struct record_steps *steps, uint32_t i, uint32_t *sample);

/* walk.c: records one part of one tile; nothing is allocated, submitted or waited for. timed: a
 * full barrier and a timestamp after every step. skip_barrier: leaves out the barrier before that
 * pass (tests prove with it that validation sees). */
#define RECORD_NO_PASS UINT32_MAX
/* Every stage that our passes use. */
#define RECORD_STAGES                                                                              \
    (VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |               \
     VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |      \
     VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT |                                                 \
     VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |    \
     VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT)
/* Every stage of the host's own commands, as core Vulkan 1.3 has them; not by ALL_COMMANDS, which
 * the layers' best practices warn of. */
#define RECORD_HOST_STAGES                                                                         \
    (RECORD_STAGES | VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT |                                        \
     VK_PIPELINE_STAGE_2_PRE_RASTERIZATION_SHADERS_BIT)
/* From all that was written in RECORD_STAGES to all that they do next. */
VkMemoryBarrier2 record_everything(void);
void record_walk(struct record_frame *frame, VkCommandBuffer commands, const struct plan_tile *tile,
                 uint32_t part, bool timed, uint32_t skip_barrier);

/* picture.c: outputs of one tile into the picture. */
enum stp_result record_picture(const struct stp_env *env, const struct stp_plan *plan,
                               struct stp_image **image);
enum stp_result record_read_back(const struct stp_env *env, struct record_frame *frame,
                                 const struct stp_scene *scene, const struct plan_tile *tile,
                                 struct stp_image *image);

/* What the host reads of an output; NULL: the plan has none. First whatever was written there is
 * made visible to it. */
const void *record_output(const struct record_frame *frame, enum plan_slot slot);
enum stp_result record_invalidate(const struct stp_env *env, struct record_frame *frame);

/* deep.c: nothing is allocated where the plan keeps no layers. */
enum stp_result record_deep_create(const struct stp_env *env, const struct stp_plan *plan,
                                   struct record_deep *deep);
void record_deep_destroy(struct record_deep *deep);
/* A tile is rendered once for each window of its rays' layers: begin, take after every part that
 * was run (loops: it was turns of mending), and again while there is a next. */
void record_deep_begin(struct record_deep *deep, const struct plan_tile *tile);
enum stp_result record_deep_take(const struct stp_env *env, struct record_frame *frame,
                                 const struct plan_tile *tile, bool loops);
bool record_deep_next(struct record_deep *deep);
enum stp_result record_deep_finish(const struct stp_env *env, const struct record_deep *deep,
                                   struct stp_image *image);

/* run.c: all tiles once, from record to fence; *ms leaves reading back apart. image NULL:
 * nothing is read. The scene must have been uploaded. */
enum stp_result record_run(const struct stp_env *env, struct record_frame *frame,
                           const struct stp_scene *scene, struct stp_image *image, double *ms,
                           double *read_back_ms);
/* A warm frame of a changed camera: with what the CPU does for it, and nothing is read. */
enum stp_result record_again(const struct stp_env *env, struct record_frame *frame,
                             const struct stp_scene *scene, double *ms);
/* What the plan's shaders were chosen for must be enabled on this device. */
enum stp_result record_check_features(const struct stp_env *env, const struct stp_context *context,
                                      const struct stp_plan *plan);
/* `repeat` more frames: their times, and those of their passes. */
enum stp_result record_time(const struct stp_env *env, struct record_frame *frame,
                            const struct stp_scene *scene, unsigned repeat,
                            struct stp_render_stats *stats);
/* More frames, 1 to RECORD_PROFILED, timed pass by pass: stats->pass gets the medians. */
#define RECORD_PROFILED 5
enum stp_result record_profile(const struct stp_env *env, struct record_frame *frame,
                               const struct stp_scene *scene, unsigned frames,
                               struct stp_render_stats *stats);

#endif
