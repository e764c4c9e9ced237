/* Points, and what goes with them, to the device: all at once, or chunk by chunk. */
#include <math.h>

#include "base/thread.h"
#include "prepare/stream.h"
#include "record/record.h"
#include "scene/scene.h"

uint32_t record_octahedral(const float n[3])
{
    float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]), x = n[0] / sum, y = n[1] / sum;
    if (sum == 0)
        return STP_NO_NORMAL;
    if (n[2] < 0) {
        float fold = (1 - fabsf(y)) * (x >= 0 ? 1.f : -1.f);
        y = (1 - fabsf(x)) * (y >= 0 ? 1.f : -1.f);
        x = fold;
    }
    uint32_t u = (uint32_t)lrintf(x * 32767) & 0xffff, v = (uint32_t)lrintf(y * 32767) & 0xffff;
    return u | v << 16;
}

struct point_texel {
    float position[3];
    uint32_t normal;
};

struct packing {
    const struct splats *splats;
    size_t first;
    void *out;
};

static void pack_points(void *context, size_t begin, size_t end, unsigned)
{
    const struct packing *p = context;
    const struct splats *s = p->splats;
    struct point_texel *out = p->out;
    for (size_t i = begin; i < end; i++) {
        const double *position = s->position[p->first + i];
        for (int k = 0; k < 3; k++)
            out[i].position[k] = (float)(position[k] - s->origin[k]);
        out[i].normal = record_octahedral(s->normal[p->first + i]);
    }
}

static void pack_objects(void *context, size_t begin, size_t end, unsigned)
{
    const struct packing *p = context;
    uint32_t *out = p->out;
    for (size_t i = begin; i < end; i++)
        out[i] = p->splats->object ? p->splats->object[p->first + i] : 0;
}

static enum stp_result upload_packed(const struct stp_env *env, struct record_frame *frame,
                                     struct packing *packing, range_fn pack, size_t count,
                                     size_t size, struct gpu_buffer *buffer)
{
    packing->out = gpu_fill_begin(env, buffer, count, size, "points");
    if (!packing->out)
        return STP_ERROR_MEMORY;
    parallel_for(env, count, 16384, pack, packing);
    return gpu_fill_end(env, frame->context, buffer, packing->out, count * size);
}

bool record_upload_points(const struct stp_env *env, struct record_frame *frame,
                          const struct splats *splats, uint32_t resource, size_t first,
                          size_t count, enum stp_result *result)
{
    struct gpu_buffer *buffer = &frame->resources.buffer[resource];
    struct packing packing = { splats, first, NULL };
    enum plan_slot slot = frame->plan->resource[resource].slot;
    if (slot != PLAN_TEXEL_POINTS && slot != PLAN_TEXEL_RADII && slot != PLAN_COLORS &&
        slot != PLAN_OBJECTS && slot != PLAN_TEXEL_CLUSTERS)
        return false;
    if (count == 0)
        return true;
    if (slot == PLAN_TEXEL_POINTS)
        *result = upload_packed(env, frame, &packing, pack_points, count,
                                sizeof(struct point_texel), buffer);
    else if (slot == PLAN_OBJECTS)
        *result = upload_packed(env, frame, &packing, pack_objects, count, 4, buffer);
    else if (slot == PLAN_TEXEL_CLUSTERS)
        *result = record_upload_clusters(env, frame, splats, first, count, buffer);
    else if (slot == PLAN_COLORS)
        *result = gpu_upload(env, frame->context, buffer, splats->color[first], count * 12);
    else
        *result = gpu_upload(env, frame->context, buffer, &splats->radius[first], count * 4);
    return true;
}

static enum stp_result upload_range(const struct stp_env *env, struct record_frame *frame,
                                    const struct splats *splats, uint32_t first, uint32_t count)
{
    enum stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < frame->plan->resource_count; i++)
        record_upload_points(env, frame, splats, i, first, count, &result);
    return result;
}

/* The chunk of the file that holds the point; a chunk of the device is in one of them. */
static uint32_t chunk_of_file(const struct scene_stream *stream, uint32_t point)
{
    uint32_t chunk = 0;
    while (stream->chunk[chunk + 1] <= point)
        chunk++;
    return chunk;
}

enum stp_result record_upload_chunk(const struct stp_env *env, struct record_frame *frame,
                                    const struct stp_scene *scene, uint32_t chunk)
{
    const struct stp_plan *plan = frame->plan;
    uint32_t first = plan->chunk[chunk], count = plan->chunk[chunk + 1] - first;
    struct splats splats;
    if (!scene->stream)
        return upload_range(env, frame, &scene->splats, first, count);
    uint32_t from = chunk_of_file(scene->stream, first);
    enum stp_result result = stream_splats(env, scene, from, &splats, NULL);
    if (result != STP_OK)
        return result;
    result = upload_range(env, frame, &splats, first - scene->stream->chunk[from], count);
    splats_release(&splats);
    return result;
}
