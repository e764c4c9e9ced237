/* Ellipses with normal fields and clip lines, to the device. */
#include <string.h>

#include "record/record.h"
#include "scene/scene.h"

enum stp_result record_upload_ellipses(const struct stp_env *env, struct record_frame *frame,
                                       const struct splats *splats, struct gpu_buffer *buffer)
{
    struct stp_phong_gpu *out = gpu_fill_begin(env, buffer, splats->count, sizeof *out, "ellipses");
    if (!out)
        return STP_ERROR_MEMORY;
    for (size_t i = 0; i < splats->count; i++) {
        const struct stp_phong_splat *p = &splats->phong[i];
        memcpy(out[i].u, p->u, sizeof p->u);
        memcpy(out[i].radius, p->radius, sizeof p->radius);
        memcpy(out[i].field, p->field, sizeof p->field);
    }
    return gpu_fill_end(env, frame->context, buffer, out, splats->count * sizeof *out);
}

enum stp_result record_upload_clips(const struct stp_env *env, struct record_frame *frame,
                                    const struct splats *splats, struct gpu_buffer *buffer)
{
    struct stp_clip_gpu *out =
        gpu_fill_begin(env, buffer, splats->count, sizeof *out, "clip lines");
    if (!out)
        return STP_ERROR_MEMORY;
    for (size_t i = 0; i < splats->count; i++) {
        const struct stp_phong_splat *p = &splats->phong[i];
        out[i] = (struct stp_clip_gpu){ { { 0, 0, 1 }, { 0, 0, 1 } }, p->reflex };
        memcpy(out[i].line, p->clip, p->clips * sizeof p->clip[0]);
    }
    return gpu_fill_end(env, frame->context, buffer, out, splats->count * sizeof *out);
}
