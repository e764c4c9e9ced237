/* Which scene, and which state of it: what plans, and copies on a device, were made of. */
#ifndef STP_SCENE_VERSION_H
#define STP_SCENE_VERSION_H

#include <stdint.h>

struct scene_version {
    uint64_t scene;   /* tells apart all scenes that a process makes */
    uint32_t content; /* splats, kernels and the environment, once prepared */
    uint32_t groups;  /* of stp_scene_group */
    uint32_t cover;   /* of stp_scene_cover */
};

#endif
