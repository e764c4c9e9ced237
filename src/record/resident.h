/* The scene's buffers of a plan, apart from any frame. */
#ifndef STP_RECORD_RESIDENT_H
#define STP_RECORD_RESIDENT_H

#include "record/record.h"

struct stp_resident {
    struct stp_context *context;
    struct gpu_block block;
    struct gpu_buffer buffer[PLAN_BUFFER_SLOTS]; /* of PLAN_SCENE, by slot */
    uint64_t bytes[PLAN_BUFFER_SLOTS];           /* that the plan asked of each */
    bool has[PLAN_BUFFER_SLOTS];
    VkBuffer borrowed; /* the host's splats; may be null */
    uint64_t splats;
    struct scene_version version;     /* of the scene that was uploaded */
    struct stp_material_gpu material; /* of the first object; of the only one frames have it, too */
    bool recorded;
    uint32_t copies; /* that the upload records; their targets stay known */
    bool staged;     /* their staging memory is still there */
    struct gpu_pending pending[GPU_MOST_PENDING];
};

/* resident.c: is it drawn into a host's frame? Logs why not. */
enum stp_result resident_check_method(const struct stp_env *env, const struct stp_plan *plan);

#endif
