/* Passes of a plan as Vulkan commands: one file a kind of pass. Sees the plan and the resident
 * buffers, never the scene. */
#ifndef STP_PASSES_PASSES_H
#define STP_PASSES_PASSES_H

#include "gpu/gpu.h"
#include "plan/plan.h"

/* The resources of a plan on a device, by their index in the plan. */
struct pass_resources {
    struct gpu_buffer buffer[PLAN_MAX_RESOURCES];
    struct gpu_image image[PLAN_MAX_RESOURCES];
    struct gpu_buffer constants; /* the frame block */
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
};

/* Push constants (glsl/lib/common.glsl): offsets, and the size of all. The sample's is set by the
 * walk, the others by a draw. */
#define PASS_PUSH_FIRST  0
#define PASS_PUSH_SAMPLE 4
#define PASS_PUSH_DRAW   8
#define PASS_PUSH_BYTES  16

struct pass_words {
    const uint32_t *words;
    size_t bytes;
};
struct pass_words pass_shader(enum plan_shader shader, bool float64);

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

/* One pipeline a pass; VK_NULL_HANDLE for passes that need none. */
enum stp_result pass_pipeline(const struct stp_env *env, struct stp_context *context,
                              const struct stp_plan *plan, const struct plan_pass *pass,
                              const struct pass_resources *resources, VkPipeline *pipeline);
enum stp_result pass_compute_pipeline(const struct stp_env *env, struct stp_context *context,
                                      const struct stp_plan *plan, const struct plan_pass *pass,
                                      const struct pass_resources *resources, VkPipeline *pipeline);
enum stp_result pass_raster_pipeline(const struct stp_env *env, struct stp_context *context,
                                     const struct stp_plan *plan, const struct plan_pass *pass,
                                     const struct pass_resources *resources, VkPipeline *pipeline);

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

#endif
