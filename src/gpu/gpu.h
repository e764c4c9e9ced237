/* Vulkan plumbing: instance, device, memory, pipelines. No algorithm lives here. */
#ifndef STP_GPU_GPU_H
#define STP_GPU_GPU_H

#include "gpu/functions.h"
#include <stipple/vulkan.h>

/* An instance of our own, with its loader. */
struct gpu_instance {
    void *library; /* dlopen handle */
    struct gpu_global global;
    struct gpu_instance_functions vk;
    VkInstance handle;
    VkDebugUtilsMessengerEXT messenger;
    bool validate;
};

/* Device memory: ours, the host's allocator's, or a part of a block. */
struct gpu_memory_part {
    struct stp_device_memory where;
    VkDeviceSize bytes;
    bool ours, coherent;
};

/* Memory that is handed out from its beginning. part.ours: allocated by gpu_block_create. */
struct gpu_block {
    struct gpu_memory_part part;
    VkDeviceSize used;
};

struct gpu_buffer {
    VkBuffer handle;
    struct gpu_memory_part memory;
    VkDeviceAddress address;
    void *mapped; /* NULL: not host-visible */
    bool coherent;
};

/* A copy that an imported context has yet to record. */
struct gpu_pending {
    struct gpu_buffer staging;
    VkBuffer target;
    VkBufferCopy region;
};
#define GPU_MOST_PENDING 16

/* What a later stage leaves with a context, for its next call that needs the same. */
struct gpu_kept {
    struct gpu_kept *next;
    unsigned users;
    void (*destroy)(struct stp_context *context, struct gpu_kept *kept);
};

struct stp_context {
    struct gpu_instance instance; /* imported: the host's handle, no library */
    bool imported;                /* no queue, no commands, no fence of our own */
    struct stp_device_allocator allocator;
    VkDeviceSize granularity; /* bufferImageGranularity */
    uint32_t pending_count;
    struct gpu_pending pending[GPU_MOST_PENDING];
    VkPhysicalDevice physical;
    VkDevice device;
    struct gpu_device_functions vk;
    VkQueue queue;
    uint32_t family;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
    VkPipelineCache cache;
    struct gpu_kept *kept; /* the last used first */
    VkPhysicalDeviceMemoryProperties memory;
    struct stp_limits limits;
    double timestamp_ms;       /* of one tick; 0: no timestamps */
    uint64_t timestamp_mask;   /* ticks wrap at as many bits as the queue has */
    uint64_t allocated, peak;  /* bytes of device memory */
    unsigned messages;         /* of the validation layers */
    const struct stp_env *env; /* of the call that is running; NULL between calls */
};

/* gpu/instance.c */
enum stp_result gpu_instance_create(const struct stp_env *env, bool validate, void *user,
                                    struct gpu_instance *instance);
void gpu_instance_destroy(struct gpu_instance *instance);
/* All of them; free with mem_free. */
enum stp_result gpu_instance_devices(const struct stp_env *env, const struct gpu_instance *instance,
                                     VkPhysicalDevice **devices, uint32_t *count);

/* gpu/device.c: what a device offers. `lacks` gets the names of everything that is missing. */
bool gpu_device_survey(const struct gpu_instance *instance, VkPhysicalDevice device,
                       struct stp_device_info *info);
enum stp_result gpu_device_create(const struct stp_env *env, struct stp_context *context);
/* The name of a function that the loader lacks, or NULL. */
const char *gpu_device_functions(struct stp_context *context);
void gpu_device_memory(struct stp_context *context); /* heaps, types and granularity */

/* gpu/features.c: what is asked of a device. */
void gpu_features_chain(struct stp_vulkan_features *features);
/* Appends the names of what is not on; returns how many. */
unsigned gpu_features_lacking(struct stp_vulkan_features *features, bool required, char *lacks,
                              size_t size);
/* All that is required, and what is recommended and among `flags`, enum stp_feature. */
void gpu_features_wanted(unsigned flags, struct stp_vulkan_features *features);
/* What is on, as enum stp_feature. */
unsigned gpu_features_flags(struct stp_vulkan_features *features);
/* The same of a host's chain; an error, that names them, when a required one is off. */
enum stp_result gpu_features_enabled(const struct stp_env *env,
                                     const VkPhysicalDeviceFeatures2 *chain, const char *device,
                                     unsigned *flags);

/* Logs the call and the VkResult; the stp_result that it maps to. */
enum stp_result gpu_error(const struct stp_env *env, VkResult result, const char *call);

