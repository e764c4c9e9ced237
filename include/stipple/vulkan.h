/* stipple in somebody else's Vulkan frame: the only header that names Vulkan. docs/host.md walks
 * through it.
 *
 *   stp_vulkan_wanted_features -> (the host makes its device) -> stp_context_import
 *   stp_resident_create -> stp_resident_record_upload -> stp_resident_release_staging
 *   stp_frame_create, one a frame in flight -> stp_frame_record, every frame
 *
 * Nothing of the host's is destroyed, submitted to, waited on or assumed: commands are recorded
 * into command buffers that the host has begun, outside of rendering, on a queue family with
 * graphics and compute. Objects must outlive the commands that were recorded with them.
 *
 * A lost device shows in the host's own submissions and waits, and as STP_ERROR_DEVICE of what
 * creates; everything can be destroyed all the same, before the device. What creates fails with
 * STP_ERROR_MEMORY or STP_ERROR_DEVICE_MEMORY where memory is out, and leaves nothing behind. To
 * destroy what submitted commands still use is the host's mistake, and nothing here can see it.
 *
 * Threads: a context takes one create or destroy at a time; stp_frame_record may run on any number
 * of threads at once, each with its own frame and command buffer. */
#ifndef STIPPLE_VULKAN_H
#define STIPPLE_VULKAN_H

#include <stipple/render.h>
#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Features to enable at device creation, chained: core.pNext is v12, its pNext v13. Do not copy the
 * struct once it is chained; call the function again instead. */
struct stp_vulkan_features {
    VkPhysicalDeviceFeatures2 core;
    VkPhysicalDeviceVulkan12Features v12;
    VkPhysicalDeviceVulkan13Features v13;
};
/* What is required, and what is recommended and `supported` (as vkGetPhysicalDeviceFeatures2 fills
 * the same chain); NULL: all that is recommended. No device extension is needed. */
STP_API void stp_vulkan_wanted_features(const struct stp_vulkan_features *supported,
                                        struct stp_vulkan_features *features);

/* The same as data, by the names of the specification. */
struct stp_vulkan_feature {
    const char *name;      /* "bufferDeviceAddress" */
    bool required;         /* else recommended */
    const char *otherwise; /* what is done without it; NULL when required */
};
STP_API const struct stp_vulkan_feature *stp_vulkan_feature_list(unsigned *count);

/* Device memory of the host's: at `offset` of `memory`. mapped: where that is in the host's address
 * space; needed for types that are host-visible, else NULL. */
struct stp_device_memory {
    VkDeviceMemory memory;
    VkDeviceSize offset;
    void *mapped;
    void *handle; /* the host's own, handed back */
};
/* Both NULL: vkAllocateMemory. Called while objects are created and destroyed, never by recording.
 * The memory must have been allocated with VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT. */
struct stp_device_allocator {
    void *user;
    VkResult (*allocate)(void *user, const VkMemoryRequirements *requirements, uint32_t memory_type,
                         struct stp_device_memory *memory);
    void (*release)(void *user, const struct stp_device_memory *memory);
};

struct stp_import {
    PFN_vkGetInstanceProcAddr get_instance_proc_addr; /* every function is loaded through it */
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t queue_family; /* where the commands will run: graphics and compute */
    uint32_t api_version;  /* of VkApplicationInfo: at least VK_API_VERSION_1_3 */
    /* As enabled at device creation: the chain of VkDeviceCreateInfo, VkPhysicalDeviceFeatures2
     * with the 1.2 and 1.3 structs or those of the single features. Read during the call only. */
    const VkPhysicalDeviceFeatures2 *features;
    /* The host's, or VK_NULL_HANDLE; not one made with EXTERNALLY_SYNCHRONIZED: pipelines are
     * compiled on several threads (those of stp_env) at once. */
    VkPipelineCache pipeline_cache;
    struct stp_device_allocator allocator;
    unsigned mask_features; /* enum stp_feature, or-ed: used as if they were not enabled */
};
/* A context on the host's device. A feature that is required and not enabled is an error whose
 * one line names all that are; what is recommended and not enabled is done another way.
 * stp_render does not take such a context. stp_context_destroy leaves what is the host's alone. */
STP_API enum stp_result stp_context_import(const struct stp_env *env,
                                           const struct stp_import *import,
                                           struct stp_context **context);

/* A scene on the device: what every frame of it shares. */
struct stp_resident;

/* Splats in a buffer of the host's, used without a copy, for points that move: an array of
 *   float position[3], radius; float normal[3]; uint32_t tag;
 * 32 bytes each, positions relative to facts.origin, tag = group | STP_SPLAT_* | object << 8, in
 * the scene's canonical order when the picture is to have the same bits for any order of points.
 * The group, below STP_MAX_GROUPS, is what stp_scene_group found; it counts for method deferred,
 * and must be below the groups of the plan's scene. Opacities beside 0 and 1 stay the scene's. */
#define STP_SPLAT_INVISIBLE 64u  /* of a transparent scene: opacity 0, the splat is not drawn */
#define STP_SPLAT_OPAQUE    128u /* of a transparent scene: opacity 1, it hides what is behind */

