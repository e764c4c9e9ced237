/* The reference's output planes. */
#ifndef STP_REFERENCE_PLANES_H
#define STP_REFERENCE_PLANES_H

#include <stipple/image.h>

#include "reference/surface.h"

/* Planes that are not wanted are NULL. */
struct planes {
    float *color[4], *z, *normal[3], *albedo[3], *position[3];
    float *weight, *fragments, *coverage, *layers;
    uint32_t *id;
};

/* A pixel over its samples. */
struct pixel {
    struct vec3 color; /* premultiplied, summed */
    double alpha;      /* summed */
    uint32_t hits;
    struct surface nearest; /* of the hit sample of least depth */
};

/* An image of the planes that `aovs` asks for, with the camera and the scene's origin. */
enum stp_result planes_create(const struct stp_env *env, const struct stp_scene *scene,
                              const struct stp_camera *camera, unsigned aovs,
                              struct stp_image **image, struct planes *planes);

void planes_write(const struct planes *planes, const struct view *view, size_t at,
                  const struct pixel *pixel);

/* dome.c: eye-dome shading and the background, once every pixel's depth is known. */
void planes_finish(const struct stp_env *env, const struct planes *planes, const struct view *view,
                   const struct stp_render_params *params);

#endif
