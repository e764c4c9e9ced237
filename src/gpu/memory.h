/* Device memory under buffers and images. */
#ifndef STP_GPU_MEMORY_H
#define STP_GPU_MEMORY_H

#include "gpu/gpu.h"

enum stp_result memory_allocate(const struct stp_env *env, struct stp_context *context,
                                const VkMemoryRequirements *needs, enum gpu_memory kind,
                                const char *what, struct gpu_memory_part *part);
/* The next part of a block. */
struct gpu_memory_part memory_take(const struct stp_context *context, struct gpu_block *block,
                                   const VkMemoryRequirements *needs);
/* Of what memory_allocate gave; a part of a block is only forgotten. */
void memory_release(struct stp_context *context, struct gpu_memory_part *part);

#endif