/* gpu/kept.c. Of what has no user the last GPU_MOST_IDLE stay. */
#define GPU_MOST_IDLE 16
void gpu_keep(struct stp_context *context, struct gpu_kept *kept); /* with one user */
void gpu_use_kept(struct stp_context *context, struct gpu_kept *kept);
void gpu_leave_kept(struct stp_context *context, struct gpu_kept *kept);
/* Destroys all that has no user. */
void gpu_trim(struct stp_context *context);

enum gpu_memory {
    GPU_DEVICE,    /* fast for the device; mapped only where that costs nothing */
    GPU_UPLOAD,    /* mapped, written by the host */
    GPU_READ_BACK, /* mapped and cached */
};

/* zero bytes gives a buffer of 16. */
enum stp_result gpu_buffer_create(const struct stp_env *env, struct stp_context *context,
                                  VkDeviceSize bytes, enum gpu_memory kind, const char *what,
                                  struct gpu_buffer *buffer);
/* One allocation for many resources; resources that were placed in it go first. */
enum stp_result gpu_block_create(const struct stp_env *env, struct stp_context *context,
                                 const VkMemoryRequirements *needs, enum gpu_memory kind,
                                 const char *what, struct gpu_block *block);
void gpu_block_destroy(struct stp_context *context, struct gpu_block *block);
/* Adds a resource to what a block must hold; the sum starts with all memoryTypeBits. */
void gpu_needs_add(const struct stp_context *context, const VkMemoryRequirements *needs,
                   VkMemoryRequirements *sum);
/* Of device memory, from the block. */
enum stp_result gpu_buffer_place(const struct stp_env *env, struct stp_context *context,
                                 VkDeviceSize bytes, struct gpu_block *block, const char *what,
                                 struct gpu_buffer *buffer);
/* What gpu_buffer_place would ask of a block. */
VkMemoryRequirements gpu_buffer_needs(const struct stp_context *context, VkDeviceSize bytes);
void gpu_buffer_destroy(struct stp_context *context, struct gpu_buffer *buffer);

struct gpu_image {
    VkImage handle;
    struct gpu_memory_part memory;
    VkImageView all;     /* 2D array of every layer */
    VkImageView *layers; /* one view a layer; NULL when there is one layer */
    uint32_t layer_count;
    VkImageAspectFlags aspect;
};
/* block NULL: memory of its own. */
enum stp_result gpu_image_create(const struct stp_env *env, struct stp_context *context,
                                 VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                                 struct gpu_block *block, const char *what,
                                 struct gpu_image *image);
VkMemoryRequirements gpu_image_needs(const struct stp_context *context, VkFormat format,
                                     uint32_t width, uint32_t height, uint32_t layers);
void gpu_image_destroy(struct stp_context *context, struct gpu_image *image);

/* One-off command buffers: begin, record, submit and wait. */
enum stp_result gpu_begin(const struct stp_env *env, struct stp_context *context);
enum stp_result gpu_submit_and_wait(const struct stp_env *env, struct stp_context *context);

/* Copies into a device buffer, through staging where it is not mapped; an imported context, which
 * may not submit, notes the copy among its pending ones. Zero bytes are nothing to do. */
enum stp_result gpu_upload(const struct stp_env *env, struct stp_context *context,
                           struct gpu_buffer *buffer, const void *data, size_t bytes);
enum stp_result gpu_upload_at(const struct stp_env *env, struct stp_context *context,
                              struct gpu_buffer *buffer, size_t offset, const void *data,
                              size_t bytes);
/* The same of what the host computes: gpu_fill_begin says where to write count * size bytes, and
 * gpu_fill_end sends them. Where the host sees the device's memory that is the buffer itself, and
 * nothing is staged; so only write. NULL: no memory, logged. gpu_fill_drop in the place of
 * gpu_fill_end sends nothing: filling has failed. */
void *gpu_fill_begin(const struct stp_env *env, const struct gpu_buffer *buffer, size_t count,
                     size_t size, const char *what);
enum stp_result gpu_fill_end(const struct stp_env *env, struct stp_context *context,
                             struct gpu_buffer *buffer, void *filled, size_t bytes);
void gpu_fill_drop(const struct gpu_buffer *buffer, void *filled);
/* The other way; what wrote the buffer has been waited for. */
enum stp_result gpu_download(const struct stp_env *env, struct stp_context *context,
                             const struct gpu_buffer *buffer, size_t offset, void *data,
                             size_t bytes);
/* The host's own view of it; NULL: there is none that is coherent. */
void *gpu_view(const struct gpu_buffer *buffer);

#endif
