#include "plan/plan.h"

#include <string.h>

#include "base/json.h"
#include "base/log.h"

void stp_limits_lavapipe(struct stp_limits *limits)
{
    *limits = (struct stp_limits){
        .device = "llvmpipe",
        .driver = "llvmpipe, Mesa 22.3.6",
        .features = STP_FEATURE_INT64_ATOMICS | STP_FEATURE_VERTEX_LAYER |
                    STP_FEATURE_FLOAT32_BLEND | STP_FEATURE_INT64,
        .heap_bytes = (uint64_t)1 << 31,
        .max_allocation = (uint64_t)1 << 31,
        .max_image_size = 16384,
        .max_image_layers = 2048,
        .max_workgroups = 65535,
        .processor = 1,
    };
}
