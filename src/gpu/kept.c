#include "gpu/gpu.h"

/* What has a user is never destroyed here, and does not count. */
static void destroy_idle(struct stp_context *context, unsigned most)
{
    unsigned idle = 0;
    struct gpu_kept **link = &context->kept;
    while (*link) {
        struct gpu_kept *kept = *link;
        if (kept->users > 0 || ++idle <= most) {
            link = &kept->next;
            continue;
        }
        *link = kept->next;
        kept->destroy(context, kept);
    }
}

void gpu_keep(struct stp_context *context, struct gpu_kept *kept)
{
    kept->users = 1;
    kept->next = context->kept;
    context->kept = kept;
}

void gpu_use_kept(struct stp_context *context, struct gpu_kept *kept)
{
    struct gpu_kept **link = &context->kept;
    while (*link != kept)
        link = &(*link)->next;
    *link = kept->next;
    kept->next = context->kept;
    context->kept = kept;
    kept->users++;
}

void gpu_leave_kept(struct stp_context *context, struct gpu_kept *kept)
{
    kept->users--;
    destroy_idle(context, GPU_MOST_IDLE);
}

void gpu_trim(struct stp_context *context)
{
    destroy_idle(context, 0);
}
