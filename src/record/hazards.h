/* What a pass must wait for, from the accesses that passes declare. */
#ifndef STP_RECORD_HAZARDS_H
#define STP_RECORD_HAZARDS_H

#include "gpu/gpu.h"
#include "plan/plan.h"

struct hazard_scope {
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
};

/* Of one resource. */
struct hazard {
    struct hazard_scope written; /* by whom last */
    struct hazard_scope visible; /* to whom a barrier has shown that since */
    VkPipelineStageFlags2 read;  /* since it was written */
    uint64_t layers;             /* written last; of what has no layers all bits */
};

/* Starts as zeros, when everything before has been waited for. */
struct hazards {
    struct hazard of[PLAN_MAX_RESOURCES];
};

/* Adds to `memory` what the pass must wait for, nothing (no stages) where it need not wait, and
 * notes its accesses for those that follow. A second reader of what a barrier has already shown to
 * its stages does not wait, nor does a draw to a layer of an attachment that nobody else has
 * touched. */
void hazards_add(struct hazards *hazards, const struct stp_plan *plan, const struct plan_pass *pass,
                 VkMemoryBarrier2 *memory);

#endif
