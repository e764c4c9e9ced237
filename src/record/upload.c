#include "record/record.h"

#include <string.h>

#include "base/thread.h"
#include "prepare/axis_region.h"
#include "prepare/environment.h"
#include "scene/optics.h"
#include "scene/scene.h"
#include "scene/volume.h"

_Static_assert(STP_SPLAT_INVISIBLE == STP_TAG_INVISIBLE && STP_SPLAT_OPAQUE == STP_TAG_OPAQUE &&
                   STP_MAX_GROUPS == STP_TAG_GROUP + 1,
               "hosts fill in what shaders read");

struct packing {
    const struct splats *splats;
    float (*out)[8];
};

/* Two vectors a splat: position relative to the origin and radius; normal and tag. */
static void pack(void *context, size_t begin, size_t end, unsigned)
{
    const struct packing *p = context;
    const struct splats *s = p->splats;
    for (size_t i = begin; i < end; i++) {
        float *out = p->out[i];
        for (int k = 0; k < 3; k++) {
            out[k] = (float)(s->position[i][k] - s->origin[k]);
            out[4 + k] = s->normal[i][k];
        }
        out[3] = s->radius[i];
        uint32_t tag =
            (s->group ? s->group[i] : 0u) | (s->object ? (uint32_t)s->object[i] << 8 : 0u);
        if (s->opacity)
            tag |= s->opacity[i] == 0 ? STP_TAG_INVISIBLE : s->opacity[i] == 1 ? STP_TAG_OPAQUE : 0;
        memcpy(&out[7], &tag, 4);
    }
}

static enum stp_result upload_splats(const struct stp_env *env, struct record_frame *frame,
                                     const struct splats *splats, struct gpu_buffer *buffer)
{
    struct packing packing = { splats, NULL };
    packing.out = gpu_fill_begin(env, buffer, splats->count, sizeof *packing.out, "splats");
    if (!packing.out)
        return STP_ERROR_MEMORY;
    parallel_for(env, splats->count, 16384, pack, &packing);
    return gpu_fill_end(env, frame->context, buffer, packing.out,
                        splats->count * sizeof *packing.out);
}

struct kernel_packing {
    const struct stp_scene *scene;
    float (*out)[8];
};

/* Two vectors a kernel: centre relative to the origin and tau; colour and normal. */
static void pack_kernels(void *context, size_t begin, size_t end, unsigned)
{
    const struct kernel_packing *p = context;
    const struct kernels *k = &p->scene->volume->kernels;
    const struct grid *grid = &p->scene->volume->grid;
    for (size_t i = begin; i < end; i++) {
        uint32_t at[3], normal = STP_NO_NORMAL;
        float *out = p->out[i];
        voxel_place(grid, k->voxel[i], at);
        for (int a = 0; a < 3; a++) {
            double place = grid->origin[a] + at[a] * grid->spacing[a];
            out[a] = (float)(place - p->scene->splats.origin[a]);
            out[4 + a] = k->color[i][a];
        }
        out[3] = k->tau[i];
        if (k->normal)
            normal = record_octahedral(k->normal[i]);
        memcpy(&out[7], &normal, 4);
    }
}

static enum stp_result upload_kernels(const struct stp_env *env, struct record_frame *frame,
                                      const struct stp_scene *scene, struct gpu_buffer *buffer)
{
    size_t count = scene->volume->kernels.count;
    struct kernel_packing packing = { scene, NULL };
    packing.out = gpu_fill_begin(env, buffer, count, sizeof *packing.out, "kernels");
    if (!packing.out)
        return STP_ERROR_MEMORY;
    parallel_for(env, count, 16384, pack_kernels, &packing);
    return gpu_fill_end(env, frame->context, buffer, packing.out, count * sizeof *packing.out);
}

static enum stp_result upload_materials(const struct stp_env *env, struct record_frame *frame,
                                        const struct stp_scene *scene, struct gpu_buffer *buffer)
{
    struct stp_material_gpu *out =
        gpu_fill_begin(env, buffer, scene->object_count, sizeof *out, "materials");
    if (!out)
        return STP_ERROR_MEMORY;
    for (unsigned i = 0; i < scene->object_count; i++)
        out[i] = plan_material(frame->plan, &scene->objects[i]);
    return gpu_fill_end(env, frame->context, buffer, out, scene->object_count * sizeof *out);
}

