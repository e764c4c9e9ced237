/* What the tests of hosts share: an engine, a scene, a camera and two images; plans, residents and
 * frames that must succeed. */
#ifndef TEST_HOST_STAGE_H
#define TEST_HOST_STAGE_H

#include "engine.h"

#define WIDTH  61
#define HEIGHT 47

struct stage {
    struct engine engine;
    struct stp_context *context;
    struct stp_scene *scene;
    struct stp_camera camera;
    struct engine_image color, depth;
};

struct stp_scene *stage_ball(struct engine *e, size_t n, bool colors, double size, float opacity);
struct stp_camera stage_view(const struct stp_scene *scene, uint32_t width, uint32_t height,
                             double azimuth);
struct stp_plan *stage_plan(struct engine *e, struct stp_context *context, struct stp_scene *scene,
                            const struct stp_camera *camera,
                            const struct stp_render_params *params);
struct stp_resident *stage_resident(struct engine *e, struct stp_context *context,
                                    const struct stp_scene *scene, const struct stp_plan *plan,
                                    const struct stp_resident_params *params);
struct stp_frame *stage_frame(struct engine *e, struct stp_context *context,
                              const struct stp_plan *plan,
                              const struct stp_host_frame_params *params);
struct stp_image *stage_offline(struct engine *e, const struct stp_scene *scene,
                                const struct stp_camera *camera,
                                const struct stp_render_params *params);
const float *stage_plane(const struct stp_image *image, const char *name);
void stage_same(const struct stp_image *image, const float *texels, const char *what);
void stage_open(struct stage *s, VkFormat color, VkFormat depth, const char *masked);
void stage_close(struct stage *s);
struct stp_targets stage_targets(const struct stage *s);
void stage_clear(VkCommandBuffer commands, struct stage *s, const float *color, float depth);

#endif
