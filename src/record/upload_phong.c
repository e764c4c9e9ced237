/* Ellipses with normal fields and clip lines, to the device. */
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "record/record.h"
#include "scene/scene.h"

enum stp_result record_upload_ellipses(const struct stp_env *env, struct record_frame *frame,
                                       const struct splats *splats, struct gpu_buffer *buffer)
{
    struct stp_phong_gpu *out = mem_alloc(splats->count, sizeof *out);
    if (!out)
        return log_no_memory(env, splats->count * sizeof *out, "staging of ellipses");
    for (size_t i = 0; i < splats->count; i++) {
        const struct stp_phong_splat *p = &splats->phong[i];
        memcpy(out[i].u, p->u, sizeof p->u);
        memcpy(out[i].radius, p->radius, sizeof p->radius);
        memcpy(out[i].field, p->field, sizeof p->field);
    }
    enum stp_result result =
        gpu_upload(env, frame->context, buffer, out, splats->count * sizeof *out);
    mem_free(out);
    return result;
}

enum stp_result record_upload_clips(const struct stp_env *env, struct record_frame *frame,
                                    const struct splats *splats, struct gpu_buffer *buffer)
{
    struct stp_clip_gpu *out = mem_alloc(splats->count, sizeof *out);
    if (!out)
        return log_no_memory(env, splats->count * sizeof *out, "staging of clip lines");
    for (size_t i = 0; i < splats->count; i++) {
        const struct stp_phong_splat *p = &splats->phong[i];
        out[i] = (struct stp_clip_gpu){ { { 0, 0, 1 }, { 0, 0, 1 } }, p->reflex };
        memcpy(out[i].line, p->clip, p->clips * sizeof p->clip[0]);
    }
    enum stp_result result =
        gpu_upload(env, frame->context, buffer, out, splats->count * sizeof *out);
    mem_free(out);
    return result;
}
