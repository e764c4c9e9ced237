/* A host in plain C: its own instance, device, images and triangles, with stipple's pictures
 * between them. Knows stipple by its public headers only. */
#ifndef TEST_HOST_ENGINE_H
#define TEST_HOST_ENGINE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <stipple/stipple.h>
#include <stipple/vulkan.h>
#include <vulkan/vulkan.h>

#define ENGINE_FRAMES 3 /* in flight */

struct engine {
    struct stp_env env;
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    struct stp_vulkan_features features;
    VkCommandPool pool[ENGINE_FRAMES];
    VkCommandBuffer commands[ENGINE_FRAMES];
    VkFence fence[ENGINE_FRAMES];
    VkPipelineLayout layout;
    unsigned messages, lines; /* of validation; errors and warnings of stipple */
    char last[1024];
};

/* masked: recommended features, by name, that are left off; NULL: none. Validation,
 * synchronisation and best-practice validation on, unless "validation" is masked too, to time. */
void engine_open(struct engine *engine, const char *masked);
/* Fails on any validation message. */
void engine_close(struct engine *engine);
struct stp_import engine_import(const struct engine *engine);
struct stp_context *engine_context(struct engine *engine);

struct engine_image {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view, layer[2]; /* of all aspects; of each layer */
    VkFormat format;
    VkImageAspectFlags aspects;
    uint32_t width, height;
};
void engine_image_open(struct engine *engine, VkFormat format, uint32_t width, uint32_t height,
                       struct engine_image *image);
void engine_image_close(struct engine *engine, struct engine_image *image);
/* The image as stipple takes it: in the general layout before and after. */
struct stp_host_image engine_target(const struct engine_image *image);
/* From anything to the general layout, cleared. */
void engine_clear(VkCommandBuffer commands, const struct engine_image *image,
                  const VkClearValue *value);
/* Waits for frame `i`, then begins its commands. */
VkCommandBuffer engine_begin(struct engine *engine, unsigned i);
void engine_submit(struct engine *engine, unsigned i);
void engine_finish(struct engine *engine);
/* Texels of a colour image, or the depths of D32 and D16, in the general layout; free(). */
void *engine_read(struct engine *engine, const struct engine_image *image, size_t texel);

/* A pipeline for triangles of one colour, depth tested and written. */
VkPipeline engine_pipeline(struct engine *engine, VkFormat color, VkFormat depth, bool reversed);
/* One triangle in clip space. */
struct engine_triangle {
    float clip[3][4];
    float color[4];
};
void engine_draw(struct engine *engine, VkCommandBuffer commands, VkPipeline pipeline,
                 const struct engine_image *color, const struct engine_image *depth,
                 const struct engine_triangle *triangle);

#endif