static enum stp_result upload_optics(const struct stp_env *env, struct record_frame *frame,
                                     const struct stp_scene *scene, struct gpu_buffer *buffer)
{
    struct stp_optics_gpu *out =
        gpu_fill_begin(env, buffer, scene->object_count, sizeof *out, "optics");
    if (!out)
        return STP_ERROR_MEMORY;
    for (unsigned i = 0; i < scene->object_count; i++) {
        const struct stp_optics *o = &scene->objects[i].optics;
        out[i].level =
            optics_matter(o) ? environment_level_at(&scene->environment, o->roughness) : -1;
        for (int k = 0; k < 3; k++) {
            out[i].ior[k] = o->ior[k];
            out[i].reflectance[k] = o->reflectance[k];
            out[i].absorption[k] = o->absorption[k] * o->thickness;
        }
    }
    return gpu_fill_end(env, frame->context, buffer, out, scene->object_count * sizeof *out);
}

static enum stp_result upload_order(const struct stp_env *env, struct record_frame *frame,
                                    const struct splats *splats, struct gpu_buffer *buffer)
{
    uint32_t next[STP_MAX_GROUPS];
    memcpy(next, frame->plan->group_first, sizeof next);
    uint32_t *order =
        gpu_fill_begin(env, buffer, splats->count, sizeof *order, "the order of groups");
    if (!order)
        return STP_ERROR_MEMORY;
    for (size_t i = 0; i < splats->count; i++)
        order[next[splats->group[i]]++] = (uint32_t)i;
    return gpu_fill_end(env, frame->context, buffer, order, splats->count * sizeof *order);
}

enum stp_result record_upload(const struct stp_env *env, struct record_frame *frame,
                              const struct stp_scene *scene)
{
    enum stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < frame->plan->resource_count; i++) {
        struct gpu_buffer *buffer = &frame->resources.buffer[i];
        if (!buffer->handle) /* a host's own */
            continue;
        size_t points = frame->plan->chunk_count ? 0 : scene->splats.count;
        if (record_upload_points(env, frame, &scene->splats, i, 0, points, &result))
            continue;
        switch (frame->plan->resource[i].slot) {
        case PLAN_SPLATS:
            result = frame->plan->constant[PLAN_AXIS_SHAPE] == AXIS_ELLIPSOIDS
                         ? upload_ellipsoids(env, frame, scene, buffer)
                     : scene->volume ? upload_kernels(env, frame, scene, buffer)
                                     : upload_splats(env, frame, &scene->splats, buffer);
            break;
        case PLAN_OPACITIES:
            result = gpu_upload(env, frame->context, buffer, scene->splats.opacity,
                                scene->splats.count * 4);
            break;
        case PLAN_ELLIPSES:
            result = record_upload_ellipses(env, frame, &scene->splats, buffer);
            break;
        case PLAN_CLIPS:
            result = record_upload_clips(env, frame, &scene->splats, buffer);
            break;
        case PLAN_MATERIALS:
            result = upload_materials(env, frame, scene, buffer);
            break;
        case PLAN_OBJECT_OPTICS:
            result = upload_optics(env, frame, scene, buffer);
            break;
        case PLAN_ENVIRONMENT:
            result = gpu_upload(env, frame->context, buffer, scene->environment.texel,
                                scene->environment.texel_count * sizeof *scene->environment.texel);
            break;
        case PLAN_ORDER:
            if (plan_covers(frame->plan))
                result = record_upload_homes(env, frame, scene, buffer);
            else if (frame->plan->method != STP_METHOD_AXIS)
                result = upload_order(env, frame, &scene->splats, buffer);
            break;
        default:
            break;
        }
    }
    if (result == STP_OK && frame->plan->method == STP_METHOD_AXIS)
        result = record_lists(env, frame, &frame->plan->axis, &frame->plan->axis_blocks);
    if (result == STP_OK && frame->share)
        result = record_ghosts(env, frame);
    return result;
}