struct stp_resident_params {
    VkBuffer splats; /* VK_NULL_HANDLE: one of our own. Usage: storage, shader device address */
    VkDeviceSize splats_offset; /* a multiple of 16 */
};
/* plan: of this scene as it now is. It decides which of the scene's buffers are there: a frame's
 * plan may be another one, of the same scene, grouping and epsilon, for as long as it reads no
 * others; else stp_frame_record refuses it (the splats' order by group: deferred --path raster
 * only; the environment, where it is seen). The scene is not needed afterwards. Its materials come
 * with the resident and with every plan: a frame whose plan has another one is refused, too. */
STP_API enum stp_result stp_resident_create(const struct stp_env *env, struct stp_context *context,
                                            const struct stp_scene *scene,
                                            const struct stp_plan *plan,
                                            const struct stp_resident_params *params,
                                            struct stp_resident **resident);
/* Records the copies from staging memory, once and before that is released, and a barrier that
 * makes them visible to later commands. On a transfer queue: its family as `from`, and
 * stp_resident_record_acquire afterwards on the context's family, with a semaphore between; else
 * from = the context's family. */
STP_API enum stp_result stp_resident_record_upload(const struct stp_env *env,
                                                   struct stp_resident *resident,
                                                   VkCommandBuffer commands, uint32_t from);
STP_API void stp_resident_record_acquire(struct stp_resident *resident, VkCommandBuffer commands,
                                         uint32_t from);
/* Once the upload has completed on the device: gives the staging memory back. The acquisition may
 * be recorded before or after. */
STP_API void stp_resident_release_staging(struct stp_resident *resident);
/* The buffer of splats, as stp_resident_params says, for a host that rewrites them: its own writes
 * need its own barriers, to VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT and shader reads. */
STP_API VkBuffer stp_resident_splats(const struct stp_resident *resident, VkDeviceSize *bytes);
STP_API void stp_resident_destroy(struct stp_resident **resident);

/* What one frame in flight needs: scratch, pipelines, descriptors. */
struct stp_frame;

enum stp_composite {
    STP_COMPOSITE_OVER = 0, /* premultiplied, over what the target holds */
    STP_COMPOSITE_REPLACE,  /* every pixel of the area is written: premultiplied, 0 where nothing */
};

struct stp_host_frame_params {
    VkFormat color_format; /* RGBA16F, RGBA32F, RGBA8 or BGRA8 (UNORM or SRGB), B10G11R11 */
    VkFormat depth_format; /* D32, D24S8, D32S8, X8D24, D16; UNDEFINED: nothing is hidden. The image
                              of a frame whose scene is transparent: usage TRANSFER_SRC too */
    bool depth_reversed;   /* nearer is larger */
    bool depth_read_only;  /* test against the host's depth, do not write it */
    enum stp_composite composite;
    /* Scratch memory of the host's, of stp_frame_scratch's size; no other frame may use it until
     * the commands recorded with this one are done, or begin. NULL: from the context's allocator.
     */
    const struct stp_device_memory *scratch;
};
/* What the scratch memory of a frame of that plan and those params needs; memoryTypeBits is 0 where
 * no one type, or no one allocation, holds all of it. */
STP_API enum stp_result stp_frame_scratch(const struct stp_env *env, struct stp_context *context,
                                          const struct stp_plan *plan,
                                          const struct stp_host_frame_params *params,
                                          VkMemoryRequirements *requirements);

/* plan: for the largest size that will be drawn; copied. Its outputs stay on the device. All
 * pipelines are compiled now, none later; frames of plans that are alike share them. */
STP_API enum stp_result stp_frame_create(const struct stp_env *env, struct stp_context *context,
                                         const struct stp_plan *plan,
                                         const struct stp_host_frame_params *params,
                                         struct stp_frame **frame);
STP_API void stp_frame_destroy(struct stp_frame **frame);

/* One level and layer of an image of the host's. */
struct stp_host_image {
    VkImage image;
    VkImageView
        view; /* 2D, of that level and layer; color: of the format of stp_host_frame_params */
    VkImageLayout before, after; /* `after` not UNDEFINED; both may be the same */
    uint32_t level, layer;
};
/* Recording waits for, and makes visible, everything earlier on the queue: full memory barriers
 * stand at both ends, so the host need not add its own; but for stages that only extensions have,
 * as ray tracing. */
struct stp_targets {
    struct stp_host_image color;
    struct stp_host_image depth;  /* view VK_NULL_HANDLE: as if there were none */
    int32_t x, y;                 /* where the picture's top-left pixel goes: anywhere */
    uint32_t width, height;       /* of the images: nothing is written outside */
    double depth_near, depth_far; /* of the host's projection, not the camera's; far may be
                                     INFINITY. 0 < near < far; orthographic: near < far */
};
/* Records one picture of the resident: no allocation, submission or wait. camera: any size up to
 * the plan's, orthographic or not as the plan's. Several residents in one picture are several
 * calls, each with its own frame, or with frames that share scratch memory. */
STP_API enum stp_result stp_frame_record(const struct stp_env *env, struct stp_frame *frame,
                                         const struct stp_resident *resident,
                                         const struct stp_camera *camera,
                                         const struct stp_targets *targets,
                                         VkCommandBuffer commands);

#ifdef __cplusplus
}
#endif
#endif
