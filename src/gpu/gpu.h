/* Vulkan plumbing: instance, device, memory, pipelines. No algorithm lives here. */
#ifndef STP_GPU_GPU_H
#define STP_GPU_GPU_H

#include <stipple/render.h>

#include "gpu/functions.h"

/* An instance of our own, with its loader. */
struct gpu_instance {
    void *library; /* dlopen handle */
    struct gpu_global global;
    struct gpu_instance_functions vk;
    VkInstance handle;
    VkDebugUtilsMessengerEXT messenger;
    bool validate;
};

struct stp_context {
    struct gpu_instance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    struct gpu_device_functions vk;
    VkQueue queue;
    uint32_t family;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
    VkPipelineCache cache;
    VkPhysicalDeviceMemoryProperties memory;
    struct stp_limits limits;
    double timestamp_ms;       /* of one tick; 0: no timestamps */
    uint64_t allocated, peak;  /* bytes of device memory */
    unsigned messages;         /* of the validation layers */
    const struct stp_env *env; /* of the call that is running; NULL between calls */
};

/* gpu/instance.c */
enum stp_result gpu_instance_create(const struct stp_env *env, bool validate, void *user,
                                    struct gpu_instance *instance);
void gpu_instance_destroy(struct gpu_instance *instance);
/* Up to `capacity` handles; *count gets how many there are. */
enum stp_result gpu_instance_devices(const struct stp_env *env, const struct gpu_instance *instance,
                                     VkPhysicalDevice *devices, uint32_t capacity, uint32_t *count);

/* gpu/device.c: what a device offers. `lacks` gets the names of everything that is missing. */
bool gpu_device_survey(const struct gpu_instance *instance, VkPhysicalDevice device,
                       struct stp_device_info *info);
enum stp_result gpu_device_create(const struct stp_env *env, struct stp_context *context);

/* Logs the call and the VkResult; the stp_result that it maps to. */
enum stp_result gpu_error(const struct stp_env *env, VkResult result, const char *call);

enum gpu_memory {
    GPU_DEVICE,    /* fast for the device; mapped only where that costs nothing */
    GPU_UPLOAD,    /* mapped, written by the host */
    GPU_READ_BACK, /* mapped and cached */
};

struct gpu_buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    VkDeviceAddress address;
    VkDeviceSize bytes;
    void *mapped; /* NULL: not host-visible */
    bool coherent;
};
/* zero bytes gives a buffer of 16. */
enum stp_result gpu_buffer_create(const struct stp_env *env, struct stp_context *context,
                                  VkDeviceSize bytes, enum gpu_memory kind, const char *what,
                                  struct gpu_buffer *buffer);
void gpu_buffer_destroy(struct stp_context *context, struct gpu_buffer *buffer);

struct gpu_image {
    VkImage handle;
    VkDeviceMemory memory;
    VkDeviceSize bytes;
    VkImageView all;     /* 2D array of every layer */
    VkImageView *layers; /* one view a layer; NULL when there is one layer */
    uint32_t layer_count;
    VkImageAspectFlags aspect;
};
enum stp_result gpu_image_create(const struct stp_env *env, struct stp_context *context,
                                 VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                                 const char *what, struct gpu_image *image);
void gpu_image_destroy(struct stp_context *context, struct gpu_image *image);

/* One-off command buffers: begin, record, submit and wait. */
enum stp_result gpu_begin(const struct stp_env *env, struct stp_context *context);
enum stp_result gpu_submit_and_wait(const struct stp_env *env, struct stp_context *context);

/* Copies into a device buffer, through staging where it is not mapped. */
enum stp_result gpu_upload(const struct stp_env *env, struct stp_context *context,
                           struct gpu_buffer *buffer, const void *data, size_t bytes);
enum stp_result gpu_upload_at(const struct stp_env *env, struct stp_context *context,
                              struct gpu_buffer *buffer, size_t offset, const void *data,
                              size_t bytes);
/* The other way; what wrote the buffer has been waited for. */
enum stp_result gpu_download(const struct stp_env *env, struct stp_context *context,
                             const struct gpu_buffer *buffer, size_t offset, void *data,
                             size_t bytes);
/* The host's own view of it; NULL: there is none that is coherent. */
void *gpu_view(const struct gpu_buffer *buffer);

#endif
