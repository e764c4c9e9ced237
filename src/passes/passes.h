/* Passes of a plan as Vulkan commands: one file a kind of pass. Sees the plan and the resident
 * buffers, never the scene. */
#ifndef STP_PASSES_PASSES_H
#define STP_PASSES_PASSES_H

#include <stddef.h>

#include "gpu/gpu.h"
#include "plan/plan.h"
#include "shared/push.h"

/* The resources of a plan on a device, by their index in the plan. */
struct pass_resources {
    struct gpu_buffer buffer[PLAN_MAX_RESOURCES];
    struct gpu_image image[PLAN_MAX_RESOURCES];
    VkBufferView texels[PLAN_MAX_RESOURCES]; /* of buffers that are fetched as texels */
    struct gpu_buffer constants;             /* the frame block */
    struct pass_points {
        uint32_t first, count;
    } points;                     /* pyramid: those in the buffers */
    VkPipelineLayout layout;      /* not owned */
    const struct pass_host *host; /* of a host's frame, while it is recorded */
    const struct stp_targets *targets;
    VkDescriptorPool pool;
    VkDescriptorSet set;
};

/* Struct stp_push; then, of a host's frame, struct stp_push_host. */
#define PASS_PUSH_FIRST  offsetof(struct stp_push, push_first)
#define PASS_PUSH_SAMPLE offsetof(struct stp_push, push_sample)
#define PASS_PUSH_COUNT  offsetof(struct stp_push, push_count)
#define PASS_PUSH_DRAW   offsetof(struct stp_push, push_factor)
#define PASS_PUSH_HOST   sizeof(struct stp_push)
#define PASS_PUSH_STAGES                                                                           \
    (VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT)

#define PASS_MOST_COLORS 4

/* constants.c: how many times as wide and high as the tile its viewport is, in powers of two, which
 * change no bit of where triangles fall. Where one vertex of thousands lies outside the viewport, a
 * software device sends the triangles of all of them through its clipper, which takes three times
 * as long. */
float pass_guard(const struct stp_plan *plan, const struct plan_tile *tile);

/* constants.c: the frame block of one tile, addresses filled in. */
struct stp_frame_constants pass_constants(const struct stp_plan *plan,
                                          const struct pass_resources *resources,
                                          const struct plan_tile *tile);

/* shaders.c */
VkResult pass_module(struct stp_context *context, const struct stp_plan *plan,
                     enum plan_shader shader, VkShaderModule *module);
/* The specialisation of a pass; `values` and `entries` outlive the info. */
struct pass_specialization {
    uint32_t values[PLAN_CONSTANTS];
    VkSpecializationMapEntry entries[PLAN_CONSTANTS];
    VkSpecializationInfo info;
};
void pass_specialize(const struct stp_plan *plan, const struct plan_pass *pass,
                     struct pass_specialization *specialization);

/* What the pipeline of a pass depends on beside the plan's constants and the layout; all 0: it has
 * none. */
#define PASS_KEY_WORDS        (5 + PASS_RASTER_KEY_WORDS)
#define PASS_RASTER_KEY_WORDS (3 + PASS_MOST_COLORS)
void pass_key(const struct stp_plan *plan, const struct plan_pass *pass,
              uint32_t key[PASS_KEY_WORDS]);
void pass_raster_key(const struct stp_plan *plan, const struct plan_pass *pass,
                     uint32_t key[PASS_RASTER_KEY_WORDS]);

/* One pipeline a pass; VK_NULL_HANDLE for passes that need none. */
enum stp_result pass_pipeline(const struct stp_env *env, struct stp_context *context,
                              const struct stp_plan *plan, const struct plan_pass *pass,
                              VkPipelineLayout layout, VkPipeline *pipeline);
enum stp_result pass_compute_pipeline(const struct stp_env *env, struct stp_context *context,
                                      const struct stp_plan *plan, const struct plan_pass *pass,
                                      VkPipelineLayout layout, VkPipeline *pipeline);
enum stp_result pass_raster_pipeline(const struct stp_env *env, struct stp_context *context,
                                     const struct stp_plan *plan, const struct plan_pass *pass,
                                     VkPipelineLayout layout, VkPipeline *pipeline);

/* Records one pass; barriers and descriptor sets are the caller's. */
void pass_record(struct stp_context *context, VkCommandBuffer commands, const struct stp_plan *plan,
                 const struct plan_pass *pass, const struct plan_tile *tile,
                 const struct pass_resources *resources, VkPipeline pipeline);
void pass_record_transfer(struct stp_context *context, VkCommandBuffer commands,
                          const struct stp_plan *plan, const struct plan_pass *pass,
                          const struct plan_tile *tile, const struct pass_resources *resources);
void pass_record_compute(struct stp_context *context, VkCommandBuffer commands,
                         const struct stp_plan *plan, const struct plan_pass *pass,
                         const struct plan_tile *tile, const struct pass_resources *resources,
                         VkPipeline pipeline);
void pass_record_raster(struct stp_context *context, VkCommandBuffer commands,
                        const struct stp_plan *plan, const struct plan_pass *pass,
                        const struct plan_tile *tile, const struct pass_resources *resources,
                        VkPipeline pipeline);

VkFormat pass_format(enum plan_format format);
bool pass_is_image(enum plan_format format);
bool pass_is_texels(enum plan_format format);

/* raster.c: what graphics pipelines differ in. pass NULL: as the plan says. */
enum pass_blend { PASS_BLEND_NONE, PASS_BLEND_ADD, PASS_BLEND_OVER /* premultiplied */ };
struct pass_graphics {
    enum plan_shader vertex, fragment;
    uint32_t color_count;
    VkFormat color[PASS_MOST_COLORS], depth; /* UNDEFINED: no depth */
    enum pass_blend blend;
    bool depth_write;
    VkCompareOp compare;
};
enum stp_result pass_graphics_pipeline(const struct stp_env *env, struct stp_context *context,
                                       const struct stp_plan *plan, const struct plan_pass *pass,
                                       const struct pass_graphics *graphics,
                                       VkPipelineLayout layout, VkPipeline *pipeline);

/* host.c: the finished picture into a host's images. */
struct pass_host {
    VkFormat color_format, depth_format;
    bool depth_reversed, depth_read_only, replace;
};
float pass_host_most(VkFormat color);                 /* largest finite value; 0: not supported */
VkImageAspectFlags pass_host_aspects(VkFormat depth); /* 0: not supported */
enum plan_host_depth pass_host_depth(VkFormat depth); /* what its depth aspect is copied as */
enum stp_result pass_host_pipeline(const struct stp_env *env, struct stp_context *context,
                                   const struct stp_plan *plan, const struct pass_host *host,
                                   VkPipelineLayout layout, VkPipeline *pipeline);
/* Before a tile's passes: what they, and pass_record_host, push of resources->host and targets. */
void pass_push_host(struct stp_context *context, VkCommandBuffer commands,
                    const struct stp_plan *plan, const struct plan_tile *tile,
                    const struct pass_resources *resources);
/* COPY_DEPTH: the tile's part of the host's depth, which is an attachment before and after. */
void pass_record_copy_depth(struct stp_context *context, VkCommandBuffer commands,
                            const struct stp_plan *plan, const struct plan_pass *pass,
                            const struct plan_tile *tile, const struct pass_resources *resources);
void pass_record_host(struct stp_context *context, VkCommandBuffer commands,
                      const struct plan_tile *tile, const struct pass_resources *resources,
                      VkPipeline pipeline);

#endif
